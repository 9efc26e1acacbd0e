"""Characteristics: how a force or stress follows from a penetration, a strain or a rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only, real
from contiga.errors import InputError, RunError
from contiga.laws.curve_records import CurveTable
from contiga.records import FloatArray

Extrapolation = Literal["linear", "constant", "error"]
Function = Callable[[FloatArray], ArrayLike]

# Gauss's rule for the energy of a callable: its error is that of a polynomial of degree 15 on each
# of the panels.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_PANELS = 8
# Share of an abscissa by which a callable is differentiated: the cube root of rounding.
_NUDGE = float(np.cbrt(np.finfo(np.float64).eps))
# The same for second derivatives.
_FAR_NUDGE = 1e-3

# Small enough for functions that grow fast, and more than one value, so that a callable that
# takes single numbers only is found out when the curve is made and not in the middle of a run.
_PROBE = np.array([0.0, 1e-6, 1e-3])


@dataclass(frozen=True, init=False, eq=False)
class Characteristic:
    """A curve ``y(x)``: piecewise linear through a table, a straight line, or a function.

    Parameters
    ----------
    curve : number, (n, 2) table or callable
        A number ``k`` is the line ``y = k x``. A table has one row ``x, y`` a point, ``x``
        strictly increasing, n ≥ 2. A callable takes a float64 array and returns one of the same
        shape; it is tried once here and its answers are checked at every call.
    extrapolation : what happens outside a table
        ``"linear"`` (default) continues the first and the last segment, as the large crash codes
        do, so that a contact which goes deeper than its table goes on stiffening and is not
        driven through at a constant force. ``"constant"`` holds the end values. ``"error"`` stops
        the run with the value asked for.
    name : how errors call the curve

    Notes
    -----
    Negative abscissae are allowed. A penetration or a strain never gets there; a rate does when
    a contact opens, and a damping table that starts at x = 0 is continued below zero as
    `extrapolation` says.

    Raises
    ------
    InputError
        Fewer than two points, abscissae that repeat or go back, not-finite entries, a callable
        that does not take arrays or answers with another shape or with NaN.
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
        elif isinstance(curve, int | float | np.number) and not isinstance(curve, bool):
            x, y = _line(float(curve), name)
            extrapolation = "linear"
        elif callable(curve):
            function = curve
        else:
            x, y = _table(curve, name)
        values = (x, y, function, extrapolation, name)
        for key, value in zip(("x", "y", "function", "extrapolation", "name"), values, strict=True):
            object.__setattr__(self, key, value)
        if function is not None:
            _try(self)

    def __call__(self, x: ArrayLike) -> FloatArray:
        """Ordinates at `x`, an array of any shape; the answer has the same shape."""
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is not None:
            return _checked_answer(self, at)
        check_inside(self, at)
        y = np.asarray(np.interp(at, self.x, self.y))
        if self.extrapolation == "linear":
            first, last = self.end_slopes
            y = np.where(at < self.x[0], self.y[0] + first * (at - self.x[0]), y)
            y = np.where(at > self.x[-1], self.y[-1] + last * (at - self.x[-1]), y)
        return y

    def slope(self, x: ArrayLike) -> FloatArray:
        """dy/dx at `x` ≥ 0, to the right of it at a point of a table.

        Of a callable by differences of second order, to the right of x.
        """
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is not None:
            h = _NUDGE * np.maximum(np.abs(at), _PROBE[1])
            y = [self(at + k * h) for k in range(3)]
            return np.asarray((4.0 * y[1] - 3.0 * y[0] - y[2]) / (2.0 * h))
        slopes = self._slopes
        return slopes[np.searchsorted(self.x, at, side="right")]

    def bend(self, x: ArrayLike) -> FloatArray:
        """d²y/dx² at `x`: zero of a table, by differences of fourth order of a callable."""
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is None:
            return np.zeros(at.shape)
        h = _FAR_NUDGE * np.maximum(np.abs(at), _PROBE[1])
        near, far = self(at + h) + self(at - h), self(at + 2.0 * h) + self(at - 2.0 * h)
        return np.asarray((16.0 * near - far - 30.0 * self(at)) / (12.0 * h * h))

    def energy(self, x: ArrayLike) -> FloatArray:
        """∫₀ˣ max(y, 0) dx for `x` ≥ 0: the energy stored in a spring with this curve.

        Exact for a table; one that ends in an error below its first point stores nothing there.
        Of a callable by Gauss's rule with 64 points.
        """
        at = np.asarray(real(x), dtype=np.float64)
        if self.function is not None:
            part = (np.arange(_PANELS)[:, None] + 0.5 * (1.0 + _NODES)) / _PANELS
            y = np.maximum(self(at[..., None, None] * part), 0.0)
            return np.asarray(at * (y @ _WEIGHTS).sum(axis=-1) / (2.0 * _PANELS))
        nodes, rising, whole = self.polyline
        j = np.maximum(np.searchsorted(nodes, at, side="right") - 1, 0)
        way = np.maximum(at - nodes[j], 0.0)
        y = np.maximum(self(np.maximum(at, nodes[0])), 0.0)
        return np.asarray(whole[j] + 0.5 * way * (rising[j] + y))

    @cached_property
    def _slopes(self) -> FloatArray:
        """Slopes before, between and behind the points of a table."""
        ends = self.end_slopes if self.extrapolation == "linear" else (0.0, 0.0)
        return np.concatenate([ends[:1], np.diff(self.y) / np.diff(self.x), ends[1:]])

    def carried(self, x: ArrayLike) -> FloatArray:
        """max(y, 0) at `x`: the force of a spring with this curve that cannot pull."""
        return np.maximum(self(x), 0.0)

    def carried_slope(self, x: ArrayLike) -> FloatArray:
        """Slope of `carried` at `x` ≥ 0: `slope`, and zero where y is below zero."""
        return np.where(self(x) >= 0.0, self.slope(x), 0.0)

    def carried_bend(self, x: ArrayLike) -> FloatArray:
        """Second derivative of `carried` at `x` ≥ 0, but for its kinks."""
        return np.where(self(x) >= 0.0, self.bend(x), 0.0)

    @cached_property
    def polyline(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Abscissae ≥ 0 between which `carried` of a table is straight, its values and `energy`."""
        slopes = self._slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            zeros = np.append(self.x[0], self.x) - np.append(self.y[0], self.y) / slopes
        ends = np.concatenate([[-np.inf], self.x, [np.inf]])
        zeros = zeros[(zeros > ends[:-1]) & (zeros < ends[1:])]  # without NaN
        nodes = np.union1d(self.x, zeros)
        if self.extrapolation == "error":
            nodes = nodes[(nodes >= self.x[0]) & (nodes <= self.x[-1])]
        starts_above = self.extrapolation == "error" and self.x[0] > 0.0
        nodes = nodes if starts_above else np.append(0.0, nodes[nodes > 0.0])
        y = np.where(np.isin(nodes, zeros), 0.0, np.maximum(self(nodes), 0.0))
        steps = 0.5 * (y[1:] + y[:-1]) * np.diff(nodes)
        return nodes, y, np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def table(self) -> CurveTable:
        """`carried` of a table, as kernels take it."""
        x, y, energy = self.polyline
        # A curve that falls behind its last node has its zero there: it stays on it.
        beyond = max(self.end_slopes[1], 0.0) if self.extrapolation == "linear" else 0.0
        return CurveTable(x, y, energy, np.append(np.diff(y) / np.diff(x), beyond))

    @property
    def end_slopes(self) -> tuple[float, float]:
        """Slopes of the first and the last segment of a table."""
        dx, dy = np.diff(self.x), np.diff(self.y)
        return float(dy[0] / dx[0]), float(dy[-1] / dx[-1])

    @property
    def is_table(self) -> bool:
        """Whether the curve is piecewise linear (a table or a number), not a callable."""
        return self.function is None


CurveLike: TypeAlias = Characteristic | float | ArrayLike | Function


def check_inside(curve: Characteristic, at: FloatArray) -> None:
    """Refuse abscissae outside a table that is not extrapolated.

    Raises
    ------
    RunError
        As said.
    """
    if curve.extrapolation != "error":
        return
    outside = at[(at < curve.x[0]) | (at > curve.x[-1])]
    if outside.size:
        raise RunError(
            f"{curve.name}: the characteristic is asked at {outside.flat[0]:.6g}, outside its "
            f"table [{curve.x[0]:.6g}, {curve.x[-1]:.6g}]. Extend the table, or let it "
            'extrapolate with extrapolation = "linear" or "constant"'
        )


def _line(slope: float, name: str) -> tuple[FloatArray, FloatArray]:
    if not np.isfinite(slope):
        raise InputError("a coefficient must be finite", where=name, found=slope)
    return read_only(np.array([0.0, 1.0])), read_only(np.array([0.0, slope]))


_ROWS = "rows [x, y], x strictly increasing, at least two"


def _two_columns(curve: object, name: str) -> FloatArray:
    real(curve, name)
    try:
        table = np.asarray(curve, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a characteristic must be a number, a table of numbers or a callable",
            where=name,
            found=type(curve).__name__,
            allowed=_ROWS,
        ) from error
    if table.ndim != 2 or table.shape[1] != 2:
        raise InputError(
            "a characteristic table must have two columns",
            where=name,
            found=table.shape,
            allowed=_ROWS,
        )
    return table


def _table(curve: object, name: str) -> tuple[FloatArray, FloatArray]:
    """The two columns of a table, checked."""
    table = _two_columns(curve, name)
    if len(table) < 2:
        raise InputError(
            "a characteristic needs at least two points",
            where=name,
            found=len(table),
            allowed=_ROWS,
        )
    if not np.isfinite(table).all():
        row = int(np.flatnonzero(~np.isfinite(table).all(axis=1))[0])
        raise InputError(
            f"row {row} is not finite", where=name, found=table[row].tolist(), allowed=_ROWS
        )
    back = np.flatnonzero(np.diff(table[:, 0]) <= 0.0)
    if back.size:
        row = int(back[0])
        raise InputError(
            f"the abscissae go back or repeat at row {row + 1}",
            where=name,
            found=table[row : row + 2, 0].tolist(),
            allowed=_ROWS,
        )
    return read_only(table[:, 0]), read_only(table[:, 1])


def _try(curve: Characteristic) -> None:
    """Call a callable once with an array, so that a wrong one is found before the run."""
    try:
        curve(_PROBE)
    except InputError:
        raise
    except Exception as error:
        raise InputError(
            f"the function fails when called with an array ({type(error).__name__}: {error})",
            where=curve.name,
            allowed="a function of a float64 array that returns one of the same shape",
            remedy="Write it with numpy functions (np.where in place of if)",
        ) from error


def _checked_answer(curve: Characteristic, at: FloatArray) -> FloatArray:
    assert curve.function is not None
    y = np.asarray(real(curve.function(at)), dtype=np.float64)
    if y.shape != at.shape:
        raise InputError(
            f"the function must answer an array of shape {at.shape} with one of the same shape",
            where=curve.name,
            found=y.shape,
        )
    finite = np.isfinite(y)
    if not finite.all():
        raise InputError(
            f"the function's value at {at[~finite].flat[0]:.6g} is not finite",
            where=curve.name,
            found=float(y[~finite].flat[0]),
        )
    return y
