"""Trimming pieces in space: the surface along a p-curve, and its closest point."""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import bernstein_basis, evaluate, locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, zero_scratch

MAX_ITERATIONS = 60
STEP_TOL = 1e-8
"""Newton step (of a piece's parameter) after which another one would be rounding."""
POLISH_STEPS = 3
POLISH_REACH = 1e-5
ROUNDING = 1e-14
"""Rounding of a squared distance, as a share of its terms: some fifty roundings."""
MIN_HALF_WIDTH = 1e-9
"""Half-width of an interval (of a piece's parameter) that is not halved further."""
MAX_INTERVALS = 400
ELEMENT, S, T, LEFT_OUT = 0, 1, 2, 3
"""Columns of the result of a search for the closest point: element, s and t; or −1 − piece and the
piece's parameter on a trimming piece. The last is 0, or what the search left out."""


@inner()
def piece_parameters(trims, piece, t, c):
    """Write (u, v) and two derivatives of a piece at t in [0, 1] to c[:3, :2]; c[:3, 2] is work."""
    n = trims.piece_degree[piece]
    basis = zero_scratch(3, 16)
    bernstein_basis(n, t, basis)
    for k in range(3):
        for m in range(3):
            total = 0.0
            for i in range(n + 1):
                total += basis[k, i] * trims.piece_coefs[piece, i, m]
            c[k, m] = total
    w = 1.0 / c[0, 2]
    for m in range(2):
        x = c[0, m] * w
        x1 = (c[1, m] - c[1, 2] * x) * w
        c[2, m] = (c[2, m] - 2.0 * c[1, 2] * x1 - c[2, 2] * x) * w
        c[1, m] = x1
        c[0, m] = x


@kernel()
def curve_point(elements, grid, trims, piece, t, h, d):
    """Write the point and two derivatives of the trimming curve in space to d[3, 3].

    The point is relative to the origin of its element. Returns that element and the local (s, t)
    there; `h` holds the element's derivatives.
    """
    c = scratch(3, 3)
    piece_parameters(trims, piece, t, c)
    e, s, r = locate(grid, trims.piece_patch[piece], c[0, 0], c[0, 1])
    evaluate(elements, e, s, r, h)
    scale_u = 1.0 / (elements.table[e]["box"][1] - elements.table[e]["box"][0])
    scale_v = 1.0 / (elements.table[e]["box"][3] - elements.table[e]["box"][2])
    a1 = c[1, 0] * scale_u
    b1 = c[1, 1] * scale_v
    a2 = c[2, 0] * scale_u
    b2 = c[2, 1] * scale_v
    for k in range(3):
        d[0, k] = h[k, 0]
        d[1, k] = h[k, 1] * a1 + h[k, 2] * b1
        d[2, k] = (
            h[k, 3] * a1 * a1
            + 2.0 * h[k, 4] * a1 * b1
            + h[k, 5] * b1 * b1
            + h[k, 1] * a2
            + h[k, 2] * b2
        )
    return e, s, r


@inner()
def _expand(tables, piece, t, point, h, d):
    """Return f = |C − P|²/2, f', f'' and |C'|² of a piece at t.

    `h` gets the derivatives of the element, `d` those of the curve (`curve_point`).
    """
    e = curve_point(tables.elements, tables.grid, tables.trims, piece, t, h, d)[0]
    origin = tables.elements.table[e]["origin"]
    f = slope = curvature = speed = 0.0
    for k in range(3):
        r = d[0, k] - (point[k] - origin[k])
        f += r * r
        slope += d[1, k] * r
        curvature += d[2, k] * r
        speed += d[1, k] * d[1, k]
    return 0.5 * f, slope, curvature + speed, speed


@inner()
def _newton_in_bracket(tables, piece, limits, start, point, h, d):
    """Return t and f at the least f = |C − P|²/2 that Newton's method meets within `limits`.

    It begins at `start`; a step out of the bracket of the sign change of f' becomes a bisection.
    It ends with a step of `STEP_TOL` or less, after which f is extrapolated by its Taylor series,
    or after `MAX_ITERATIONS`.
    """
    low, high = limits
    t = start
    best_t = t
    best = math.inf
    for _ in range(MAX_ITERATIONS):
        f, slope, curvature, _ = _expand(tables, piece, t, point, h, d)
        if f < best:
            best = f
            best_t = t
        if slope > 0.0:
            high = t
        else:
            low = t
        new = t - slope / curvature if curvature > 0.0 else 0.5 * (low + high)
        new = min(max(new, limits[0]), limits[1])
        if new != t and not (low <= new <= high):
            new = 0.5 * (low + high)
        if abs(new - t) <= STEP_TOL:
            # The Taylor series gives the gain of the step; smaller changes of f are rounding.
            step = new - t
            gain = -step * (slope + 0.5 * curvature * step)
            if gain > 0.0 and f - gain < best:
                best, best_t = f - gain, new
            break
        t = new
    return best_t, best


@inner()
def closest_on_stretch(tables, leaf, point, best, slack, h):
    """Return the closest point of a curve leaf: t, its distance, whether the search was forced.

    If nothing is nearer than `best`, t is t0, the lower end of the leaf, and the distance `best`.
    Points that gain less than `slack` may be missed. Forced means that an interval was treated as
    convex without proof, to end the search (`MAX_INTERVALS`, or a full stack). Intervals are
    dropped and finished as the cells of a face are (see `global_nb`), by the leaf's bounds on |C'|,
    |C''| and |C'''|.
    """
    piece = -1 - leaf["element"]
    t0 = leaf["box"][0]
    t1 = leaf["box"][1]
    k1 = leaf["bound"][0]
    k2 = leaf["bound"][1]
    k3 = leaf["bound"][2]
    d = scratch(3, 3)
    stack = scratch(40, 2)
    stack[0, 0] = t0
    stack[0, 1] = t1
    top = 1
    best_t = t0
    n_opened = 0
    has_forced = False
    while top > 0:
        top -= 1
        n_opened += 1
        low = stack[top, 0]
        high = stack[top, 1]
        t = 0.5 * (low + high)
        w = 0.5 * (high - low)
        f, slope, curvature, speed = _expand(tables, piece, t, point, h, d)
        distance = math.sqrt(2.0 * f)
        if distance < best:
            best = distance
            best_t = t
        if distance - k1 * w > best - slack:
            continue
        # The distance of the tangent, less the largest departure from it.
        x = -slope / speed if speed > 0.0 else 0.0
        x = min(max(x, -w), w)
        square = 2.0 * f + 2.0 * slope * x + speed * x * x
        square -= ROUNDING * (2.0 * f + speed * w * w)
        if math.sqrt(max(0.0, square)) - 0.5 * k2 * w * w > best - slack:
            continue
        change = w * (3.0 * k1 * k2 + (distance + k1 * w) * k3)
        at_end = low <= t0 or high >= t1
        if not at_end and abs(slope) > w * (abs(curvature) + change):
            continue
        if curvature > change or w < MIN_HALF_WIDTH or n_opened > MAX_INTERVALS or top > 37:
            has_forced = has_forced or (curvature <= change and w >= MIN_HALF_WIDTH)
            start = t if speed == 0.0 else min(max(t - slope / speed, low), high)
            x, f = _newton_in_bracket(tables, piece, (low, high), start, point, h, d)
            distance = math.sqrt(2.0 * f)
            if distance < best:
                best = distance
                best_t = x
            continue
        first = 0 if slope > 0.0 else 1  # pushed last, opened first: the side to which f falls
        stack[top, 0] = t if first == 0 else low
        stack[top, 1] = high if first == 0 else t
        stack[top + 1, 0] = low if first == 0 else t
        stack[top + 1, 1] = t if first == 0 else high
        top += 2
    return best_t, best, has_forced


@inner()
def polish(tables, nearest, point, h):
    """Refine nearest[S], the minimum that a search found on a piece, by Newton's method on f' = 0.

    Near the minimum f is flat, and its rounding hides the last half of the digits. Newton's method
    ends after `POLISH_STEPS` steps, where f is not convex, or before a step longer than
    `POLISH_REACH`.
    """
    piece = int(-1 - nearest[ELEMENT])
    d = scratch(3, 3)
    t = nearest[S]
    for _ in range(POLISH_STEPS):
        _, slope, curvature, _ = _expand(tables, piece, t, point, h, d)
        if curvature <= 0.0:
            break
        step = slope / curvature
        if abs(step) > POLISH_REACH:
            break
        t = min(max(t - step, 0.0), 1.0)
    nearest[S] = t


@inner()
def surface_foot(tables, nearest, h):
    """Return (element, s, t) of the result of a search, on a face or on a trimming piece.

    On a piece `h` is overwritten with the derivatives of the element there.
    """
    if nearest[ELEMENT] >= 0:
        return int(nearest[ELEMENT]), nearest[S], nearest[T]
    d = scratch(3, 3)
    piece = int(-1 - nearest[ELEMENT])
    return curve_point(tables.elements, tables.grid, tables.trims, piece, nearest[S], h, d)
