"""The `motion` tables of a case: how bodies and slaves move."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from contiga.case.deform_spec import DeformSpec
from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.spec import (
    Axis,
    ExistingFile,
    FilePattern,
    LengthUnit,
    Name,
    Positive,
    Spec,
    Vector,
    by_kind,
)
from contiga.dynamics.free import Free
from contiga.dynamics.prescribed import BodyMotion, Combine, Fixed, Poses, Rotate, Translate
from contiga.errors import CaseError
from contiga.records import MassProperties

Table = list[list[float]]


class _RigidSpec(Spec):
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


class SeriesSpec(Spec):
    """`{ kind = "series", files = "step_*.vtu" }`: the points as a series of files has them.

    Without `times` and `step` the files are spread evenly over the run, the first at its start,
    the last at its end. `unit` is the files' length unit, if it is not the case's. A rigid motion
    given as `then` carries the points of the series along.
    """

    kind: Literal["series"] = "series"
    files: FilePattern
    times: list[float] | None = None
    step: Positive | None = None
    unit: LengthUnit | None = None
    then: RigidMotionSpec | None = None

    @model_validator(mode="after")
    def _times_are_told_once(self) -> Self:
        if self.times is not None and self.step is not None:
            raise CaseError("must not have both times and step", where="step", found=self.step)
        return self

    def describe(self) -> str:
        """In words."""
        when = "spread over the run"
        if self.times is not None:
            when = f"at {len(self.times)} given times"
        elif self.step is not None:
            when = f"every {self.step:g}"
        carried = "" if self.then is None else f", then {self.then.describe()}"
        return f"points from the files {self.files}, {when}{carried}"


class FreeSpec(Spec):
    """`{ kind = "free", velocity, spin, hold }`: moved by the forces on it.

    A body needs its `mass`, a slave's nodes theirs.
    """

    kind: Literal["free"] = "free"
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Of the centre of mass, or of all nodes, at the start."""
    spin: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Radians a time, world axes, at the start; bodies only."""
    hold: list[str] = Field(default_factory=list)
    """Of x, y, z, rx, ry, rz: world directions it may not move in, axes it may not turn about."""

    @model_validator(mode="after")
    def _motion_is_possible(self) -> Self:
        assert self.moved(None) is not None
        return self

    def moved(self, mass: float | MassProperties | None) -> Free:
        """The motion of a body or of nodes with a mass."""
        return Free(mass, velocity=self.velocity, spin=self.spin, hold=self.hold)

    def describe(self) -> str:
        """In words."""
        spin = f", spin {self.spin}" if any(self.spin) else ""
        held = f", {', '.join(self.hold)} held" if self.hold else ""
        return f"free, velocity {self.velocity} at the start{spin}{held}"


class AttachedSpec(Spec):
    """`{ kind = "attached", body = "…" }`: fixed to a body, which feels its forces."""

    kind: Literal["attached"] = "attached"
    body: Name

    def describe(self) -> str:
        """In words."""
        return f"attached to {self.body}"


if TYPE_CHECKING:
    RigidMotionSpec = FixedSpec | TranslateSpec | RotateSpec | PosesSpec | CombineSpec
    BodyMotionSpec = RigidMotionSpec | VelocitySpec | AccelerationSpec | FreeSpec | AttachedSpec
    SlaveMotionSpec = BodyMotionSpec | SeriesSpec | DeformSpec
else:
    _RIGID = (FixedSpec, TranslateSpec, RotateSpec, PosesSpec, CombineSpec)
    _BODY = (*_RIGID, VelocitySpec, AccelerationSpec, FreeSpec, AttachedSpec)
    RigidMotionSpec = by_kind(*_RIGID)
    BodyMotionSpec = by_kind(*_BODY)
    SlaveMotionSpec = by_kind(*_BODY, SeriesSpec, DeformSpec)

CombineSpec.model_rebuild()
SeriesSpec.model_rebuild()


def _span(table: Table) -> str:
    return f"t = {table[0][0]:g} to {table[-1][0]:g}"
