"""Hysteresis: a force that unloads by another curve than it loads.

The force F over an abscissa x (penetration, or strain) stays between a loading curve L and an
unloading curve U, 0 ≤ U ≤ L, and moves along a line of slope K in between,

    F = clip(F_old + K Δx, U(x), L(x)).

K is not below the steepest slope of both curves. Then a line leaves a loading curve downwards and
an unloading curve upwards only, each line meets each curve once, and one step gives what any
number of smaller ones would, as long as x does not turn around between.

What has been *stored* at (x, F) is what an unloading would give back: the area under the line down
to U, and from there under U to x = 0. The work of a step is the area under its path; what of it is
not stored is lost. It is lost while the force moves along L, and only then: nothing is lost along U
and along the lines. Over a closed cycle that is the area between the curves, without the corner
that the line cuts.

A point that leaves contact in one step from x > 0 has, on its way, gone down the line and U to
x = 0 and has given back all that was stored: nothing is lost then. Only the force of that part of
the step was never seen, so that an integration in time may miss its work, as it misses part of
that of an elastic point that leaves. A point that has left forgets: it comes back as a new one, at
x = 0 and F = 0, and loads along L, also where the unloading left a permanent set. While it stays in
contact the set is kept, with no force in it.

Piecewise linear loading and unloading with a hysteresis slope is the model of crash codes (MADYMO
Theory Manual, contact characteristics; LS-DYNA's curves for loading and unloading).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked, positive
from contiga.curves.characteristic import Characteristic, CurveLike, as_curve, check_inside
from contiga.curves.curve_records import Curves, Response, joined
from contiga.curves.kernels import curve_nb, hysteresis_nb
from contiga.errors import InputError
from contiga.records import FloatArray

_TOL = 1e-12
"""Relative tolerance of comparisons of tables, which may describe one curve by other points."""
_FUNCTION_TOL = 1e-9
"""Relative tolerance of the slopes of callables, which are measured between samples."""
_N_SAMPLES = 65
_SAMPLED_TO = 1e-3
"""Abscissa up to which callables are sampled when a hysteresis is made."""


class Moved(NamedTuple):
    """Elastic or hysteretic forces after a step, one row a point: `Response` in arrays."""

    force: FloatArray
    """(n,) force F at the end."""
    stiffness: FloatArray
    """(n,) dF/dx at the end: the slope of the curve that the force is on, or K."""
    stored: FloatArray
    """(n,) energy that an unloading gives back."""
    lost: FloatArray
    """(n,) work of the step that is not stored."""


def elastic_move(curve: Characteristic, x: FloatArray) -> Moved:
    """Return the elastic forces at `x` (n,) ≥ 0; nothing is lost.

    Raises
    ------
    RunError
        `x` is outside a table with ``extrapolation="error"``.
    """
    lost = np.zeros(x.shape)
    if not curve.is_table:
        return Moved(curve.carried(x), curve.carried_slope(x), curve.energy(x), lost)
    check_inside(curve, x)
    rows = np.empty((3, len(x)))
    curve_nb.points(curve.carried_pieces, 0, _for_kernel(x), rows)
    return Moved(rows[0], rows[1], rows[2], lost)


def hysteresis_of(
    loading: Characteristic,
    unloading: CurveLike | None,
    slope: float | None,
    *,
    to: float = np.inf,
) -> Hysteresis | None:
    """Return the hysteresis of a law, None for an elastic one.

    Raises
    ------
    InputError
        One of `unloading` and `slope` without the other; curves that `Hysteresis` refuses.
    """
    if unloading is None and slope is None:
        return None
    if unloading is None or slope is None:
        given, other = "unloading", "hysteresis_slope"
        if unloading is None:
            given, other = other, given
        raise InputError(
            f"is missing: {given} was given, and neither works without the other",
            where=other,
            remedy="Give both, or none for an elastic law",
        )
    return Hysteresis(loading, as_curve(unloading, "unloading"), slope, to=to)


@dataclass(frozen=True, init=False, eq=False)
class Hysteresis:
    """A force between a loading and an unloading curve.

    Parameters
    ----------
    loading, unloading : L and U; below zero L counts as zero
    slope : K, not below the steepest slope of either
    to : x up to which U of tables must not be above L

    Notes
    -----
    Tables are exact: checked at all their points, lines and curves met in closed form. Callables
    are checked at samples, when made and up to the largest x of each step, and met by
    Chandrupatla's bracketing method.

    Raises
    ------
    InputError
        U above L or below zero at some x ≥ 0, K not above zero, not finite or below the steepest
        slope, a table without x = 0 whose extrapolation is an error.

    Examples
    --------
    A cycle to x = 1 loses ∫L − ∫U and the corner: 0.5 − 0.25 − 0.5 · 0.5 · 0.5/(2 − 0.5)

    >>> pad = Hysteresis(Characteristic(1.0), Characteristic(0.5), 2.0)
    >>> zero, one = np.zeros(1), np.ones(1)
    >>> up = pad.move(zero, zero, one)
    >>> float(up.lost[0].round(12)), float(pad.move(one, up.force, zero).lost[0])
    (0.166666666667, 0.0)
    """

    loading: Characteristic
    unloading: Characteristic
    slope: float

    def __init__(
        self,
        loading: Characteristic,
        unloading: Characteristic,
        slope: float,
        *,
        to: float = np.inf,
    ) -> None:
        put = object.__setattr__
        put(self, "loading", loading)
        put(self, "unloading", unloading)
        put(self, "slope", positive(slope, "hysteresis_slope"))
        for curve in (loading, unloading):
            _check_start(curve)
        if self.exact:
            self._check_tables(to)
        else:
            ends = [c.x[-1] for c in (loading, unloading) if c.extrapolation == "error"]
            self._check_samples(min([_SAMPLED_TO, *ends]))

    @property
    def exact(self) -> bool:
        """True if both curves are tables."""
        return self.loading.is_table and self.unloading.is_table

    @cached_property
    def curves(self) -> Curves:
        """Loading and unloading curve of tables as kernels take them."""
        return joined(self.loading.carried_pieces, self.unloading.carried_pieces)

    def step(self, x_old: float, f_old: float, x: float) -> Response:
        """Return the response of one point to a step from (`x_old`, `f_old`) to `x`.

        The force below x = 0 is zero, and what was there has no past.

        Raises
        ------
        InputError
            A callable breaks the rules somewhere up to these x.
        RunError
            `x` is above a table with ``extrapolation="error"``.
        """
        if self.exact:
            self._check_inside(max(x, 0.0))
            return Response(*hysteresis_nb.step(self.curves, self.slope, x_old, f_old, x))
        if x < 0.0:
            return Response(0.0, 0.0, 0.0, 0.0)
        moved = self.move(*(np.array([value]) for value in (max(x_old, 0.0), f_old, x)))
        return Response(*(float(column[0]) for column in moved))

    def move(self, x_old: FloatArray, f_old: FloatArray, x: FloatArray) -> Moved:
        """Return the response of each point to a step from (`x_old`, `f_old`) to `x`, (n,) ≥ 0.

        Raises
        ------
        InputError
            A callable breaks the rules somewhere up to these x.
        RunError
            `x` is above a table with ``extrapolation="error"``.
        """
        if self.exact:
            self._check_inside(x)
            past, rows = np.stack([x_old, f_old]), np.empty((4, len(x)))
            hysteresis_nb.steps(self.curves, self.slope, past, _for_kernel(x), rows)
            return Moved(*rows)
        if x.size:
            self._check_samples(float(max(x.max(), x_old.max())))
        start = self._started(x_old, f_old)
        upper, lower = self.loading.carried(x), self.unloading.carried(x)
        line = start + self.slope * (x - x_old)
        # The loading curve has the last word where rounding puts the other above it.
        force = np.minimum(np.maximum(line, lower), upper)
        stiffness = np.full(x.shape, self.slope)
        on_upper = force >= upper
        for curve, on in ((self.loading, on_upper), (self.unloading, (line <= lower) & ~on_upper)):
            stiffness[on] = curve.carried_slope(x[on])
        stored = self.stored(x, force)
        lost = np.zeros(x.shape)
        up = np.flatnonzero(on_upper & (x > x_old))
        before, begin, end = x_old[up], start[up], x[up]
        lost[up] = self._work_up(before, begin, end) - (stored[up] - self.stored(before, begin))
        return Moved(force, stiffness, stored, lost)

    def _check_inside(self, x: FloatArray | float) -> None:
        for curve in (self.loading, self.unloading):
            check_inside(curve, x)

    def bend(self, x: FloatArray, force: FloatArray) -> FloatArray:
        """Return d²F/dx² (n,) at points (`x`, `force`): zero along lines, and on tables."""
        bend = np.zeros(x.shape)
        if not self.exact:
            on_upper = force >= self.loading.carried(x)
            on_lower = ~on_upper & (force <= self.unloading.carried(x))
            for curve, on in ((self.loading, on_upper), (self.unloading, on_lower)):
                bend[on] = curve.carried_bend(x[on])
        return bend

    def stored(self, x: FloatArray, force: FloatArray) -> FloatArray:
        """Return the energy (n,) that an unloading from (`x`, `force`) gives back."""
        meet = self._meet(self.unloading, (x, force), np.zeros(x.shape), x)
        way = x - meet
        return way * (force - 0.5 * self.slope * way) + self.unloading.energy(meet)

    def _started(self, x_old: FloatArray, f_old: FloatArray) -> FloatArray:
        """Return F (n,) at the start of the step.

        For a point without a past it lies between the curves at 0.
        """
        zero = np.zeros(1)
        least, most = self.unloading.carried(zero), self.loading.carried(zero)
        fresh = np.minimum(np.maximum(f_old, least), most)
        return np.where(x_old > 0.0, f_old, fresh)

    def _work_up(self, x_old: FloatArray, start: FloatArray, x: FloatArray) -> FloatArray:
        """Return ∫F dx (n,) of a step up: along the line to where it meets L, then along L."""
        meet = self._meet(self.loading, (x_old, start), x_old, x)
        way = meet - x_old
        along = self.loading.energy(x) - self.loading.energy(meet)
        return way * (start + 0.5 * self.slope * way) + along

    def _meet(
        self,
        curve: Characteristic,
        point: tuple[FloatArray, FloatArray],
        low: FloatArray,
        high: FloatArray,
    ) -> FloatArray:
        """Return x (n,) where the line through `point` (x, F) meets the curve, in [low, high].

        The curve is above the line to the left and below it to the right. The root is found by
        bracketing; where the line does not meet the curve the result is one of the ends.
        """
        from scipy.optimize.elementwise import find_root

        def above(x: FloatArray, x_line: FloatArray, f_line: FloatArray) -> FloatArray:
            return curve.carried(x) - f_line - self.slope * (x - x_line)

        meet = np.where(above(low, *point) > 0.0, high, low)
        inner = (above(low, *point) > 0.0) & (above(high, *point) < 0.0)
        if inner.any():
            rows = tuple(values[inner] for values in point)
            meet[inner] = find_root(above, (low[inner], high[inner]), args=rows).x
        return np.clip(meet, low, high)

    def _check_tables(self, to: float) -> None:
        curves = self.loading, self.unloading
        end = min([to, *(curve.x[-1] for curve in curves if curve.extrapolation == "error")])
        x = np.union1d(*(curve.carried_pieces.x for curve in curves))
        self._check_order(np.append(x[x < end], end) if np.isfinite(end) else x)
        beyond = [curve.carried_pieces.slope[-1] for curve in curves]
        if np.isinf(end) and beyond[1] > beyond[0] + _TOL * abs(beyond[0]):
            raise InputError(
                "the unloading curve rises above the loading curve beyond their last points, as "
                "its last slope is steeper",
                where=self.unloading.name,
                found=float(beyond[1]),
                allowed=f"up to {beyond[0]:.6g}",
                remedy='Extend the tables, or hold an end with extrapolation = "constant"',
            )
        for curve in curves:
            self._check_slope(curve, float(curve.carried_pieces.slope[1:].max()))

    def _check_samples(self, upto: float) -> None:
        x = np.linspace(0.0, upto, _N_SAMPLES)
        self._check_order(x)
        if upto > 0.0:
            for curve in (self.loading, self.unloading):
                self._check_slope(curve, float((np.diff(curve.carried(x)) / np.diff(x)).max()))

    def _check_order(self, x: FloatArray) -> None:
        """Refuse an unloading above the loading or below zero at `x`."""
        above, below = self.loading.carried(x), self.unloading(x)
        negative = np.flatnonzero(below < 0.0)
        inside = self.unloading.x[-1] if self.unloading.is_table else np.inf
        negative = negative[x[negative] <= inside]
        if negative.size:
            raise InputError(
                f"the unloading curve is below zero at {x[negative[0]]:.6g}",
                where=self.unloading.name,
                found=float(below[negative[0]]),
                allowed="zero or above",
                remedy="A permanent set is a row of zero up to where the force begins",
            )
        wrong = np.flatnonzero(below > above + _TOL * above.max(initial=0.0))
        if wrong.size:
            at = wrong[0]
            raise InputError(
                f"the unloading curve is above the loading curve at {x[at]:.6g}",
                where=self.unloading.name,
                found=float(below[at]),
                allowed=f"up to {above[at]:.6g}",
            )

    def _check_slope(self, curve: Characteristic, steepest: float) -> None:
        same = _TOL if curve.is_table else _FUNCTION_TOL
        if steepest > self.slope * (1.0 + same):
            raise InputError(
                f"must not be below the steepest slope of the curve {curve.name!r}: the force "
                "could not follow it",
                where="hysteresis_slope",
                found=self.slope,
                allowed=f"{steepest:.6g} or above",
            )


def _check_start(curve: Characteristic) -> None:
    if curve.extrapolation == "error" and curve.is_table and curve.x[0] > 0.0:
        raise InputError(
            "hysteresis needs a table that starts at zero or below",
            where=curve.name,
            found=float(curve.x[0]),
            remedy='Add its first point, or set extrapolation = "linear" or "constant"',
        )


def _for_kernel(x: FloatArray) -> FloatArray:
    """Return `x` contiguous and read-only, as kernels take it."""
    return locked(np.ascontiguousarray(x))
