"""Touching balls: how large a ball may touch a surface from inside or outside and hold no more.

Lower bounds of the one-sided local reach (Federer 1959, doi 10.1090/S0002-9947-1959-0110078-1)

    ρ(Q) = inf |X − Q|² / (2 N·(X − Q))   over X of the surface with N·(X − Q) > 0,

N the normal at Q to the side in question. A plane m·x = k with all of a piece of the surface
beyond it keeps ρ at least at (k − m·Q)/(1 + m·N): the ball that touches both. Over a cell that is
an affine function of Q but for the cell's bulge, so four values at its corners, interpolated
bilinearly, bound ρ; the least of several such functions is bounded by the least corner values.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.geometry._trim_nb import point_in_trim
from contiga.search._element_nb import evaluate, locate, parameters
from contiga.search._tree_nb import box_distance2

SAFE = 1.0 - 1e-8
"""Radii are shrunk by this for rounding,"""
ROUNDING = 1e-14
"""and distances of planes by this share of the body's size."""
SAMPLES = 5
ENOUGH = 2.0
"""Radii beyond this many goals are not worth a loss of smaller ones."""


@njit(cache=True)
def _overhang(cell, m, sign):
    """How far a cell reaches beyond its corners in direction sign·m."""
    n = cell["normal"]
    up = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
    along = cell["bulge"] * math.sqrt(max(1.0 - up * up, 0.0))
    up *= sign
    return along + (up * cell["rise"] if up > 0.0 else -up * cell["sink"])


@njit(cache=True)
def _plane(a, b, m, normal, margin, f):
    """Corner values of the ball between cell a and the plane with normal m before cell b, into f.

    Returns False where the plane says nothing.
    """
    k = math.inf
    for i in range(4):
        x = b["corner"][i]
        k = min(k, m[0] * x[0] + m[1] * x[1] + m[2] * x[2])
    return _ball_before(a, m, k - _overhang(b, m, -1.0) - margin, normal, f)


@njit(cache=True)
def _ball_before(a, m, k, normal, f):
    half = 0.5 * (
        (m[0] + normal[0]) ** 2 + (m[1] + normal[1]) ** 2 + (m[2] + normal[2]) ** 2
    )  # 1 + m·N without loss
    half = min(half, 2.0)
    tilt = a["tilt"]
    level = math.sqrt(1.0 - tilt * tilt)
    if half - 1.0 >= level:
        den = 2.0
    else:
        den = half * level + tilt * tilt / (1.0 + level) + math.sqrt(half * (2.0 - half)) * tilt
    den = max(den, 1e-300)
    k -= _overhang(a, m, 1.0)
    for i in range(4):
        x = a["corner"][i]
        f[i] = (k - (m[0] * x[0] + m[1] * x[1] + m[2] * x[2])) / den
    return True


@njit(cache=True)
def _covers(f, v):
    return f[0] >= v[0] and f[1] >= v[1] and f[2] >= v[2] and f[3] >= v[3]


@njit(cache=True)
def _score(f, v, enough):
    """What a bound leaves of `v`: nine places of the cell, each counted up to `enough`.

    A bound that is negative at a corner claims nothing there; scaled down it stays one where it is
    positive, and takes less from others when it is interpolated with them.
    """
    most = max(max(f[0], f[1]), max(f[2], f[3]))
    if most > enough and min(min(f[0], f[1]), min(f[2], f[3])) < 0.0:
        for i in range(4):
            f[i] *= enough / most
    a, b, c, d = min(f[0], v[0]), min(f[1], v[1]), min(f[2], v[2]), min(f[3], v[3])
    total = 0.0
    for i in range(3):
        x = (0.1, 0.5, 0.9)[i]
        low = a + x * (c - a)
        high = b + x * (d - b)
        for j in range(3):
            y = (0.1, 0.5, 0.9)[j]
            total += min(max(low + y * (high - low), 0.0), enough)
    return total


@njit(cache=True)
def _unit(x, y, z, m):
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return False
    m[0] = x / length
    m[1] = y / length
    m[2] = z / length
    return True


@njit(cache=True)
def _axis(a, b, normal, e, work):
    """The direction in the tangent plane of cell a that parts it best from cell b, into e."""
    best = -math.inf
    for k in range(8):
        c = a["corner"] if k < 4 else b["corner"]
        i = (0, 1, 3, 2)[k % 4]
        j = (1, 3, 2, 0)[k % 4]
        x = c[j, 0] - c[i, 0]
        y = c[j, 1] - c[i, 1]
        z = c[j, 2] - c[i, 2]
        if not _unit(
            normal[1] * z - normal[2] * y,
            normal[2] * x - normal[0] * z,
            normal[0] * y - normal[1] * x,
            work,
        ):
            continue
        ahead = 0.0
        for c3 in range(3):
            ahead += work[c3] * (b["middle"][c3] - a["middle"][c3])
        if ahead < 0.0:
            for c3 in range(3):
                work[c3] = -work[c3]
        low = math.inf
        for i in range(4):
            x3 = b["corner"][i]
            low = min(low, work[0] * x3[0] + work[1] * x3[1] + work[2] * x3[2])
        total = 0.0
        most = -math.inf
        for i in range(4):
            x3 = a["corner"][i]
            gap = low - (work[0] * x3[0] + work[1] * x3[1] + work[2] * x3[2])
            total += max(gap, 0.0)
            most = max(most, gap)
        if total == 0.0:
            total = min(most, 0.0)
        if total > best:
            best = total
            for c3 in range(3):
                e[c3] = work[c3]
    return best > -math.inf


@njit(cache=True)
def _slopes(a, b, normal, e, limits, slopes):
    """Tilts of the parting plane worth trying: as far from the ball as the cell b allows."""
    size, cap, _ = limits
    level = -math.inf
    for i in range(4):
        x = a["corner"][i]
        level = max(level, normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2])
    start = math.inf
    for i in range(4):
        x = b["corner"][i]
        start = min(start, e[0] * x[0] + e[1] * x[1] + e[2] * x[2])
    flat = max(a["extent"] / (4.0 * cap), 1e-6)
    most = 1.0 / flat
    slack = 1e-12 * size + b["rise"] + b["sink"]
    for i in range(4):
        x = b["corner"][i]
        z = normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2] - level - slack
        y = e[0] * x[0] + e[1] * x[1] + e[2] * x[2] - start
        if z > 0.0:
            most = min(most, y / z)
    slopes[0] = most
    slopes[1] = 0.5 * most
    slopes[2] = min(most, 1.0 / max(a["tilt"], flat))
    slopes[3] = min(most, 0.3 / max(a["tilt"], flat))
    slopes[4] = min(most, 3.0)
    slopes[5] = 0.0
    return 6


@njit(cache=True)
def _lower(a, b, pole, limits, v, work):
    """Lower the corner values `v` of cell a to what cell b leaves of them; whether it took any."""
    f, m, e, best, slopes = work
    normal = pole[0]
    margin = ROUNDING * limits[0]
    even = _even_ball(a, b, pole, v, margin, m)
    if even >= max(max(v[0], v[1]), max(v[2], v[3])):
        return False
    best[:] = even
    top = _score(best, v, limits[2])
    for k in range(3):
        if k < 2:
            sign = 1.0 - 2.0 * k
            m[0] = sign * b["normal"][0]
            m[1] = sign * b["normal"][1]
            m[2] = sign * b["normal"][2]
        else:
            if not _unit(
                b["middle"][0] - a["middle"][0],
                b["middle"][1] - a["middle"][1],
                b["middle"][2] - a["middle"][2],
                m,
            ):
                continue
        if m[0] == 0.0 and m[1] == 0.0 and m[2] == 0.0:
            continue
        _plane(a, b, m, normal, margin, f)
        if _covers(f, v):
            return False
        score = _score(f, v, limits[2])
        if score > top:
            top = score
            best[:] = f
    if _axis(a, b, normal, e, m):
        count = _slopes(a, b, normal, e, limits, slopes)
        for k in range(count):
            tau = slopes[k]
            _unit(e[0] - tau * normal[0], e[1] - tau * normal[1], e[2] - tau * normal[2], m)
            _plane(a, b, m, normal, margin, f)
            if _covers(f, v):
                return False
            score = _score(f, v, limits[2])
            if score > top:
                top = score
                best[:] = f
    for i in range(4):
        v[i] = min(v[i], best[i])
    return True


@njit(cache=True)
def _clear_ball(a, normal, side, v):
    """Middle and radius (four numbers) of a ball that holds all balls that touch the cell."""
    rho = max(max(v[0], v[1]), max(v[2], v[3]))
    sign = 2.0 * side - 1.0
    x = a["middle"][0] + rho * normal[0]
    y = a["middle"][1] + rho * normal[1]
    z = a["middle"][2] + rho * normal[2]
    apart = 0.0
    for i in range(4):
        p = a["corner"][i]
        n = a["corner_normal"][i]
        dx = p[0] + sign * rho * n[0] - x
        dy = p[1] + sign * rho * n[1] - y
        dz = p[2] + sign * rho * n[2] - z
        apart = max(apart, dx * dx + dy * dy + dz * dz)
    return x, y, z, rho + math.sqrt(apart) + rho * a["wobble"] + a["bulge"]


@njit(cache=True)
def _even_ball(a, b, pole, v, margin, work):
    """Radius of balls that all touch cell a and are parted from cell b by one plane, not over v.

    The balls' centres Q + ρN lie within the bilinear patch of those at the corners, but for its
    bulge and the wobble of the normals.
    """
    normal, side = pole
    m = work
    rho = max(max(v[0], v[1]), max(v[2], v[3]))
    sign = 2.0 * side - 1.0
    best = 0.0
    for _ in range(2):
        if not _unit(
            b["middle"][0] - a["middle"][0] - rho * normal[0],
            b["middle"][1] - a["middle"][1] - rho * normal[1],
            b["middle"][2] - a["middle"][2] - rho * normal[2],
            m,
        ):
            return best
        k = math.inf
        for i in range(4):
            c = b["corner"][i]
            k = min(k, m[0] * c[0] + m[1] * c[1] + m[2] * c[2])
        k -= _overhang(b, m, -1.0) + margin + _overhang(a, m, 1.0)
        radius = rho
        for i in range(4):
            c = a["corner"][i]
            n = a["corner_normal"][i]
            gap = k - (m[0] * c[0] + m[1] * c[1] + m[2] * c[2])
            den = 1.0 + sign * (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) + a["wobble"]
            if gap <= 0.0:
                return best
            if gap < radius * den:
                radius = gap / den
        best = max(best, radius)
        if best >= rho:
            return best
        rho = best
    return best


@njit(cache=True)
def _far_box(a, tree, node, normal, v, work):
    """Whether the plane that touches a node's box, towards the cell, keeps all corner values."""
    f, m, _, _, _ = work
    x = a["middle"]
    near = m
    k = 0.0
    for c in range(3):
        near[c] = min(max(x[c], tree[node]["low"][c]), tree[node]["high"][c])
    px, py, pz = near[0], near[1], near[2]
    if not _unit(px - x[0], py - x[1], pz - x[2], m):
        return False
    k = m[0] * px + m[1] * py + m[2] * pz
    return _ball_before(a, m, k, normal, f) and _covers(f, v)


@njit(cache=True)
def _is_home(home, b):
    """Whether cell b lies in the smooth block of `home`."""
    if home["patch"] != b["patch"]:
        return False
    box = home["uv"]
    own = b["uv"]
    slack = 1e-9 * (box[1] - box[0]), 1e-9 * (box[3] - box[2])
    for i in range(3):
        u = (0.0, 1.0, -1.0)[i] * home["period"][0]
        if i > 0 and u == 0.0:
            continue
        if not (own[0] + u >= box[0] - slack[0] and own[1] + u <= box[1] + slack[0]):
            continue
        for j in range(3):
            v = (0.0, 1.0, -1.0)[j] * home["period"][1]
            if j > 0 and v == 0.0:
                continue
            if own[2] + v >= box[2] - slack[1] and own[3] + v <= box[3] + slack[1]:
                return True
    return False


@njit(cache=True)
def _touching(q, x, normal):
    """Radius of the ball that touches at q, on the side of `normal`, and passes through x."""
    square = 0.0
    height = 0.0
    for c in range(3):
        d = x[c] - q[c]
        square += d * d
        height += d * normal[c]
    return 0.5 * square / height if height > 1e-12 * math.sqrt(square) else math.inf


@njit(cache=True)
def _take_samples(elements, trims, centre, a, cap, samples):
    """Points, normals and touching radii by bend of five places of a cell; how many are in."""
    point, normal, above = samples
    h = np.empty((4, 6))
    e = a["element"]
    n = 0
    origin = elements.table[e]["origin"]
    box = a["box"]
    for k in range(SAMPLES):
        x = (0.5, 0.05, 0.05, 0.95, 0.95)[k]
        y = (0.5, 0.05, 0.95, 0.05, 0.95)[k]
        s = box[0] + x * (box[1] - box[0])
        t = box[2] + y * (box[3] - box[2])
        if a["state"] == 2:
            u, w = parameters(elements, e, s, t)
            if point_in_trim(trims, a["patch"], u, w) == 0:
                continue
        evaluate(elements, e, s, t, h)
        for c in range(3):
            point[n, c] = h[c, 0] + (origin[c] - centre[c])
        if not _unit(
            h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2],
            h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2],
            h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2],
            normal[n],
        ):
            continue
        above[n, 0] = cap
        above[n, 1] = cap
        above[n, 2] = x
        above[n, 3] = y
        _bend_limits(h, normal[n], above[n])
        n += 1
    return n


@njit(cache=True)
def _bend_limits(h, n, above):
    ee = ff = gg = l = m = r = 0.0
    for c in range(3):
        ee += h[c, 1] * h[c, 1]
        ff += h[c, 1] * h[c, 2]
        gg += h[c, 2] * h[c, 2]
        l += n[c] * h[c, 3]
        m += n[c] * h[c, 4]
        r += n[c] * h[c, 5]
    det = ee * gg - ff * ff
    if not det > 0.0:
        return
    mean = 0.5 * (ee * r - 2.0 * ff * m + gg * l) / det
    root = math.sqrt(max(mean * mean - (l * r - m * m) / det, 0.0))
    if root - mean > 0.0:
        above[0] = min(above[0], 1.0 / (root - mean))
    if mean + root > 0.0:
        above[1] = min(above[1], 1.0 / (mean + root))


@njit(cache=True)
def _lower_samples(samples, n, b, side):
    point, normal, above = samples
    sign = -1.0 if side == 0 else 1.0
    m = np.empty(3)
    for k in range(n):
        for c in range(3):
            m[c] = sign * normal[k, c]
        for i in range(4):
            above[k, side] = min(above[k, side], _touching(point[k], b["corner"][i], m))
        above[k, side] = min(above[k, side], _touching(point[k], b["middle"], m))


@njit(cache=True)
def _bound_cell(body, a, home, limits, value, samples):
    """Lower the corner values (2, 4) of cell a by every cell of the tree; `samples` too."""
    cells, tree, order = body
    count = samples[1]
    work = (np.empty(4), np.empty(3), np.empty(3), np.empty(4), np.empty(6))
    normal = np.empty((2, 3))
    normal[0] = -a["normal"]
    normal[1] = a["normal"]
    stack = np.empty(256, np.int64)
    stack[0] = 0
    top = 1
    affects = np.empty(2, np.bool_)
    while top > 0:
        top -= 1
        node = stack[top]
        for side in range(2):
            v = value[side]
            affects[side] = False
            if max(max(v[0], v[1]), max(v[2], v[3])) <= 0.0:
                continue
            x, y, z, r = _clear_ball(a, normal[side], side, v)
            if box_distance2(tree, node, x, y, z) >= r * r:
                continue
            affects[side] = not _far_box(a, tree, node, normal[side], v, work)
        if not (affects[0] or affects[1]):
            continue
        first = tree[node]["first"]
        if tree[node]["count"] == 0:
            x = a["middle"]
            near = box_distance2(tree, first, x[0], x[1], x[2])
            far = box_distance2(tree, first + 1, x[0], x[1], x[2])
            swap = 1 if far < near else 0
            stack[top] = first + 1 - swap
            stack[top + 1] = first + swap
            top += 2
            continue
        for i in range(first, first + tree[node]["count"]):
            b = cells[order[i]]
            if _is_home(home, b):
                continue
            for side in range(2):
                if affects[side] and _lower(a, b, (normal[side], side), limits, value[side], work):
                    _lower_samples(samples[0], count, b, side)


@njit(cache=True)
def _wanting(value, samples, n, goal):
    """Share of the samples at which less than half of what may be there is proved."""
    above = samples[2]
    if n == 0:
        return 0.0
    total = 0.0
    for k in range(n):
        x = above[k, 2]
        y = above[k, 3]
        for side in range(2):
            v = value[side]
            sure = (1.0 - x) * ((1.0 - y) * v[0] + y * v[1]) + x * ((1.0 - y) * v[2] + y * v[3])
            if sure < 0.5 * min(above[k, side], goal):
                total += 1.0
    return 0.5 * total / n


@njit(cache=True, nogil=True)
def bound_cells(body, surface, homes, limits, result, start, stop):
    """Corner values (2, 4) and what is wanting, of the rows start … stop of a body's cells.

    `body` is the cells with the tree over them, `surface` the elements, trims and centre,
    `limits` size, cap and goal, `result` the rows to do, values and wants.
    """
    cells = body[0]
    elements, trims, centre = surface
    size, cap, goal = limits
    rows, value, want = result
    samples = (np.empty((SAMPLES, 3)), np.empty((SAMPLES, 3)), np.empty((SAMPLES, 4)))
    for i in range(start, stop):
        k = rows[i]
        a = cells[k]
        home = homes[a["home"]]
        known = value[k].copy()
        for side in range(2):
            value[k, side, :] = min(cap, SAFE * home["near"][side])
        n = _take_samples(elements, trims, centre, a, cap, samples)
        if home["near"][0] > 0.0 or home["near"][1] > 0.0:
            _bound_cell(body, a, home, (size, cap, ENOUGH * goal), value[k], (samples, n))
        value[k] *= SAFE
        for side in range(2):  # what was known of the whole holds for its half
            if np.maximum(known[side], 0.0).sum() >= np.maximum(value[k, side], 0.0).sum():
                value[k, side] = known[side]
        want[k] = _wanting(value[k], samples, n, goal)


@njit(cache=True)
def radius_at(balls, grid, patch, u, v, side):
    """Radius known of the touching ball at (u, v), zero where nothing is known."""
    e, s, t = locate(grid, patch, u, v)
    row = balls.elements[e]
    x = (s + 0.5) * row["cells"][0]
    y = (t + 0.5) * row["cells"][1]
    i = min(int(x), row["cells"][0] - 1)
    j = min(int(y), row["cells"][1] - 1)
    node = row["first"] + i * row["stride"] + j
    x -= i
    y -= j
    below = balls.child[node]
    while below >= 0:
        node = below >> 1
        if below & 1 == 0:
            x *= 2.0
            if x >= 1.0:
                x -= 1.0
                node += 1
        else:
            y *= 2.0
            if y >= 1.0:
                y -= 1.0
                node += 1
        below = balls.child[node]
    c = balls.value[node, side]
    r = (1.0 - x) * ((1.0 - y) * c[0] + y * c[1]) + x * ((1.0 - y) * c[2] + y * c[3])
    return max(r, 0.0)


@njit(cache=True, nogil=True)
def radii(balls, grid, feet, rows, side, out, start, stop):
    """`radius_at` the feet (patch, uv) of rows[start:stop]; rows without a patch have none."""
    patch, uv = feet
    for i in range(start, stop):
        k = rows[i]
        if patch[k] >= 0:
            out[i] = radius_at(balls, grid, patch[k], uv[k, 0], uv[k, 1], side)
        else:
            out[i] = 0.0
