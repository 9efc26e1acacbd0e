"""The `mass` of a body in a case: its shape's own at a density, or numbers."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.spec import Positive, Spec, TellApart, Vector
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
    the placed geometry. The entries are those of the tensor: Ixy = −∫ x y dm. A closed body may
    leave out either: its own centre, and the inertia of its shape scaled to the total, as if it
    were homogeneous (about `centre` where that is given). An open body must have both.
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
            measured = self._shape_properties(body)
            centre = measured.centre if centre is None else centre
            inertia = measured.inertia if inertia is None else inertia
        return MassProperties(self.total, centre, inertia)

    def _shape_properties(self, body: Master) -> MassProperties:
        """Return the mass properties of the shape, scaled to the total."""
        if not body.closed:
            lacking = [key for key in ("centre", "inertia") if getattr(self, key) is None]
            raise CaseError(
                "is missing: the body is open and has none of its own",
                where=lacking[0],
                allowed=", ".join(f"{key} = […]" for key in lacking),
                remedy="Give the mass of an open body as total, centre and inertia",
            )
        measured = body.mass_properties(1.0)
        return MassProperties(
            self.total, measured.centre, measured.inertia * (self.total / measured.mass)
        )

    def describe(self) -> str:
        """Describe the table in words."""
        given = [key for key in ("centre", "inertia") if getattr(self, key) is not None]
        measured = [key for key in ("centre", "inertia") if key not in given]
        return (
            f"{self.total:g}"
            + (f", {' and '.join(given)} given" if given else "")
            + (f", {' and '.join(measured)} of its shape" if measured else "")
        )


MassSpec = Annotated[DensityMassSpec | TotalMassSpec, TellApart("density", "total")]
