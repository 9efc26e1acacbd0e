"""The `mass` of a body in a case: its shape's own at a density, or numbers."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.spec import DiscriminatedBy, Positive, Spec, Vector
from contiga.errors import CaseError
from contiga.masters.protocol import Master
from contiga.records import FloatArray, MassProperties
from contiga.rigid.inertia import check_inertia

Entries = Annotated[list[float], Field(min_length=6, max_length=6)]
"""Entries Ixx, Iyy, Izz, Ixy, Iyz, Ixz."""


class DensityMassSpec(Spec):
    """`{ density }` of a closed body, mass over length³ in the units of the case."""

    density: Positive

    def properties(self, body: Master) -> MassProperties:
        """Return the mass properties of the placed body.

        Raises
        ------
        InputError
            As `Body.mass_properties`: the body is open, or its normals point inward.
        """
        return body.mass_properties(self.density)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"its volume at a density of {self.density:g}"


class TotalMassSpec(Spec):
    """`{ total, centre, inertia = [Ixx, Iyy, Izz, Ixy, Iyz, Ixz] }`.

    `centre` is the centre of mass, `inertia` is about it, both in the axes and from the origin of
    the placed geometry. The entries are components of the tensor: Ixy = −∫ x y dm. A closed body
    may leave out either: it then has the centre of its shape, and its inertia scaled to
    the total, as if it were homogeneous (about `centre` if that is given). An open body must have
    both.
    """

    total: Positive
    centre: Vector | None = None
    inertia: Entries | None = None

    @model_validator(mode="after")
    def _a_solid_can_have_it(self) -> Self:
        if self.inertia is not None:
            self._tensor(self.inertia)
        return self

    @staticmethod
    def _tensor(entries: list[float]) -> FloatArray:
        xx, yy, zz, xy, yz, xz = entries
        return check_inertia([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], "inertia")

    def properties(self, body: Master) -> MassProperties:
        """Return the mass properties of the placed body.

        Raises
        ------
        CaseError
            The body is open, and centre or inertia is missing.
        InputError
            As `Body.mass_properties`: the normals of a closed body point inward.
        """
        centre = None if self.centre is None else np.array(self.centre)
        inertia = None if self.inertia is None else self._tensor(self.inertia)
        if centre is None or inertia is None:
            if not body.closed:
                missing = [key for key in ("centre", "inertia") if getattr(self, key) is None]
                raise CaseError(
                    "is missing: the body is open and has none of its own",
                    where=missing[0],
                    allowed=", ".join(f"{key} = […]" for key in missing),
                    remedy="Give the mass of an open body as total, centre and inertia",
                )
            shape = body.mass_properties(1.0)
            centre = shape.centre if centre is None else centre
            if inertia is None:
                inertia = shape.inertia * (self.total / shape.mass)
        return MassProperties(self.total, centre, inertia)

    def describe(self) -> str:
        """Describe the table in words."""
        keys = [key for key in ("centre", "inertia") if getattr(self, key) is not None]
        keys_of_shape = [key for key in ("centre", "inertia") if key not in keys]
        return (
            f"{self.total:g}"
            + (f", {' and '.join(keys)} given" if keys else "")
            + (f", {' and '.join(keys_of_shape)} of its shape" if keys_of_shape else "")
        )


MassSpec = Annotated[DensityMassSpec | TotalMassSpec, DiscriminatedBy("density", "total")]
