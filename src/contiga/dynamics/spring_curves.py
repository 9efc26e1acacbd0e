"""Force, slope and energy of one spring, in numbers: what a spring asks at every step.

The laws of a contact take arrays of points; for a single spring a step of theirs costs 500
microseconds with hysteresis, and one of these 5 (`Hysteresis.move` is the plain rival that tests
compare them with).
"""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple, Protocol

import numpy as np

from contiga.laws.characteristic import Characteristic
from contiga.laws.hysteresis import Hysteresis, Moved

# Gauss's rule for the energy of a callable, as that of a `Characteristic`, of either sign.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
# Share of an elongation by which a callable is differentiated, and the least of one.
_NUDGE = 1e-5
_LEAST = 1e-9
# Relative size of what counts as parallel.
_SAME = 1e-12


class Axial(NamedTuple):
    """What the elastic or hysteretic part of a spring has come to."""

    force: float
    """Tension."""
    stiffness: float
    """dF/dx."""
    stored: float
    """What it would give back."""
    lost: float
    """Of the step's work."""


class SpringLaw(Protocol):
    """How the force follows from the elongation x."""

    def move(self, x_old: float, f_old: float, x: float) -> Axial:
        """The step from elongation and force to the elongation `x`."""

    def max_slope(self, x: float) -> float:
        """A bound of dF/dx for a step from `x`, ≥ 0."""


class Line:
    """Straight between nodes and beyond them, with its integral from zero.

    Parameters
    ----------
    x, y : nodes, zero among them
    slopes : before the first, between, and behind the last
    """

    def __init__(self, x: np.ndarray, y: np.ndarray, slopes: np.ndarray) -> None:
        parts = 0.5 * (y[1:] + y[:-1]) * np.diff(x)
        k = int(np.searchsorted(x, 0.0))
        whole = np.zeros(len(x))
        whole[k + 1 :] = np.cumsum(parts[k:])
        whole[:k] = -np.cumsum(parts[:k][::-1])[::-1]
        self.x, self.y, self.slopes, self.whole = (list(v.tolist()) for v in (x, y, slopes, whole))

    def at(self, x: float) -> tuple[float, float, float]:
        """Value, slope to the right, and integral from zero."""
        k = bisect_right(self.x, x)
        j = k - 1 if k else 0
        way, start, slope = x - self.x[j], self.y[j], self.slopes[k]
        y = start + slope * way
        return y, slope, self.whole[j] + 0.5 * way * (start + y)


class ElasticTable:
    """An elastic spring whose curve is a table, of both signs."""

    def __init__(self, curve: Characteristic) -> None:
        ends = curve.end_slopes if curve.extrapolation == "linear" else (0.0, 0.0)
        x = np.union1d(curve.x, 0.0)
        y = np.where(np.isin(x, curve.x), np.interp(x, curve.x, curve.y), curve(x))
        slopes = np.concatenate([ends[:1], np.diff(y) / np.diff(x), ends[1:]])
        self._line = Line(x, y, slopes)
        self._curve = curve
        checked = curve.extrapolation == "error"
        self._range = (x[0], x[-1]) if checked else (-np.inf, np.inf)

    def move(self, x_old: float, f_old: float, x: float) -> Axial:
        """The step to `x`; where it comes from does not count."""
        if not self._range[0] <= x <= self._range[1]:
            self._curve(x)  # says so
        return Axial(*self._line.at(x), 0.0)

    def max_slope(self, x: float) -> float:
        """Of the piece at `x` and the pieces beside it."""
        k = bisect_right(self._line.x, x)
        return max(0.0, *self._line.slopes[max(k - 1, 0) : k + 2])


class ElasticFunction:
    """An elastic spring whose curve is a callable."""

    def __init__(self, curve: Characteristic) -> None:
        self._curve = curve

    def move(self, x_old: float, f_old: float, x: float) -> Axial:
        """The step to `x`; where it comes from does not count."""
        y = self._curve(0.5 * x * (1.0 + _NODES))
        stored = 0.5 * x * float((y * _WEIGHTS).sum())
        return Axial(float(self._curve(x)), self._slope(x), stored, 0.0)

    def max_slope(self, x: float) -> float:
        """The slope at `x`."""
        return max(0.0, self._slope(x))

    def _slope(self, x: float) -> float:
        h = _NUDGE * max(abs(x), _LEAST)
        below, above = self._curve(np.array([x - h, x + h])).tolist()
        return float((above - below) / (2.0 * h))


class _Tensile:
    """A spring with hysteresis: it carries tension only, and is slack below x = 0."""

    def __init__(self, hysteresis: Hysteresis) -> None:
        self._hysteresis = hysteresis
        self._slope = hysteresis.slope

    def move(self, x_old: float, f_old: float, x: float) -> Axial:
        """The step to `x`. A spring that was slack begins anew at x = 0 and F = 0."""
        if x < 0.0:
            return Axial(0.0, 0.0, 0.0, 0.0)
        return self._taut(max(x_old, 0.0), f_old, x)

    def max_slope(self, x: float) -> float:
        """The slope of hysteresis: no curve is steeper."""
        return self._slope

    def _taut(self, x_old: float, f_old: float, x: float) -> Axial:
        raise NotImplementedError


class TensileFunction(_Tensile):
    """One whose curves are not both tables."""

    def _taut(self, x_old: float, f_old: float, x: float) -> Axial:
        moved: Moved = self._hysteresis.move(*(np.array([v]) for v in (x_old, f_old, x)))
        return Axial(*(float(column[0]) for column in moved))


class TensileTable(_Tensile):
    """One whose curves are tables: as `Hysteresis.move`, see there, for one point."""

    def __init__(self, hysteresis: Hysteresis) -> None:
        super().__init__(hysteresis)
        curves = hysteresis.loading, hysteresis.unloading
        self._upper, self._lower = (_Met(curve, hysteresis.slope) for curve in curves)
        ends = [float(c.x[-1]) for c in curves if c.extrapolation == "error"]
        self._end = min(ends, default=np.inf)

    def _taut(self, x_old: float, f_old: float, x: float) -> Axial:
        if x > self._end:
            self._hysteresis.loading(x)  # one of the two says so
            self._hysteresis.unloading(x)
        start = f_old
        if x_old <= 0.0:
            start = min(max(f_old, self._lower.y[0]), self._upper.y[0])
        top, slope_up, _ = self._upper.at(x)
        bottom, slope_down, _ = self._lower.at(x)
        line = start + self._slope * (x - x_old)
        force = min(max(line, bottom), top)
        stored = self._stored(x, force)
        if force < top:
            return Axial(force, slope_down if line <= bottom else self._slope, stored, 0.0)
        if x <= x_old:
            return Axial(force, slope_up, stored, 0.0)
        work = self._work_up(x_old, start, x)
        return Axial(force, slope_up, stored, work - (stored - self._stored(x_old, start)))

    def _stored(self, x: float, force: float) -> float:
        """Under the line down to the unloading curve, and from there under that."""
        meet = self._lower.meet(x, force, 0.0, x)
        way = x - meet
        return way * (force - 0.5 * self._slope * way) + self._lower.at(meet)[2]

    def _work_up(self, x_old: float, start: float, x: float) -> float:
        """Under the line up to the loading curve, and from there under that."""
        meet = self._upper.meet(x_old, start, x_old, x)
        way = meet - x_old
        along = self._upper.at(x)[2] - self._upper.at(meet)[2]
        return way * (start + 0.5 * self._slope * way) + along


class _Met(Line):
    """What a curve carries at x ≥ 0, and where lines of the slope of hysteresis meet it."""

    def __init__(self, curve: Characteristic, slope: float) -> None:
        x, y, _ = curve.polyline
        # A curve that falls behind its last node has its zero there: it stays on it.
        beyond = max(curve.end_slopes[1], 0.0) if curve.extrapolation == "linear" else 0.0
        super().__init__(x, y, np.concatenate([[0.0], np.diff(y) / np.diff(x), [beyond]]))
        self._slope = slope
        self._rise: list[float] = np.maximum.accumulate(slope * x - y).tolist()

    def meet(self, x: float, force: float, low: float, high: float) -> float:
        """Where the line through (x, force) meets the curve, kept in [low, high].

        Line less curve never falls, so that its level is found by bisection.
        """
        level = self._slope * x - force
        j = max(bisect_right(self._rise, level) - 1, 0)
        faster = self._slope - self.slopes[j + 1]
        at = self.x[j]
        if faster > _SAME * self._slope:
            at += max((level - self._rise[j]) / faster, 0.0)
        if j + 1 < len(self.x):
            at = min(at, self.x[j + 1])
        return min(max(at, low), high)


def spring_law(curve: Characteristic, hysteresis: Hysteresis | None) -> SpringLaw:
    """The law of a spring by its curve, elastic without `hysteresis`."""
    if hysteresis is not None:
        return TensileTable(hysteresis) if hysteresis.exact else TensileFunction(hysteresis)
    return ElasticTable(curve) if curve.is_table else ElasticFunction(curve)
