"""Characteristics: a force or stress as a function of a penetration, a strain or a rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import locked, read_only, real
from contiga.curves.curve_records import Curves, Response, piecewise
from contiga.curves.kernels import curve_nb
from contiga.curves.tables import is_number, table_of
from contiga.errors import InputError, RunError
from contiga.records import FloatArray

Extrapolation = Literal["linear", "constant", "error"]
Function = Callable[[FloatArray], ArrayLike]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
"""Gauss's rule on each panel of the integral of a callable, exact for polynomials of degree 15."""
_N_PANELS = 8
_SLOPE_STEP, _BEND_STEP = float(np.cbrt(np.finfo(np.float64).eps)), 1e-3
"""Relative steps of the first and second differences of a callable."""
_MIN_SCALE = 1e-6
"""Smallest abscissa that scales these steps."""
_PROBE = np.array([0.0, 1e-6, 1e-3])
"""Abscissae at which a callable is checked: small, for functions that grow fast, and several, so
that a callable of single numbers fails when the curve is made, not during a run."""


class _Points(NamedTuple):
    """Value, slope and integral of a curve at several abscissae, each of their shape."""

    value: FloatArray
    slope: FloatArray
    integral: FloatArray


@dataclass(frozen=True, init=False, eq=False)
class Characteristic:
    """A curve ``y(x)``: piecewise linear through a table, a straight line, or a function.

    Parameters
    ----------
    curve : number, (n, 2) table or callable
        A number ``k`` is the line ``y = k x``. A table has one row ``x, y`` a point, ``x``
        strictly increasing, n ≥ 2. A callable takes a float64 array and returns one of the same
        shape; it is called once here, and its results are checked at every call.
    extrapolation : behaviour outside a table
        ``"linear"`` (default) continues the first and the last segment, like the large crash codes,
        so that a contact deeper than its table continues to stiffen. ``"constant"`` continues the
        end values. ``"error"`` stops the run with the abscissa.
    name : name of the curve in errors

    Notes
    -----
    Negative abscissae are allowed. Penetrations and strains are never negative, but rates are when
    a contact opens: a damping table that starts at x = 0 is then extrapolated.

    Raises
    ------
    InputError
        Fewer than two points, abscissae that repeat or go back, entries that are not finite, a
        callable that does not take arrays or returns another shape or NaN.
    RunError
        When evaluated outside a table with ``extrapolation="error"``.

    `x` and `y` are the columns of the table, empty for a callable.

    >>> Characteristic([[0.0, 0.0], [1.0, 2.0], [2.0, 8.0]])([0.5, 1.5, 3.0])
    array([ 1.,  5., 14.])
    """

    x: FloatArray
    y: FloatArray
    function: Function | None
    extrapolation: Extrapolation
    name: str

    def __init__(
        self,
        curve: CurveLike,
        *,
        extrapolation: Extrapolation = "linear",
        name: str = "curve",
    ) -> None:
        if extrapolation not in get_args(Extrapolation):
            raise InputError(
                "the extrapolation is not known",
                where=name,
                found=extrapolation,
                allowed=", ".join(map(repr, get_args(Extrapolation))),
            )
        x = y = np.zeros(0)
        function: Function | None = None
        if isinstance(curve, Characteristic):
            x, y, function, extrapolation = curve.x, curve.y, curve.function, curve.extrapolation
        elif is_number(curve):
            if not np.isfinite(curve):
                raise InputError("a coefficient must be finite", where=name, found=curve)
            x, y = read_only(np.array([0.0, 1.0])), read_only(np.array([0.0, float(curve)]))
            extrapolation = "linear"
        elif callable(curve):
            function = curve
        else:
            allowed = "a number, a callable, or rows [x, y], x strictly increasing, at least two"
            rows = table_of(curve, ("x", "y"), where=name, at_least=2, allowed=allowed)
            x, y = read_only(rows[:, 0]), read_only(rows[:, 1])
        put = object.__setattr__
        put(self, "x", x)
        put(self, "y", y)
        put(self, "function", function)
        put(self, "extrapolation", extrapolation)
        put(self, "name", name)
        if function is not None:  # an invalid function fails here, not during a run
            try:
                self(_PROBE)
            except InputError:
                raise
            except Exception as error:
                raise InputError(
                    "the function fails when called with an array "
                    f"({type(error).__name__}: {error})",
                    where=name,
                    allowed="a function of a float64 array that returns one of the same shape",
                    remedy="Write it with numpy functions (np.where in place of if)",
                ) from error

    def __call__(self, x: ArrayLike) -> FloatArray:
        """Return the ordinates at `x`, an array of any shape; the result has the same shape.

        Raises
        ------
        RunError
            `x` is outside a table with ``extrapolation="error"``.
        InputError
            A callable returns another shape, or numbers that are not finite.
        """
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is None:
            check_inside(self, at)
            return _points(self.pieces, at).value
        y = np.asarray(real(self.function(at)), dtype=np.float64)
        if y.shape != at.shape:
            raise InputError(
                f"the function must answer an array of shape {at.shape} with one of the same shape",
                where=self.name,
                found=y.shape,
            )
        is_finite = np.isfinite(y)
        if not is_finite.all():
            raise InputError(
                f"the function's value at {at[~is_finite].flat[0]:.6g} is not finite",
                where=self.name,
                found=float(y[~is_finite].flat[0]),
            )
        return y

    def slope(self, x: ArrayLike) -> FloatArray:
        """Return dy/dx to the right of `x`; for a callable by differences of second order.

        Outside a table it is that of the extrapolation, zero with ``extrapolation="error"``.
        """
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is None:
            return _points(self.pieces, at).slope
        h = _SLOPE_STEP * np.maximum(np.abs(at), _MIN_SCALE)
        y = [self(at + k * h) for k in range(3)]
        return np.asarray((4.0 * y[1] - 3.0 * y[0] - y[2]) / (2.0 * h))

    def bend(self, x: ArrayLike) -> FloatArray:
        """Return d²y/dx² at `x`: zero for a table, differences of fourth order for a callable."""
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is None:
            return np.zeros(at.shape)
        h = _BEND_STEP * np.maximum(np.abs(at), _MIN_SCALE)
        inner, outer = self(at + h) + self(at - h), self(at + 2.0 * h) + self(at - 2.0 * h)
        return np.asarray((16.0 * inner - outer - 30.0 * self(at)) / (12.0 * h * h))

    def energy(self, x: ArrayLike) -> FloatArray:
        """Return ∫₀ˣ max(y, 0) dx for `x` ≥ 0: the energy stored in a spring with this curve.

        The integral is exact for a table, and zero below the first point of a table without
        extrapolation. For a callable it is by Gauss's rule with 64 points.

        Raises
        ------
        RunError
            `x` is above a table with ``extrapolation="error"``.
        """
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is not None:
            return self._quadrature(at, 0.0)
        if self.extrapolation == "error":
            at = np.maximum(at, self.x[0])
            check_inside(self, at)
        return _points(self.carried_pieces, at).integral

    def response(self, x: float) -> Response:
        """Return force, slope and ∫₀ˣ y dx of an elastic spring at `x` of either sign; no loss.

        The integral is exact for a table, by Gauss's rule for a callable. Forces may be negative.

        Raises
        ------
        RunError
            `x` is outside a table with ``extrapolation="error"``.
        """
        if self.function is None:
            check_inside(self, x)
            value, slope, integral = curve_nb.point(self.pieces, 0, x)
            return Response(value, slope, integral, 0.0)
        at = np.asarray(x)
        stored = self._quadrature(at, -np.inf)
        return Response(float(self(at)), float(self.slope(at)), float(stored), 0.0)

    def max_slope_near(self, x: float) -> float:
        """Return an upper bound, ≥ 0, of the slope in a step from `x`.

        For a table it is the largest slope of the piece at `x` and its two neighbours, which holds
        for steps up to these. For a callable it is the slope at `x`, no bound.
        """
        if self.function is not None:
            return max(0.0, float(self.slope(x)))
        k = int(np.searchsorted(self.pieces.x, x, side="right"))
        return max(0.0, float(self.pieces.slope[max(k - 1, 0) : k + 2].max()))

    def _quadrature(self, x: FloatArray, least: float) -> FloatArray:
        """Return ∫₀ˣ max(y, least) dx of a callable, by Gauss's rule in `_N_PANELS` panels."""
        points = (np.arange(_N_PANELS)[:, None] + 0.5 * (1.0 + _NODES)) / _N_PANELS
        y = np.maximum(self(x[..., None, None] * points), least)
        return np.asarray(x * (y @ _WEIGHTS).sum(axis=-1) / (2.0 * _N_PANELS))

    def carried(self, x: ArrayLike) -> FloatArray:
        """Return max(y, 0) at `x`: the force of a spring with this curve that cannot pull."""
        return np.maximum(self(x), 0.0)

    def carried_slope(self, x: ArrayLike) -> FloatArray:
        """Return the slope of `carried` at `x` ≥ 0: `slope`, or zero where y is negative."""
        return np.where(self(x) >= 0.0, self.slope(x), 0.0)

    def carried_bend(self, x: ArrayLike) -> FloatArray:
        """Return the second derivative of `carried` at `x` ≥ 0, without its kinks."""
        return np.where(self(x) >= 0.0, self.bend(x), 0.0)

    @cached_property
    def pieces(self) -> Curves:
        """Table for kernels, with a knot at zero unless it cannot be evaluated there."""
        before, beyond = self._outer_slopes
        table = piecewise(self.x, self.y, before, beyond)
        includes_zero = self.x[0] <= 0.0 <= self.x[-1]
        if (self.extrapolation == "error" and not includes_zero) or (self.x == 0.0).any():
            return table
        k = int(np.searchsorted(self.x, 0.0))
        at_zero = _points(table, np.zeros(1)).value[0]
        return piecewise(np.insert(self.x, k, 0.0), np.insert(self.y, k, at_zero), before, beyond)

    @cached_property
    def carried_pieces(self) -> Curves:
        """Table of `carried` for x ≥ 0, for kernels, with knots where the curve meets zero.

        Beyond its last knot it never falls.
        """
        table, is_extrapolated = self.pieces, self.extrapolation != "error"
        with np.errstate(divide="ignore", invalid="ignore"):
            zeros = np.append(table.x[0], table.x) - np.append(table.y[0], table.y) / table.slope
        ends = np.concatenate([[-np.inf], table.x, [np.inf]])
        zeros = zeros[(zeros > ends[:-1]) & (zeros < ends[1:])]  # without NaN
        knots = np.union1d(table.x, zeros)
        is_inside = is_extrapolated | ((knots >= self.x[0]) & (knots <= self.x[-1]))
        knots = knots[is_inside & (knots >= 0.0)]
        y = np.where(np.isin(knots, zeros), 0.0, self.carried(knots))
        # A curve that falls beyond its last knot is zero from the zero of that line on.
        return piecewise(knots, y, 0.0, max(self._outer_slopes[1], 0.0))

    @property
    def _outer_slopes(self) -> tuple[float, float]:
        """Slopes before the first and beyond the last row of a table."""
        return self.end_slopes if self.extrapolation == "linear" else (0.0, 0.0)

    @property
    def end_slopes(self) -> tuple[float, float]:
        """Slopes of the first and the last segment of a table."""
        dx, dy = np.diff(self.x), np.diff(self.y)
        return float(dy[0] / dx[0]), float(dy[-1] / dx[-1])

    @property
    def is_table(self) -> bool:
        """True if the curve is piecewise linear (a table or a number), not a callable."""
        return self.function is None


CurveLike: TypeAlias = Characteristic | float | ArrayLike | Function


def as_curve(curve: CurveLike, name: str) -> Characteristic:
    """Return a new `Characteristic` with a `name` for errors, or `curve` itself if it is one."""
    return curve if isinstance(curve, Characteristic) else Characteristic(curve, name=name)


def check_inside(curve: Characteristic, x: ArrayLike) -> None:
    """Refuse abscissae outside a table that is not extrapolated.

    Raises
    ------
    RunError
        One of `x` is outside.
    """
    if curve.extrapolation != "error":
        return
    at = np.asarray(x, dtype=np.float64)
    outer = at[(at < curve.x[0]) | (at > curve.x[-1])]
    if outer.size:
        raise RunError(
            f"{curve.name}: the characteristic is asked at {outer.flat[0]:.6g}, outside its "
            f"table [{curve.x[0]:.6g}, {curve.x[-1]:.6g}]. Extend the table, or let it "
            'extrapolate with extrapolation = "linear" or "constant"'
        )


def _points(curves: Curves, x: FloatArray) -> _Points:
    """Return value, slope and integral of one curve at `x`, arrays of its shape."""
    flat, out = np.ascontiguousarray(x).reshape(-1), np.empty((3, x.size))
    curve_nb.points(curves, 0, locked(flat), out)
    return _Points(*out.reshape(3, *x.shape))
