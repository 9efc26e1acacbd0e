"""The `motion` tables of a case for bodies and slaves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from contiga.case.deform_spec import DeformSpec
from contiga.case.rigid_spec import PrescribedMotionSpec, RigidMotionSpec
from contiga.case.shape_spec import ShapeSpec
from contiga.case.spec import BY_KIND, FilePattern, LengthUnit, MotionSpec, Name, Positive, Vector
from contiga.dynamics.free import Free
from contiga.errors import CaseError
from contiga.records import MassProperties


class SeriesSpec(MotionSpec):
    """`{ kind = "series", files = "step_*.vtu" }`: points read from a series of files.

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
    def _times_are_given_once(self) -> Self:
        if self.times is not None and self.step is not None:
            raise CaseError("must not have both times and step", where="step", found=self.step)
        return self

    def describe(self) -> str:
        """Describe the table in words."""
        when = "spread over the run"
        if self.times is not None:
            when = f"at {len(self.times)} given times"
        elif self.step is not None:
            when = f"every {self.step:g}"
        carried = "" if self.then is None else f", then {self.then.describe()}"
        return f"points from the files {self.files}, {when}{carried}"


class FreeSpec(MotionSpec):
    """`{ kind = "free", velocity, spin, hold }`: moved by the forces on it.

    A body needs its `mass`, a slave's nodes theirs.
    """

    by_forces = True
    kind: Literal["free"] = "free"
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Initial velocity of the centre of mass, or of all nodes."""
    spin: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Initial angular velocity, rad over time, world axes; bodies only."""
    hold: list[str] = Field(default_factory=list)
    """Fixed world directions x, y, z and axes of rotation rx, ry, rz."""

    @model_validator(mode="after")
    def _motion_is_possible(self) -> Self:
        assert self.moved(None) is not None
        return self

    def moved(self, mass: float | MassProperties | None) -> Free:
        """Return the motion of a body or of nodes with a mass."""
        return Free(mass, velocity=self.velocity, spin=self.spin, hold=self.hold)

    def describe(self) -> str:
        """Describe the table in words."""
        spin = f", spin {self.spin}" if any(self.spin) else ""
        hold = f", {', '.join(self.hold)} held" if self.hold else ""
        return f"free, velocity {self.velocity} at the start{spin}{hold}"


class AttachedSpec(MotionSpec):
    """`{ kind = "attached", body = "…" }`: fixed to a body, which carries its forces."""

    kind: Literal["attached"] = "attached"
    body: Name

    def named_bodies(self) -> Iterator[tuple[str, str]]:
        """Yield the key of its body, and the name."""
        yield "body", self.body

    def describe(self) -> str:
        """Describe the table in words."""
        return f"attached to {self.body}"


BodyMotionSpec = Annotated[PrescribedMotionSpec | FreeSpec | AttachedSpec | ShapeSpec, BY_KIND]
SlaveMotionSpec = Annotated[
    PrescribedMotionSpec | FreeSpec | AttachedSpec | SeriesSpec | DeformSpec, BY_KIND
]
