"""B-spline basis functions, their derivatives, and the maps between knot vectors."""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel


@kernel(linked=True)
def find_span(knots, degree, count, t):
    """Return k with knots[k] <= t < knots[k + 1]; the last non-empty span from the domain's end on.

    Before the domain it is its first span, `degree`. `count` is the number of control points.
    """
    if t >= knots[count]:
        k = count - 1
        while k > degree and knots[k] >= knots[count]:
            k -= 1
        return k
    low = degree
    high = count
    while high - low > 1:
        middle = (low + high) // 2
        if t < knots[middle]:
            high = middle
        else:
            low = middle
    return low


@kernel()
def basis_derivatives(knots, degree, span, t, order, out):
    """Write derivatives 0 … order at t of the degree + 1 basis functions that `span` has.

    Row k of `out` (order + 1, degree + 1) starts as the basis of degree ``degree - k`` and is
    differenced k times (The NURBS Book, Eq. 2.5 and 2.7). Rows above the degree are zero.
    """
    top = min(order, degree)
    values = np.empty(degree + 1)
    values[0] = 1.0
    for k in range(order + 1):
        for r in range(degree + 1):
            out[k, r] = 0.0
    if top == degree:
        out[degree, 0] = 1.0
    for j in range(1, degree + 1):
        saved = 0.0
        for r in range(j):
            right = knots[span + r + 1] - t
            left = t - knots[span + r + 1 - j]
            share = values[r] / (right + left)
            values[r] = saved + right * share
            saved = left * share
        values[j] = saved
        if degree - j <= top:
            for r in range(j + 1):
                out[degree - j, r] = values[r]
    for k in range(1, top + 1):
        for j in range(degree - k + 1, degree + 1):
            for r in range(j, -1, -1):
                new = 0.0
                if r > 0:
                    new += out[k, r - 1] / (knots[span + r] - knots[span + r - j])
                if r < j:
                    new -= out[k, r] / (knots[span + r + 1] - knots[span + r + 1 - j])
                out[k, r] = j * new


@inner()
def discrete_splines(knots, degree, span, refined, start, skip, out):
    """Write the weights of old control points in one control point on refined knots (Oslo).

    The new point belongs to the `degree` knots from ``refined[start + 1]`` on, without
    ``refined[skip]`` (none is left out if `skip` is −1);
    `span` is the old span that holds ``refined[start]``. Every weight is non-negative and they
    sum to one (Cohen, Lyche and Riesenfeld 1980). `out` (degree + 1,) belongs to the old points
    ``span - degree .. span``.
    """
    out[0] = 1.0
    i = start
    for j in range(1, degree + 1):
        i += 1
        if i == skip:
            i += 1
        t = refined[i]
        saved = 0.0
        for r in range(j):
            high = knots[span + r + 1]
            low = knots[span + r + 1 - j]
            share = out[r] / (high - low)
            out[r] = saved + (high - t) * share
            saved = (t - low) * share
        out[j] = saved


@kernel()
def refinement_rows(knots, degree, count, refined):
    """Return the map from `count` control points on `knots` to those on the finer `refined`.

    It is ``first`` (n,) and ``weights`` (n, degree + 1): new point i is the sum of
    ``weights[i, r]`` times old point ``first[i] + r``.
    """
    n = refined.size - degree - 1
    first = np.empty(n, np.int64)
    weights = np.empty((n, degree + 1))
    for i in range(n):
        span = find_span(knots, degree, count, refined[i])
        first[i] = span - degree
        discrete_splines(knots, degree, span, refined, i, -1, weights[i])
    return first, weights


@kernel()
def elevation_rows(knots, degree, count, elevated):
    """Return the map (first, weights) to degree + 1 on `elevated`: each distinct knot once more.

    Both are as in `refinement_rows`. A point of the elevated spline is the mean, over its degree +
    1 knots, of the points for the knots without that one (Prautzsch 1984), so the map consists of
    convex combinations, too.
    """
    n = elevated.size - degree - 2
    first = np.empty(n, np.int64)
    weights = np.zeros((n, degree + 1))
    row = np.empty(degree + 1)
    for i in range(n):
        span = find_span(knots, degree, count, elevated[i])
        first[i] = span - degree
        for skip in range(i + 1, i + degree + 2):
            discrete_splines(knots, degree, span, elevated, i, skip, row)
            for r in range(degree + 1):
                weights[i, r] += row[r] / (degree + 1)
    return first, weights


@kernel()
def apply_rows(first, weights, points):
    """Return new points (n, d) from old `points` (m, d) by the rows of a map, (first, weights)."""
    n, width = weights.shape
    dim = points.shape[1]
    out = np.zeros((n, dim))
    for i in range(n):
        for r in range(width):
            factor = weights[i, r]
            if factor != 0.0:
                for d in range(dim):
                    out[i, d] += factor * points[first[i] + r, d]
    return out
