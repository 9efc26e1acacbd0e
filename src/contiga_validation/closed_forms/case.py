"""What a case of the suite is, and what it answers: numbers beside those of a formula."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOLERANCE = 1e-4
"""Relative error allowed at the automatic step."""
ROUNDING = 1e-11
"""Relative error of what is exact but for rounding, over hundreds of steps."""
LEAST_ORDER = 1.9
"""Least order of convergence by default; the method is of second order in the step."""


class Check(NamedTuple):
    """A number, and the one that a formula gives."""

    what: str
    measured: float
    expected: float
    error: float
    """Relative, or the difference itself where the formula gives zero."""
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the error is within the tolerance; what is not a number is not."""
        return self.error <= self.tolerance


class Order(NamedTuple):
    """Convergence of an error with the step, or with the size of elements."""

    of: str
    steps: tuple[float, ...]
    """Each half of the one before."""
    errors: tuple[float, ...]
    least: float = LEAST_ORDER

    @property
    def observed(self) -> float:
        """Exponent of the step, from the longest to the shortest; NaN where an error is zero."""
        if not all(error > 0.0 for error in self.errors):
            return math.nan
        return math.log(self.errors[0] / self.errors[-1]) / math.log(self.steps[0] / self.steps[-1])

    @property
    def holds(self) -> bool:
        """Whether the observed order is at least `least`."""
        return self.observed >= self.least


class Answer(NamedTuple):
    """What a case has found."""

    checks: tuple[Check, ...]
    draw: Callable[[Figure], None]
    order: Order | None = None
    """None where the step has no part in it, or the step is exact."""

    @property
    def holds(self) -> bool:
        """Whether all do."""
        return all(check.holds for check in self.checks) and (
            self.order is None or self.order.holds
        )


Run = Callable[[], Answer]


class Case(NamedTuple):
    """One comparison with a closed form."""

    key: str
    """Unique, such as "bounce"."""
    group: str
    title: str
    formula: str
    scene: str
    """What is set up and how it is measured, a sentence or two."""
    run: Run


class Cases(list[Case]):
    """The cases of a module, in the order in which it finds their answers.

    Parameters
    ----------
    group : of all of them
    """

    def __init__(self, group: str) -> None:
        super().__init__()
        self._group = group

    def add(self, key: str, title: str, formula: str, scene: str) -> Callable[[Run], Run]:
        """Over a function that answers: the case is one of these."""

        def added(run: Run) -> Run:
            self.append(Case(key, self._group, title, formula, scene, run))
            return run

        return added


def relative(
    what: str,
    measured: float,
    expected: float,
    tolerance: float = TOLERANCE,
    *,
    scale: float | None = None,
) -> Check:
    """A check of the error relative to what is expected, or to `scale`."""
    size = abs(expected) if scale is None else scale
    error = abs(float(measured) - float(expected)) / float(size)
    return Check(what, float(measured), float(expected), error, float(tolerance))


def absolute(what: str, measured: float, expected: float, tolerance: float) -> Check:
    """A check of the difference itself."""
    error = abs(float(measured) - float(expected))
    return Check(what, float(measured), float(expected), error, float(tolerance))


def zero(what: str, measured: float, tolerance: float) -> Check:
    """A check of what is to be zero."""
    return absolute(what, measured, 0.0, tolerance)


def order_of(
    of: str,
    longest: float,
    error_at: Callable[[float], float],
    count: int = 3,
    *,
    least: float = LEAST_ORDER,
) -> Order:
    """The error at a step, at half of it, and so on."""
    steps: Sequence[float] = [longest / 2**k for k in range(count)]
    return Order(of, tuple(steps), tuple(float(error_at(step)) for step in steps), least)
