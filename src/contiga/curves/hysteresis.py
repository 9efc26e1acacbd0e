"""Hysteresis: a force between a loading and an unloading curve.

The force F over an abscissa x (penetration, or strain) is between a loading curve L and an
unloading curve U, 0 ≤ U ≤ L, and moves along a line of slope K between them,

    F = clip(F_old + K Δx, U(x), L(x)).

K is not below the steepest slope of both curves. So a line can leave a loading curve only downwards
and an unloading curve only upwards, each line meets each curve once, and one step has the same
result as any number of smaller ones, as long as x does not reverse.

The energy *stored* at (x, F) is that of an unloading: the area under the line down to U, and from
there under U to x = 0. The work of a step is the area under its path; the part that is not stored
is lost. Energy is lost only while the force moves along L, not along U or the lines. Over a closed
cycle the loss is the area between the curves, without the corner that the line cuts off.

A point that leaves contact in one step from x > 0 moves down the line and U to x = 0, which returns
all of the stored energy: nothing is lost. An integration in time may miss the work of that part of
the step, as it does for an elastic point that leaves. A point that has left has no memory: it comes
back at x = 0 and F = 0, and loads along L, also if the unloading left a permanent set. As long as
it stays in contact the set remains, without force.

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

_TABLE_TOL = 1e-12
"""Relative tolerance of comparisons of tables, which may describe one curve by different points."""
_FUNCTION_TOL = 1e-9
"""Relative tolerance of the slopes of callables, which are differences between samples."""
_N_SAMPLES = 65
_FIRST_SAMPLE_RANGE = 1e-3
"""Abscissa up to which callables are sampled when a hysteresis is made."""


class Responses(NamedTuple):
    """Elastic or hysteretic forces after a step, one row a point: `Response` in arrays."""

    force: FloatArray
    """(n,) force F at the end."""
    stiffness: FloatArray
    """(n,) dF/dx at the end: the slope of the curve that the force is on, or K."""
    stored: FloatArray
    """(n,) energy that an unloading returns."""
    lost: FloatArray
    """(n,) work of the step that is not stored."""


def elastic_move(curve: Characteristic, x: FloatArray) -> Responses:
    """Return elastic forces max(y, 0) at `x` (n,) ≥ 0, slopes and stored energies; losses are zero.

    Raises
    ------
    RunError
        `x` is outside a table with ``extrapolation="error"``.
    """
    lost = np.zeros(x.shape)
    if not curve.is_table:
        return Responses(curve.carried(x), curve.carried_slope(x), curve.energy(x), lost)
    check_inside(curve, x)
    rows = np.empty((3, len(x)))
    curve_nb.points(curve.carried_pieces, 0, _for_kernel(x), rows)
    return Responses(rows[0], rows[1], rows[2], lost)


def hysteresis_of(
    loading: Characteristic,
    unloading: CurveLike | None,
    slope: float | None,
    *,
    to: float = np.inf,
) -> Hysteresis | None:
    """Return the hysteresis of a law; None for an elastic one, without `unloading` and `slope`.

    `to` is the x up to which tables are compared, see `Hysteresis`.

    Raises
    ------
    InputError
        One of `unloading` and `slope` without the other; curves that `Hysteresis` refuses.
    """
    if unloading is None and slope is None:
        return None
    if unloading is None or slope is None:
        present, missing = "unloading", "hysteresis_slope"
        if unloading is None:
            present, missing = missing, present
        raise InputError(
            f"is missing: {present} was given, and neither works without the other",
            where=missing,
            remedy="Give both, or none for an elastic law",
        )
    return Hysteresis(loading, as_curve(unloading, "unloading"), slope, to=to)


@dataclass(frozen=True, init=False, eq=False)
class Hysteresis:
    """A force between a loading and an unloading curve.

    Parameters
    ----------
    loading, unloading : L and U; a negative L counts as zero
    slope : K, not below the steepest slope of either
    to : x up to which U of tables must not be above L

    Notes
    -----
    Tables are exact: all their points are checked, and intersections of lines and curves are in
    closed form. Callables are checked at samples, here and up to the largest x of each step, and
    their intersections are by Chandrupatla's bracketing method.

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
            if curve.extrapolation == "error" and curve.is_table and curve.x[0] > 0.0:
                raise InputError(
                    "hysteresis needs a table that starts at zero or below",
                    where=curve.name,
                    found=float(curve.x[0]),
                    remedy='Add its first point, or set extrapolation = "linear" or "constant"',
                )
        if self.exact:
            self._check_tables(to)
        else:
            ends = [c.x[-1] for c in (loading, unloading) if c.extrapolation == "error"]
            self._check_samples(min([_FIRST_SAMPLE_RANGE, *ends]))

    @property
    def exact(self) -> bool:
        """True if both curves are tables."""
        return self.loading.is_table and self.unloading.is_table

    @cached_property
    def curves(self) -> Curves:
        """Loading and unloading curve of tables, for kernels."""
        return joined(self.loading.carried_pieces, self.unloading.carried_pieces)

    def step(self, x_old: float, f_old: float, x: float) -> Response:
        """Return the response of one point to a step from (`x_old`, `f_old`) to `x`.

        The force below x = 0 is zero, and a point from there has no memory.

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
        responses = self.move(np.array([max(x_old, 0.0)]), np.array([f_old]), np.array([x]))
        return Response(*(float(column[0]) for column in responses))

    def move(self, x_old: FloatArray, f_old: FloatArray, x: FloatArray) -> Responses:
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
            return Responses(*rows)
        if x.size:
            self._check_samples(float(max(x.max(), x_old.max())))
        # A point without memory starts between the curves at zero.
        zero = np.zeros(1)
        start = np.minimum(
            np.maximum(f_old, self.unloading.carried(zero)), self.loading.carried(zero)
        )
        start = np.where(x_old > 0.0, f_old, start)
        upper, lower = self.loading.carried(x), self.unloading.carried(x)
        line = start + self.slope * (x - x_old)
        # If rounding puts the unloading curve above the loading curve, the latter decides.
        force = np.minimum(np.maximum(line, lower), upper)
        stiffness = np.full(x.shape, self.slope)
        is_upper = force >= upper
        is_lower = (line <= lower) & ~is_upper
        stiffness[is_upper] = self.loading.carried_slope(x[is_upper])
        stiffness[is_lower] = self.unloading.carried_slope(x[is_lower])
        stored = self.stored(x, force)
        lost = np.zeros(x.shape)
        up = np.flatnonzero(is_upper & (x > x_old))
        x_start, f_start, x_end = x_old[up], start[up], x[up]
        # Work along the line up to the loading curve, and then along that.
        meet = self._meet(self.loading, (x_start, f_start), x_start, x_end)
        dx = meet - x_start
        work = dx * (f_start + 0.5 * self.slope * dx) + (
            self.loading.energy(x_end) - self.loading.energy(meet)
        )
        lost[up] = work - (stored[up] - self.stored(x_start, f_start))
        return Responses(force, stiffness, stored, lost)

    def _check_inside(self, x: FloatArray | float) -> None:
        for curve in (self.loading, self.unloading):
            check_inside(curve, x)

    def bend(self, x: FloatArray, force: FloatArray) -> FloatArray:
        """Return d²F/dx² (n,) at points (`x`, `force`): zero on lines, and if both are tables.

        On the loading or the unloading curve it is the curve's; if they coincide the loading's.
        """
        bend = np.zeros(x.shape)
        if not self.exact:
            is_upper = force >= self.loading.carried(x)
            is_lower = ~is_upper & (force <= self.unloading.carried(x))
            bend[is_upper] = self.loading.carried_bend(x[is_upper])
            bend[is_lower] = self.unloading.carried_bend(x[is_lower])
        return bend

    def stored(self, x: FloatArray, force: FloatArray) -> FloatArray:
        """Return the energy (n,) that an unloading from (`x`, `force`) returns."""
        meet = self._meet(self.unloading, (x, force), np.zeros(x.shape), x)
        dx = x - meet
        return dx * (force - 0.5 * self.slope * dx) + self.unloading.energy(meet)

    def _meet(
        self,
        curve: Characteristic,
        point: tuple[FloatArray, FloatArray],
        low: FloatArray,
        high: FloatArray,
    ) -> FloatArray:
        """Return x (n,) where the line through `point` (x, F) meets the curve, in [low, high].

        The curve is above the line to the left and below it to the right. The root is found by
        bracketing; without an intersection it is `high` if the curve is above the line at `low`,
        else `low`.
        """
        from scipy.optimize.elementwise import find_root

        def height(x: FloatArray, x_line: FloatArray, f_line: FloatArray) -> FloatArray:
            return curve.carried(x) - f_line - self.slope * (x - x_line)

        meet = np.where(height(low, *point) > 0.0, high, low)
        is_bracketed = (height(low, *point) > 0.0) & (height(high, *point) < 0.0)
        if is_bracketed.any():
            lines = tuple(values[is_bracketed] for values in point)
            bracket = low[is_bracketed], high[is_bracketed]
            meet[is_bracketed] = find_root(height, bracket, args=lines).x
        return np.clip(meet, low, high)

    def _check_tables(self, to: float) -> None:
        """Refuse tables that break a rule at some x ≥ 0 up to `to`, or where a table ends.

        An `InputError` is raised for U below zero or above L at a knot, U steeper than L beyond all
        knots, and a steepest slope above K.
        """
        curves = self.loading, self.unloading
        end = min([to, *(curve.x[-1] for curve in curves if curve.extrapolation == "error")])
        x = np.union1d(*(curve.carried_pieces.x for curve in curves))
        self._check_order(np.append(x[x < end], end) if np.isfinite(end) else x)
        slope_l, slope_u = (curve.carried_pieces.slope[-1] for curve in curves)
        if np.isinf(end) and slope_u > slope_l + _TABLE_TOL * abs(slope_l):
            raise InputError(
                "the unloading curve rises above the loading curve beyond their last points, as "
                "its last slope is steeper",
                where=self.unloading.name,
                found=float(slope_u),
                allowed=f"up to {slope_l:.6g}",
                remedy='Extend the tables, or hold an end with extrapolation = "constant"',
            )
        for curve in curves:
            self._check_slope(curve, float(curve.carried_pieces.slope[1:].max()))

    def _check_samples(self, upto: float) -> None:
        """Refuse callables that break a rule at `_N_SAMPLES` samples up to an x."""
        x = np.linspace(0.0, upto, _N_SAMPLES)
        self._check_order(x)
        if upto > 0.0:
            for curve in (self.loading, self.unloading):
                self._check_slope(curve, float((np.diff(curve.carried(x)) / np.diff(x)).max()))

    def _check_order(self, x: FloatArray) -> None:
        """Refuse an unloading above the loading or below zero at `x` (n,).

        Beyond its last row a table may be below zero. `_TABLE_TOL` of the largest loading counts as
        equal.
        """
        upper, lower = self.loading.carried(x), self.unloading(x)
        end = self.unloading.x[-1] if self.unloading.is_table else np.inf
        negative = np.flatnonzero((lower < 0.0) & (x <= end))
        if negative.size:
            raise InputError(
                f"the unloading curve is below zero at {x[negative[0]]:.6g}",
                where=self.unloading.name,
                found=float(lower[negative[0]]),
                allowed="zero or above",
                remedy="A permanent set is a row of zero up to where the force begins",
            )
        wrong = np.flatnonzero(lower > upper + _TABLE_TOL * upper.max(initial=0.0))
        if wrong.size:
            k = wrong[0]
            raise InputError(
                f"the unloading curve is above the loading curve at {x[k]:.6g}",
                where=self.unloading.name,
                found=float(lower[k]),
                allowed=f"up to {upper[k]:.6g}",
            )

    def _check_slope(self, curve: Characteristic, steepest: float) -> None:
        """Refuse a hysteresis slope K below the steepest slope of a curve, beyond a tolerance."""
        tol = _TABLE_TOL if curve.is_table else _FUNCTION_TOL
        if steepest > self.slope * (1.0 + tol):
            raise InputError(
                f"must not be below the steepest slope of the curve {curve.name!r}: the force "
                "could not follow it",
                where="hysteresis_slope",
                found=self.slope,
                allowed=f"{steepest:.6g} or above",
            )


def _for_kernel(x: FloatArray) -> FloatArray:
    """Return `x` contiguous and read-only."""
    return locked(np.ascontiguousarray(x))
