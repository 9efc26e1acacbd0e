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
    """The times of the steps of a run."""

    @property
    def start(self) -> float:
        """Start of the run."""

    @property
    def end(self) -> float:
        """End of the run."""

    def after(self, time: float) -> float:
        """Return the time of the step after `time`, at most `end`."""

    def planned(self) -> FloatArray:
        """Return the times (n,) from start to end, as far as they are known in advance."""


_COUNT_TOL = 1e-6
"""Distance from a whole number of steps, in steps, that counts as rounding."""
_MAX_STEPS = 10_000_000
"""Number of steps above which the step is most likely in a wrong unit."""
_MIN_AUTO_STEPS = 200
"""Least number of steps of an automatic run."""
_MIN_STEP_ULPS = 4
"""Shortest step in units in the last place of the latest time, so that times differ."""


@dataclass(frozen=True)
class EqualSteps:
    """Steps of equal length, the last one shorter if they do not fit.

    Times are multiples of the step from the start, not sums, so that rounding does not accumulate.

    Parameters
    ----------
    start, end : times, start < end
    step : > 0, at most end − start

    Raises
    ------
    InputError
        Times that are not finite or do not rise, a step that is not positive, too long, or below
        the rounding error of the times.
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
        if self.step > (self.end - self.start) * (1.0 + _COUNT_TOL):
            raise InputError(
                "the step is longer than the whole time",
                where="step",
                found=self.step,
                allowed=f"at most {self.end - self.start:g}",
            )
        if not (self.end - self.start) / self.step <= _MAX_STEPS:
            raise InputError(
                f"makes {(self.end - self.start) / self.step:.3g} steps",
                where="step",
                found=self.step,
                allowed=f"at most {_MAX_STEPS} steps",
                remedy="Look at the units of the step and of the end",
            )
        if self.step < _MIN_STEP_ULPS * np.spacing(max(abs(self.start), abs(self.end))):
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
        nearest = round(steps)
        return nearest if abs(steps - nearest) < _COUNT_TOL else math.ceil(steps)

    def after(self, time: float) -> float:
        """Return the first multiple of the step from the start on after `time`, at most `end`."""
        k = max(math.floor((time - self.start) / self.step) - 1, 0)
        while self.start + self.step * k <= time:
            k += 1
        return self.end if k >= self.count else self.start + self.step * k

    def planned(self) -> FloatArray:
        """Return all times (n,), the last one exactly `end`."""
        times = self.start + self.step * np.arange(self.count + 1, dtype=np.float64)
        times[-1] = self.end
        return times


@dataclass(frozen=True)
class AutoSteps:
    """Automatic steps, each chosen after the last one by stability and accuracy.

    Parameters
    ----------
    start, end : times, start < end
    safety : largest share of the critical step, in (0, 1]
    largest : longest step; a two hundredth of the time of the run if 0
    shortest : length below which only stability, the rows of a table and the travel of points
        shorten a step; a five hundredth of the critical step if 0

    Raises
    ------
    InputError
        Times that are not finite or do not rise, a safety outside (0, 1], a negative step, too many
        steps, a shortest step above the largest.
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
        if not (self.end - self.start) / self.most <= _MAX_STEPS:
            raise InputError(
                f"makes {(self.end - self.start) / self.most:.3g} steps or more",
                where="largest",
                found=self.largest,
                allowed=f"at most {_MAX_STEPS} steps",
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
        return self.largest or (self.end - self.start) / _MIN_AUTO_STEPS

    def after(self, time: float) -> float:
        """Return the time after the longest step, at most `end`."""
        return min(time + self.most, self.end)

    def planned(self) -> FloatArray:
        """Return the times (n,) of the fewest equal steps of which none is above the longest."""
        count = math.ceil((self.end - self.start) / self.most)
        return np.linspace(self.start, self.end, count + 1)


@dataclass(frozen=True, init=False, eq=False)
class GivenTimes:
    """Steps that end at the times of a list.

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
        """First time."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Last time."""
        return float(self.times[-1])

    def after(self, time: float) -> float:
        """Return the first time of the list after `time`; the last one if there is none."""
        k = int(np.searchsorted(self.times, time, side="right"))
        return float(self.times[min(k, len(self.times) - 1)])

    def planned(self) -> FloatArray:
        """Return the times of the list."""
        return self.times


def ended(stepping: Stepping, end: float) -> Stepping:
    """Return the same steps to another end; a list of times is cut off there.

    Nothing is added to a list that ends before. Steps of any other class are returned as they are.

    >>> ended(EqualSteps(0.0, 4.0, 1.0), 2.0).planned()
    array([0., 1., 2.])
    """
    if isinstance(stepping, EqualSteps | AutoSteps):
        return replace(stepping, end=end)
    if isinstance(stepping, GivenTimes):
        return GivenTimes(stepping.times[stepping.times <= end])
    return stepping
