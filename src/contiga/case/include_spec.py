"""The `include` tables of a case: files that hold a part of it, a dummy, a seat or a wheel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from contiga.case.placed_spec import TransformEntry, matrix_of
from contiga.case.posture import ABOUT, Coordinates
from contiga.case.spec import ExistingFile, Spec, Vector, is_number
from contiga.dynamics.joints import KINDS, Joint
from contiga.errors import CaseError
from contiga.io.naming import NAME
from contiga.records import FloatArray


def _steps_of(value: Any) -> Any:
    """Return a table as a list of steps, rotation before translation; lists as they are.

    Raises
    ------
    CaseError
        A step is a scale.
    """
    if isinstance(value, dict) and set(value) == {"rotate", "translate"}:
        return [{"rotate": value["rotate"]}, {"translate": value["translate"]}]
    steps = [value] if isinstance(value, dict) else value
    for step in steps if isinstance(steps, list) else ():
        if isinstance(step, dict) and "scale" in step:
            raise CaseError(
                "masses and joints cannot be scaled",
                found="scale",
                allowed="steps of translate and rotate",
            )
    return steps


def _number_or_coordinates(value: Any) -> Any:
    """Return `value`; CaseError unless its numbers are finite, and `about` a vector of three."""
    # A union of types would give a message for each type.
    coordinates = value if isinstance(value, dict) else {"": value}
    for key, coordinate in coordinates.items():
        count = 3 if key == ABOUT else 1
        is_vector = isinstance(coordinate, list) and key == ABOUT
        numbers = coordinate if is_vector else [coordinate]
        if len(numbers) != count or not all(is_number(x) and math.isfinite(x) for x in numbers):
            raise CaseError(
                "must be a coordinate, or a table of coordinates",
                where=key or None,
                found=coordinate,
                allowed="-1.2, { travel = 30 }, or { cone = 0.1, about = [0, 1, 0] }",
            )
    return value


Steps = Annotated[list[TransformEntry], BeforeValidator(_steps_of)]
JointValue = Annotated[float | dict[str, Any], BeforeValidator(_number_or_coordinates)]


class IncludeSpec(Spec):
    """An `[[include]]`: a file, and the placement of its parts."""

    file: ExistingFile
    prefix: Annotated[str, Field(pattern=f"^({NAME.pattern})?[ _-]?$")] = ""
    """Text before each name that the file defines."""
    placement: Steps = Field(default_factory=list)
    """Steps that move all of it, after its joints."""
    velocity: Vector | None = None
    """Velocity of its free bodies, nodes and belts that give none, world axes."""
    joints: dict[str, JointValue] = Field(default_factory=dict)
    """Coordinates by the names that joints have in the file: the posture."""
    root: str | None = None
    """Body that joints do not move; the ground of a file with joints to it, else its first body."""

    @property
    def matrix(self) -> FloatArray:
        """The steps of `placement` as one (4, 4) matrix."""
        return matrix_of(self.placement) if self.placement else np.eye(4)

    def coordinates(self, joints: Mapping[str, Joint]) -> dict[str, Coordinates]:
        """Return tables of coordinates by joint; a number is that of the only coordinate.

        A number for a name that is not in `joints` gives an empty table.

        Raises
        ------
        CaseError
            A number for a joint of several coordinates.
        """
        named: dict[str, Coordinates] = {}
        for name, value in self.joints.items():
            if isinstance(value, dict):
                named[name] = value
                continue
            joint = joints.get(name)
            keys = [] if joint is None else list(KINDS[joint.kind].coordinates)
            if joint is not None and len(keys) != 1:
                raise CaseError(
                    f"a {joint.kind} joint has {len(keys) or 'no'} coordinates",
                    where=f"joints.{name}",
                    found=value,
                    allowed="{ " + ", ".join(f"{key} = …" for key in keys) + " }",
                )
            named[name] = dict.fromkeys(keys, value)
        return named
