"""Records of a case of the suite and of its answer: measured numbers and those of a formula."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOLERANCE = 1e-4
"""Relative error allowed at the automatic step."""
ROUNDING = 1e-11
"""Relative error of numbers that are exact up to rounding, over hundreds of steps."""
LEAST_ORDER = 1.9
"""Least order of convergence by default; the method is of second order in the step."""


class Check(NamedTuple):
    """A measured number and the number of a formula."""

    what: str
    measured: float
    expected: float
    error: float
    """Relative, or absolute if the formula gives zero."""
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the error is within the tolerance; false for NaN."""
        return self.error <= self.tolerance


class Order(NamedTuple):
    """Convergence of an error with the step, or with the size of elements."""

    of: str
    steps: tuple[float, ...]
    """Each is half of the one before."""
    errors: tuple[float, ...]
    least: float = LEAST_ORDER

    @property
    def observed(self) -> float:
        """Order from the longest to the shortest step; NaN if an error is zero or NaN."""
        if not all(error > 0.0 for error in self.errors):
            return math.nan
        return math.log(self.errors[0] / self.errors[-1]) / math.log(self.steps[0] / self.steps[-1])

    @property
    def holds(self) -> bool:
        """Whether the observed order is at least `least`."""
        return self.observed >= self.least


class Answer(NamedTuple):
    """Checks, picture and order of convergence of a case."""

    checks: tuple[Check, ...]
    draw: Callable[[Figure], None]
    order: Order | None = None
    """None if the step has no influence, or is exact."""

    @property
    def holds(self) -> bool:
        """Whether all checks and the order hold."""
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
    """Setup and measurement, in a sentence or two."""
    run: Run


class Cases(list[Case]):
    """The cases of a module, in their order.

    Parameters
    ----------
    group : name of the group of all cases
    """

    def __init__(self, group: str) -> None:
        super().__init__()
        self._group = group

    def add(self, key: str, title: str, formula: str, scene: str) -> Callable[[Run], Run]:
        """Return a decorator that adds a function that returns an `Answer` as a case."""

        def register(run: Run) -> Run:
            self.append(Case(key, self._group, title, formula, scene, run))
            return run

        return register


def relative(
    what: str,
    measured: float,
    expected: float,
    tolerance: float = TOLERANCE,
    *,
    scale: float | None = None,
) -> Check:
    """Return the check of a number by its error over the expected magnitude, or over `scale`.

    `what` is its name on the page.
    """
    size = abs(expected) if scale is None else scale
    error = abs(float(measured) - float(expected)) / float(size)
    return Check(what, float(measured), float(expected), error, float(tolerance))


def absolute(what: str, measured: float, expected: float, tolerance: float) -> Check:
    """Return the check of a number by its absolute error."""
    error = abs(float(measured) - float(expected))
    return Check(what, float(measured), float(expected), error, float(tolerance))


def zero(what: str, measured: float, tolerance: float) -> Check:
    """Return the check of a number that should be zero, by its magnitude."""
    return absolute(what, measured, 0.0, tolerance)


def order_of(
    of: str,
    longest: float,
    error_at: Callable[[float], float],
    count: int = 3,
    *,
    least: float = LEAST_ORDER,
) -> Order:
    """Return the order from errors at the `longest` step, at half of it, and so on, `count` times.

    Steps may be sizes of elements; `of` names them and the error, and `least` is the order needed.
    """
    steps: Sequence[float] = [longest / 2**k for k in range(count)]
    return Order(of, tuple(steps), tuple(float(error_at(step)) for step in steps), least)
