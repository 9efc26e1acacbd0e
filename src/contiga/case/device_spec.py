"""The devices of belts in a case: devices at a spring's end, slip rings, and triggers."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from contiga.case.spec import InstanceSpec, Name, NotNegative, Positive, Spec, is_number, must_be
from contiga.dynamics.belt_devices import LoadLimiter, Pretensioner, Retractor
from contiga.dynamics.slip_rings import SlipRing
from contiga.simulation.trigger import Trigger

_NUMBER_OR_LIST = must_be(
    lambda value: is_number(value) or (isinstance(value, list) and bool(value)),
    "must be a number, or several",
)
Forces = Annotated[float | list[float], _NUMBER_OR_LIST]
ForceOrRows = Annotated[float | list[list[float]], _NUMBER_OR_LIST]


class LockSpec(Spec):
    """`lock = { trigger, rate }`: causes that lock a retractor."""

    trigger: Name | None = None
    """Name of a sensor with a trigger."""
    rate: Positive | None = None
    """Rate of pay-out above which it locks, length / time."""

    def describe(self) -> str:
        """Describe the table in words."""
        causes = [] if self.trigger is None else [f"by {self.trigger}"]
        causes += [] if self.rate is None else [f"above a pay-out of {self.rate:g}"]
        return f"locks {' or '.join(causes)}"


class RetractorSpec(InstanceSpec[Retractor]):
    """`retractor = { spool, lock, film }`: `Retractor`."""

    makes = Retractor
    spool: ForceOrRows = 0.0
    """Force of its spring, a number or rows [length paid out, force]."""
    lock: LockSpec
    film: list[list[float]] | None = None
    """Rows [length paid out, force] after it has locked."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Retractor` takes."""
        lock = {"trigger": self.lock.trigger, "rate": self.lock.rate}
        return lock | {"spool": self.spool, "film": self.film}


class LimiterSpec(InstanceSpec[LoadLimiter]):
    """`limiter = { force, travel }`: `LoadLimiter`."""

    makes = LoadLimiter
    force: Forces
    travel: list[float] | None = None


class PretensionerSpec(InstanceSpec[Pretensioner]):
    """`pretensioner = { trigger, pull | force, stroke }`: `Pretensioner`."""

    makes = Pretensioner
    trigger: Name
    pull: list[list[float]] | None = None
    """Rows [t, length pulled in], t since it fires."""
    force: list[list[float]] | None = None
    """Rows [t, force]."""
    stroke: Positive | None = None


class ReleaseSpec(Spec):
    """`release = { trigger }`: the trigger that releases an end."""

    trigger: Name


class SlipRingSpec(InstanceSpec[SlipRing]):
    """A `[[slip_ring]]`: `SlipRing`."""

    makes = SlipRing
    name: Name | None = None
    between: list[Name]
    """Two springs that end at one point."""
    friction: NotNegative = 0.0

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `SlipRing` takes."""
        return super().arguments() | {"name": self.name or ""}

    def describe(self) -> str:
        """Describe the table in words."""
        return f"between {' and '.join(self.between)}: friction {self.friction:g}"


class TriggerSpec(InstanceSpec[Trigger]):
    """`trigger = { channel, above | below, for, delay }` of a sensor: `Trigger`."""

    makes = Trigger
    channel: str | None = None
    above: float | None = None
    below: float | None = None
    lasting: NotNegative = Field(default=0.0, alias="for")
    delay: NotNegative = 0.0

    def describe(self) -> str:
        """Describe the table in words."""
        level = f"above {self.above:g}" if self.below is None else f"below {self.below:g}"
        times = [f" for {self.lasting:g}"] if self.lasting else []
        times += [f", {self.delay:g} later"] if self.delay else []
        return f"fires with {self.channel or 'its magnitude'} {level}{''.join(times)}"
