"""Motions of a case that carry bodies, or nodes that they drive, as they are told."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.spec import Axis, ExistingFile, MotionSpec, Vector, by_kind
from contiga.dynamics.prescribed import BodyMotion, Combine, Fixed, Poses, Rotate, Translate
from contiga.errors import CaseError

Table = list[list[float]]


class _RigidSpec(MotionSpec):
    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _motion_is_possible(self) -> Self:
        assert self.motion is not None
        return self


class FixedSpec(_RigidSpec):
    """`{ kind = "fixed" }`."""

    kind: Literal["fixed"] = "fixed"

    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        return Fixed()

    def describe(self) -> str:
        """In words."""
        return "fixed"


class TranslateSpec(_RigidSpec):
    """`{ kind = "translate", table = [[t, dx, dy, dz], …] }`."""

    kind: Literal["translate"] = "translate"
    table: Table

    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        return Translate(self.table)

    def describe(self) -> str:
        """In words."""
        return f"moved along a table of {len(self.table)} rows, {_span(self.table)}"


class RotateSpec(_RigidSpec):
    """`{ kind = "rotate", axis, centre, table = [[t, degrees], …] }`."""

    kind: Literal["rotate"] = "rotate"
    table: Table
    axis: Axis = "z"
    centre: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])

    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        return Rotate(self.table, self.axis, self.centre)

    def describe(self) -> str:
        """In words."""
        return f"turned about {self.axis} through {self.centre}, {_span(self.table)}"


class PosesSpec(_RigidSpec):
    """`{ kind = "poses", file = "poses.csv" }`, or its rows t, x, y, z, qw, qx, qy, qz as `table`.

    Lengths are in the case's unit.
    """

    kind: Literal["poses"] = "poses"
    file: ExistingFile | None = None
    table: Table | None = None

    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        if (self.file is None) == (self.table is None):
            raise CaseError("must have exactly one of the keys file or table")
        if self.file is not None:
            return Poses.from_csv(self.file)
        return Poses.from_table(self.table or [])

    def describe(self) -> str:
        """In words."""
        motion = self.motion
        assert isinstance(motion, Poses)
        span = f"t = {motion.times[0]:g} to {motion.times[-1]:g}"
        return f"{len(motion.times)} poses from {self.file or 'a table'}, {span}"


class CombineSpec(_RigidSpec):
    """`{ kind = "combine", motions = [ … ] }`: applied in their order, about world axes."""

    kind: Literal["combine"] = "combine"
    motions: Annotated[list[RigidMotionSpec], Field(min_length=1)]

    @cached_property
    def motion(self) -> BodyMotion:
        """The motion."""
        return Combine([spec.motion for spec in self.motions])

    def describe(self) -> str:
        """In words."""
        return ", then ".join(spec.describe() for spec in self.motions)


RIGID = (FixedSpec, TranslateSpec, RotateSpec, PosesSpec, CombineSpec)
if TYPE_CHECKING:
    RigidMotionSpec = FixedSpec | TranslateSpec | RotateSpec | PosesSpec | CombineSpec
    ToldMotionSpec = RigidMotionSpec | VelocitySpec | AccelerationSpec
else:
    RigidMotionSpec = by_kind(*RIGID)
    ToldMotionSpec = by_kind(*RIGID, VelocitySpec, AccelerationSpec)

CombineSpec.model_rebuild()


def _span(table: Table) -> str:
    return f"t = {table[0][0]:g} to {table[-1][0]:g}"
