"""Knot vectors and control nets: their checks, and the basis functions on them.

All splines have *clamped* vectors: both end knots ``degree + 1`` times, interior knots at most
`degree` times. Unclamped vectors are clamped by knot insertion, which changes neither the curve nor
its parameters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import locked, real
from contiga.errors import GeometryError, InputError
from contiga.geometry.kernels.basis_nb import basis_derivatives, find_span
from contiga.records import FloatArray

MAX_DEGREE = 15
_ULPS = 4.0 * float(np.finfo(np.float64).eps)
_SLACK = 1e-10


def check_degree(degree: object, where: str) -> int:
    """Return `degree` as an int; raise GeometryError unless it is whole, from 1 to 15."""
    if (
        isinstance(degree, bool)
        or not isinstance(degree, int | np.integer)
        or not 1 <= degree <= MAX_DEGREE
    ):
        raise GeometryError(
            "the degree must be a whole number",
            where=where,
            found=degree,
            allowed=f"1 to {MAX_DEGREE}",
        )
    return int(degree)


def check_numbers(values: ArrayLike, where: str) -> FloatArray:
    """Return `values` as a new float64 array of any shape.

    Raises GeometryError if they are not numbers, or not all finite; InputError for complex or
    masked ones.
    """
    real(values, where)
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise GeometryError("not an array of numbers", where=where) from error
    if not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise GeometryError(f"the entry at {at} is not finite", where=where, found=float(array[at]))
    return array


def check_weights(
    weights: ArrayLike | None, shape: tuple[int, ...], where: str
) -> FloatArray | None:
    """Return a copy of `weights`; None stays None.

    Raises GeometryError unless they are positive, finite and of the control net's `shape`.
    """
    if weights is None:
        return None
    array = check_numbers(weights, where)
    if array.shape != shape:
        raise GeometryError(
            "expected one weight for each control point",
            where=where,
            found=array.shape,
            allowed=str(shape),
        )
    if (array <= 0.0).any():
        at = tuple(int(i) for i in np.argwhere(array <= 0.0)[0])
        raise GeometryError(
            f"the weight at {at} must be positive", where=where, found=float(array[at])
        )
    return array


def check_knots(knots: ArrayLike, degree: int, count: int, where: str) -> FloatArray:
    """Return a copy of `knots` that fits `degree` and `count` control points, not yet clamped.

    Knots that differ by less than four units in the last place are made equal: the sliver
    between them is rounding.

    Raises
    ------
    GeometryError
        too few control points, a length other than ``count + degree + 1``, knots that decrease,
        an empty domain ``[U_p, U_n]``, or an interior knot more than `degree` times (a jump).
    """
    U = check_numbers(knots, where)
    if U.ndim != 1:
        raise GeometryError("expected a one-dimensional array of knots", where=where, found=U.shape)
    if count < degree + 1:
        raise GeometryError(
            f"degree {degree} needs at least {degree + 1} control points", where=where, found=count
        )
    if U.size != count + degree + 1:
        raise GeometryError(
            f"{count} control points of degree {degree} need {count + degree + 1} knots",
            where=where,
            found=U.size,
        )
    decreases = np.diff(U) < 0.0
    if decreases.any():
        at = int(np.argmax(decreases)) + 1
        raise GeometryError(
            f"knots must not decrease, but knot {at} is below knot {at - 1}",
            where=where,
            found=(float(U[at - 1]), float(U[at])),
        )
    rounding = _ULPS * max(abs(U[0]), abs(U[-1]))
    for i in range(1, U.size):
        if U[i] - U[i - 1] <= rounding:
            U[i] = U[i - 1]
    low, high = U[degree], U[count]
    if not low < high:
        raise GeometryError(
            "the domain from knot p to knot n is empty",
            where=where,
            found=(float(low), float(high)),
        )
    values, times = np.unique(U[(low < U) & (high > U)], return_counts=True)
    if (times > degree).any():
        at = int(np.argmax(times > degree))
        raise GeometryError(
            f"the interior knot {float(values[at])!r} is there {int(times[at])} times, "
            "so the geometry may jump there",
            where=where,
            allowed=f"at most {degree} times at degree {degree}",
            remedy="Give the pieces as separate curves or patches",
        )
    return U


def breaks(knots: FloatArray) -> FloatArray:
    """Return the distinct knots of a clamped vector: the borders of its elements."""
    return np.unique(knots)


def multiplicity(knots: FloatArray, t: float) -> int:
    """Return how often `t` is in `knots`, to the last bit."""
    return int(np.count_nonzero(knots == t))


def clamped(knots: FloatArray, degree: int, low: float, high: float) -> FloatArray:
    """Return `low` and `high`, each degree + 1 times, and the knots strictly between them."""
    inside = knots[(knots > low) & (knots < high)]
    return np.concatenate([np.full(degree + 1, low), inside, np.full(degree + 1, high)])


def is_clamped(knots: FloatArray, degree: int, count: int) -> bool:
    """Return whether both ends carry exactly ``degree + 1`` knots."""
    ends_meet = bool(knots[0] == knots[degree] and knots[count] == knots[-1])
    return ends_meet and bool(knots[degree] < knots[degree + 1] and knots[count - 1] < knots[count])


def check_parameters(values: FloatArray, domain: tuple[float, float], name: str) -> FloatArray:
    """Return a copy of `values` (k,) clipped into `domain`; an excess beyond rounding is an error.

    Raises
    ------
    InputError
        a value that is NaN, or outside by more than 1e-10 of the domain's length.
    """
    low, high = domain
    slack = _SLACK * (high - low) + _ULPS * max(abs(low), abs(high))
    # Smallest and largest value stand for all; a comparison with NaN is false.
    if values.size and not (values.min() >= low - slack and values.max() <= high + slack):
        is_inside = (values >= low - slack) & (values <= high + slack)
        at = int(np.argmax(~is_inside))
        raise InputError(
            f"row {at} of {name} is outside the domain",
            found=float(values[at]),
            allowed=f"[{low!r}, {high!r}]",
        )
    return np.minimum(np.maximum(values, low), high)


def check_inner_parameter(t: float, domain: tuple[float, float], where: str) -> float:
    """Return `t` as a float; raise GeometryError unless it is strictly inside `domain`."""
    low, high = domain
    if not low < t < high:
        raise GeometryError(
            "the parameter must lie inside the domain",
            where=where,
            found=t,
            allowed=f"between {low!r} and {high!r}",
        )
    return float(t)


def basis(knots: FloatArray, degree: int, parameters: ArrayLike, order: int = 0) -> FloatArray:
    """Return all basis functions and derivatives at `parameters`, as a dense array.

    Raises the errors of `check_parameters`.

    Parameters
    ----------
    knots : clamped knot vector
    degree : degree of the functions
    parameters : (k,) inside the domain
    order : highest derivative

    Returns
    -------
    (k, order + 1, n) float64

    >>> basis(np.array([0.0, 0.0, 1.0, 1.0]), 1, [0.25])[0, 0]
    array([0.75, 0.25])
    """
    t = np.atleast_1d(np.asarray(real(parameters), dtype=np.float64))
    n = knots.size - degree - 1
    t = check_parameters(t, (float(knots[degree]), float(knots[n])), "parameters")
    values = locked(knots)
    out = np.zeros((t.size, order + 1, n))
    nonzero = np.empty((order + 1, degree + 1))
    for row, value in enumerate(t):
        span = find_span(values, degree, n, value)
        basis_derivatives(values, degree, span, value, order, nonzero)
        out[row, :, span - degree : span + 1] = nonzero
    return out


def greville(knots: FloatArray, degree: int) -> FloatArray:
    """Return the Greville abscissae (n,): means of `degree` neighbouring knots."""
    n = knots.size - degree - 1
    return np.array([knots[i + 1 : i + degree + 1].mean() for i in range(n)])


def open_knots(degree: int, count: int) -> FloatArray:
    """Return uniform clamped knots on [0, 1] for `count` control points."""
    inner = np.linspace(0.0, 1.0, count - degree + 1)[1:-1]
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def mirrored(knots: FloatArray) -> FloatArray:
    """Return the knots of the same spline reversed over its domain; the ends keep their bits."""
    low, high = knots[0], knots[-1]
    out = np.clip((low + high) - knots[::-1], low, high)
    out[knots[::-1] == high] = low
    out[knots[::-1] == low] = high
    return np.asarray(out)


def check_order(order: object) -> int:
    """Return `order` as an int; raise InputError unless it is a whole number, zero or more."""
    if isinstance(order, bool) or not isinstance(order, int | np.integer) or order < 0:
        raise InputError("must be a whole number", found=order, allowed="0, 1, 2, ...")
    return int(order)
