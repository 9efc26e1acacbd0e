"""Time steps of a run: the time of the next step from the time of the last one."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, read_only
from contiga.errors import InputError
from contiga.records import FloatArray


class Stepping(Protocol):
    """Times of steps, one after the other."""

    @property
    def start(self) -> float:
        """The time a run begins at."""

    @property
    def end(self) -> float:
        """The time it ends at."""

    def after(self, time: float) -> float:
        """The time of the step that follows `time`, at most `end`."""

    def planned(self) -> FloatArray:
        """Return the times (n,) from start to end, as far as they are known beforehand."""


# A whole number of steps is taken as such if it is met to this part of a step.
_WHOLE = 1e-6
# More steps than anybody would wait for: a step in the wrong unit.
_MOST_STEPS = 10_000_000
# Steps that "auto" takes at least.
_PARTS = 200
# Units in the last place of the latest time that a step must have, so that no two times are one.
_LEAST_STEP = 4


@dataclass(frozen=True)
class EqualSteps:
    """Steps of one length, the last one shorter where they do not fit.

    Times are multiples of the step from the start, not sums, so that rounding does not pile up.

    Parameters
    ----------
    start, end : times, start < end
    step : > 0, at most end − start

    Raises
    ------
    InputError
        Times that are not finite or do not rise, a step that is not positive, too long, or lost
        in the rounding of the times.
    """

    start: float
    end: float
    step: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.end) and self.start < self.end):
            raise InputError(
                "the end must come after the start",
                where="end",
                found=self.end,
                allowed=f"> {self.start:g}",
            )
        if not self.step > 0.0:
            raise InputError(
                "the step must be positive", where="step", found=self.step, allowed="> 0"
            )
        if self.step > (self.end - self.start) * (1.0 + _WHOLE):
            raise InputError(
                "the step is longer than the whole time",
                where="step",
                found=self.step,
                allowed=f"at most {self.end - self.start:g}",
            )
        if not (self.end - self.start) / self.step <= _MOST_STEPS:
            raise InputError(
                f"makes {(self.end - self.start) / self.step:.3g} steps",
                where="step",
                found=self.step,
                allowed=f"at most {_MOST_STEPS} steps",
                remedy="Look at the units of the step and of the end",
            )
        if self.step < _LEAST_STEP * np.spacing(max(abs(self.start), abs(self.end))):
            raise InputError(
                "is below the rounding error of times this late",
                where="step",
                found=self.step,
                remedy="Let the time start at 0",
            )

    @cached_property
    def count(self) -> int:
        """Number of steps."""
        steps = (self.end - self.start) / self.step
        near = round(steps)
        return near if abs(steps - near) < _WHOLE else math.ceil(steps)

    def after(self, time: float) -> float:
        """The first multiple of the step after `time`."""
        k = max(math.floor((time - self.start) / self.step) - 1, 0)
        while self.start + self.step * k <= time:
            k += 1
        return self.end if k >= self.count else self.start + self.step * k

    def planned(self) -> FloatArray:
        """Return all times."""
        times = self.start + self.step * np.arange(self.count + 1, dtype=np.float64)
        times[-1] = self.end
        return times


@dataclass(frozen=True)
class AutoSteps:
    """Steps that are as long as what happens in them allows, each chosen after the one before.

    Parameters
    ----------
    start, end : times, start < end
    safety : share of the critical step that is taken at most, in (0, 1]
    largest : of all steps; a two hundredth of the time if 0
    shortest : below which nothing but stability, a table's rows and the way of points shortens a
        step; a five hundredth of the critical step if 0

    Raises
    ------
    InputError
        Times that are not finite or do not rise, a safety outside (0, 1], a negative step, a
        largest step that makes too many steps, a shortest one above the largest.
    """

    start: float
    end: float
    safety: float = 0.9
    largest: float = 0.0
    shortest: float = 0.0

    def __post_init__(self) -> None:
        EqualSteps(self.start, self.end, self.end - self.start)
        if not 0.0 < self.safety <= 1.0:
            raise InputError("must be in (0, 1]", where="safety", found=self.safety)
        if not self.largest >= 0.0:
            raise InputError("must be positive", where="largest", found=self.largest, allowed="> 0")
        if not (self.end - self.start) / self.most <= _MOST_STEPS:
            raise InputError(
                f"makes {(self.end - self.start) / self.most:.3g} steps or more",
                where="largest",
                found=self.largest,
                allowed=f"at most {_MOST_STEPS} steps",
                remedy="Look at the units of the step and of the end",
            )
        if not 0.0 <= self.shortest <= self.most:
            raise InputError(
                "must be positive and not above the largest step",
                where="shortest",
                found=self.shortest,
                allowed=f"at most {self.most:g}",
            )

    @cached_property
    def most(self) -> float:
        """Longest step."""
        return self.largest or (self.end - self.start) / _PARTS

    def after(self, time: float) -> float:
        """The longest step there is."""
        return min(time + self.most, self.end)

    def planned(self) -> FloatArray:
        """Times one longest step apart: there will be more."""
        count = math.ceil((self.end - self.start) / self.most)
        return np.linspace(self.start, self.end, count + 1)


@dataclass(frozen=True, init=False, eq=False)
class GivenTimes:
    """Times of a list.

    Parameters
    ----------
    times : (n,) rising; the first is the start

    Raises
    ------
    InputError
        No times, times that are not finite or do not rise.
    """

    times: FloatArray

    def __init__(self, times: ArrayLike) -> None:
        instants = as_numbers(times, "times", "the times must be numbers")
        if instants.ndim != 1 or len(instants) == 0 or not np.isfinite(instants).all():
            raise InputError(
                "the times must be finite numbers, one or more", where="times", found=instants.shape
            )
        if (np.diff(instants) <= 0.0).any():
            raise InputError("the times must increase", where="times")
        object.__setattr__(self, "times", read_only(instants))

    @property
    def start(self) -> float:
        """The first of the times."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """The last of the times."""
        return float(self.times[-1])

    def after(self, time: float) -> float:
        """The first of the list after `time`."""
        k = int(np.searchsorted(self.times, time, side="right"))
        return float(self.times[min(k, len(self.times) - 1)])

    def planned(self) -> FloatArray:
        """The list."""
        return self.times


def ended(stepping: Stepping, end: float) -> Stepping:
    """Return the same steps to another end; of a list, those of its times that are no later.

    >>> ended(EqualSteps(0.0, 4.0, 1.0), 2.0).planned()
    array([0., 1., 2.])
    """
    if isinstance(stepping, EqualSteps | AutoSteps):
        return replace(stepping, end=end)
    if isinstance(stepping, GivenTimes):
        return GivenTimes(stepping.times[stepping.times <= end])
    return stepping
