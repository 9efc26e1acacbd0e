"""Refinement: maps of control points between knot vectors that do not change the shape.

Every map is a table of convex combinations (Oslo algorithm for knots, Prautzsch's for degrees),
so it is as exact as rounding allows, keeps weights positive and serves insertion, splitting,
clamping and Bézier extraction alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import locked
from contiga.errors import GeometryError
from contiga.geometry.kernels.basis_nb import apply_rows, elevation_rows, refinement_rows
from contiga.geometry.knots import check_numbers
from contiga.records import FloatArray

Rows = tuple[NDArray[np.int64], FloatArray]


def refine_points(
    knots: FloatArray, degree: int, points: FloatArray, refined: FloatArray, axis: int = 0
) -> FloatArray:
    """Return control points on `refined`, a clamped vector with every knot of its range.

    Oslo algorithm (Cohen, Lyche and Riesenfeld 1980), any number of knots at once. `refined` may
    cover a part of the old domain only: that is how a spline is split.

    Parameters
    ----------
    knots : clamped knot vector of the points
    degree : degree of the spline
    points : (..., n along `axis`, ..., 4), homogeneous coordinates
    refined : clamped knot vector that contains every knot of `knots` in its range
    axis : axis of the points along which knots are inserted
    """
    return mapped(rows_to(knots, degree, points.shape[axis], refined), points, axis)


def rows_to(knots: FloatArray, degree: int, count: int, refined: FloatArray) -> Rows:
    """Return the map of `count` control points to those on `refined`, as in `refine_points`.

    It has the first old point of each new one, (n,), and its weights (n, degree + 1).
    """
    return refinement_rows(locked(knots), degree, count, refined)


def elevate_points(
    knots: FloatArray, degree: int, points: FloatArray, axis: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Return knots and homogeneous control points of the same spline, its degree one higher."""
    values, times = np.unique(knots, return_counts=True)
    elevated = np.repeat(values, times + 1)
    rows = elevation_rows(locked(knots), degree, points.shape[axis], elevated)
    return elevated, mapped(rows, points, axis)


def mapped(rows: Rows, points: FloatArray, axis: int) -> FloatArray:
    """Return the control points that `rows` maps `points` (..., n along `axis`, ..., 4) to."""
    first, weights = rows
    moved = np.moveaxis(points, axis, 0)
    flat = np.ascontiguousarray(moved).reshape(moved.shape[0], -1)
    out = apply_rows(first, weights, flat).reshape(weights.shape[0], *moved.shape[1:])
    return np.ascontiguousarray(np.moveaxis(out, 0, axis))


def with_inserted(knots: FloatArray, degree: int, new: ArrayLike, where: str) -> FloatArray:
    """Return `knots` with the values `new` inserted (several at once, existing knots too).

    Raises
    ------
    GeometryError
        A value is outside the open domain, or would stand more than `degree` times.
    """
    values = np.sort(np.atleast_1d(check_numbers(new, where)).ravel())
    low, high = float(knots[0]), float(knots[-1])
    if values.size == 0:
        return knots
    if values[0] <= low or values[-1] >= high:
        bad = values[0] if values[0] <= low else values[-1]
        raise GeometryError(
            "knots can be inserted inside the domain only",
            where=where,
            found=float(bad),
            allowed=f"between {low!r} and {high!r}",
        )
    out = np.sort(np.concatenate([knots, values]))
    distinct, times = np.unique(out[degree + 1 : -degree - 1], return_counts=True)
    if (times > degree).any():
        at = int(np.argmax(times > degree))
        raise GeometryError(
            f"knot {float(distinct[at])!r} would stand {int(times[at])} times",
            where=where,
            allowed=f"at most {degree} times at degree {degree}",
        )
    return out
