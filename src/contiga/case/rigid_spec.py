"""Prescribed motions of a case that carry bodies, or nodes that they drive."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr

from contiga.case.curve_spec import units_of_case
from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.spec import BY_KIND, Axis, ExistingFile, InstanceSpec, MotionSpec, Vector
from contiga.dynamics.prescribed import BodyMotion, Combine, Fixed, Poses, Rotate, Translate
from contiga.errors import CaseError
from contiga.io.units import Units

Table = list[list[float]]


class FixedSpec(InstanceSpec[BodyMotion], MotionSpec):
    """`{ kind = "fixed" }`."""

    makes = Fixed
    kind: Literal["fixed"] = "fixed"

    def describe(self) -> str:
        """Describe the table in words."""
        return "fixed"


class TranslateSpec(InstanceSpec[BodyMotion], MotionSpec):
    """`{ kind = "translate", table = [[t, dx, dy, dz], …] }`."""

    makes = Translate
    kind: Literal["translate"] = "translate"
    table: Table

    def describe(self) -> str:
        """Describe the table in words."""
        return f"moved along a table of {len(self.table)} rows, {_span(self.table)}"


class RotateSpec(InstanceSpec[BodyMotion], MotionSpec):
    """`{ kind = "rotate", axis, centre, table = [[t, degrees], …] }`."""

    makes = Rotate
    kind: Literal["rotate"] = "rotate"
    table: Table
    axis: Axis = "z"
    centre: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])

    def describe(self) -> str:
        """Describe the table in words."""
        return f"turned about {self.axis} through {self.centre}, {_span(self.table)}"


class PosesSpec(InstanceSpec[Poses], MotionSpec):
    """`{ kind = "poses", file = "poses.csv" }`, or its rows t, x, y, z, qw, qx, qy, qz as `table`.

    Lengths are in the case's unit, or in that which the header of the file says.
    """

    kind: Literal["poses"] = "poses"
    file: ExistingFile | None = None
    table: Table | None = None
    _units: Units = PrivateAttr()

    @staticmethod
    def makes(file: str | None, table: Table | None, units: tuple[str, str]) -> Poses:
        """Return the poses of the file or of the table; CaseError unless one of them is given."""
        if (file is None) == (table is None):
            raise CaseError("must have exactly one of the keys file or table")
        if file is None:
            return Poses.from_table(table or [])
        return Poses.from_csv(file, units=units)

    def model_post_init(self, context: dict[str, Any] | None) -> None:
        """Keep the units of the case that is being read."""
        self._units = units_of_case(context)

    def arguments(self) -> dict[str, Any]:
        """Return the arguments, with length and time unit of the case."""
        length, _, time = self._units
        return {**super().arguments(), "units": (length, time)}

    def describe(self) -> str:
        """Describe the table in words."""
        times = self.instance.times
        span = f"t = {times[0]:g} to {times[-1]:g}"
        return f"{len(times)} poses from {self.file or 'a table'}, {span}"


class CombineSpec(InstanceSpec[BodyMotion], MotionSpec):
    """`{ kind = "combine", motions = [ … ] }`: motions applied in their order, about world axes."""

    makes = Combine
    kind: Literal["combine"] = "combine"
    motions: Annotated[list[RigidMotionSpec], Field(min_length=1)]

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Combine` takes."""
        return {"motions": [spec.instance for spec in self.motions]}

    def describe(self) -> str:
        """Describe the table in words."""
        return ", then ".join(spec.describe() for spec in self.motions)


RigidMotionSpec = Annotated[
    FixedSpec | TranslateSpec | RotateSpec | PosesSpec | CombineSpec, BY_KIND
]
PrescribedMotionSpec = Annotated[RigidMotionSpec | VelocitySpec | AccelerationSpec, BY_KIND]

CombineSpec.model_rebuild()


def _span(table: Table) -> str:
    return f"t = {table[0][0]:g} to {table[-1][0]:g}"
