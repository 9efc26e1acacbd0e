"""Touching balls: how large a ball may touch a surface and contain no other point of it.

Lower bounds of the one-sided local reach (Federer 1959, doi 10.1090/S0002-9947-1959-0110078-1)

    ρ(Q) = inf |X − Q|² / (2 N·(X − Q))   over X of the surface with N·(X − Q) > 0,

N the normal at Q to the side in question. If all of a piece of the surface is beyond a plane m·x =
k, ρ is at least (k − m·Q)/(1 + m·N), the radius of the ball that touches both. Over a cell that is
an affine function of Q except for the cell's bulge, so four values at its corners, interpolated
bilinearly, bound ρ; the least of several such functions is bounded by the least corner values.
"""

from __future__ import annotations

import math

from contiga.jit import inner

ROUNDING = 1e-14
"""Share of the body's size by which distances of planes are reduced for rounding."""
ZERO_TOL = 1e-9
"""Negative corner values, as a share of the largest, that count as zero."""


@inner()
def _overhang(cell, m, sign):
    """Return a bound of how far a cell extends beyond its corners in direction sign·m.

    m is a unit vector.
    """
    n = cell["normal"]
    cosine = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
    lateral = cell["bulge"] * math.sqrt(max(1.0 - cosine * cosine, 0.0))
    cosine *= sign
    return lateral + (cosine * cell["rise"] if cosine > 0.0 else -cosine * cell["sink"])


@inner()
def _ball_before(a, m, k, normal, f):
    """Write the corner values of the ball between cell a and the plane m·x = k to f (4,).

    Interpolated, they are lower bounds of its radius for all places and normals of the cell, to the
    side of `normal`; negative where a corner may be beyond the plane.
    """
    half = 0.5 * (
        (m[0] + normal[0]) ** 2 + (m[1] + normal[1]) ** 2 + (m[2] + normal[2]) ** 2
    )  # 1 + m·N without cancellation
    half = min(half, 2.0)
    tilt = a["tilt"]
    cos_tilt = math.sqrt(1.0 - tilt * tilt)
    if half - 1.0 >= cos_tilt:
        factor = 2.0
    else:
        factor = half * cos_tilt + tilt * tilt / (1.0 + cos_tilt)
        factor += math.sqrt(half * (2.0 - half)) * tilt
    factor = max(factor, 1e-300)
    k -= _overhang(a, m, 1.0)
    for i in range(4):
        x = a["corner"][i]
        f[i] = (k - (m[0] * x[0] + m[1] * x[1] + m[2] * x[2])) / factor


@inner()
def _is_above(f, v):
    """Return whether no corner value f is below v."""
    return f[0] >= v[0] and f[1] >= v[1] and f[2] >= v[2] and f[3] >= v[3]


@inner()
def _score(f, v, goal):
    """Rate what a bound f leaves of `v`: the sum over nine places of the cell, each up to `goal`.

    Scales f in place where it exceeds the goal and is negative at a corner. A bound that is
    negative at a corner proves nothing there. Scaled down it remains a bound where it is positive,
    and reduces others less when it is interpolated with them. One that is zero there except for
    rounding, as at an edge, is not scaled: it grows as steeply as the ball does.
    """
    largest = max(max(f[0], f[1]), max(f[2], f[3]))
    if largest > goal and min(min(f[0], f[1]), min(f[2], f[3])) < -ZERO_TOL * largest:
        for i in range(4):
            f[i] *= goal / largest
    a, b, c, d = min(f[0], v[0]), min(f[1], v[1]), min(f[2], v[2]), min(f[3], v[3])
    total = 0.0
    for i in range(3):
        x = (0.1, 0.5, 0.9)[i]
        low = a + x * (c - a)
        high = b + x * (d - b)
        for j in range(3):
            y = (0.1, 0.5, 0.9)[j]
            total += min(max(low + y * (high - low), 0.0), goal)
    return total


@inner()
def unit(x, y, z, m):
    """Write the unit vector of (x, y, z) to m; return False if it has no length."""
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return False
    m[0] = x / length
    m[1] = y / length
    m[2] = z / length
    return True


@inner()
def unit_normal(h, m):
    """Write the unit normal from the derivatives `h` to `m`; return False if there is none."""
    return unit(
        h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2],
        h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2],
        h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2],
        m,
    )


@inner()
def _separating_axis(a, b, normal, e, work):
    """Write the direction in the tangent plane of cell a that best separates it from cell b to e.

    Candidates are perpendicular to the edges of both cells; best is the largest sum of the gaps
    from the corners of a. Returns False if every edge is along the normal.
    """
    best = -math.inf
    for k in range(8):
        c = a["corner"] if k < 4 else b["corner"]
        i = (0, 1, 3, 2)[k % 4]
        j = (1, 3, 2, 0)[k % 4]
        x = c[j, 0] - c[i, 0]
        y = c[j, 1] - c[i, 1]
        z = c[j, 2] - c[i, 2]
        if not unit(
            normal[1] * z - normal[2] * y,
            normal[2] * x - normal[0] * z,
            normal[0] * y - normal[1] * x,
            work,
        ):
            continue
        offset = 0.0
        for d in range(3):
            offset += work[d] * (b["middle"][d] - a["middle"][d])
        if offset < 0.0:
            for d in range(3):
                work[d] = -work[d]
        low = math.inf
        for i in range(4):
            corner = b["corner"][i]
            low = min(low, work[0] * corner[0] + work[1] * corner[1] + work[2] * corner[2])
        total = 0.0
        max_gap = -math.inf
        for i in range(4):
            corner = a["corner"][i]
            gap = low - (work[0] * corner[0] + work[1] * corner[1] + work[2] * corner[2])
            total += max(gap, 0.0)
            max_gap = max(max_gap, gap)
        if total == 0.0:
            total = min(max_gap, 0.0)
        if total > best:
            best = total
            for d in range(3):
                e[d] = work[d]
    return best > -math.inf


@inner()
def lower_by_cell(a, b, frame, limits, v, work):
    """Lower the corner values `v` of cell a to their bound by cell b; return whether any is lower.

    The bound is the one of best `_score` of a uniform radius and up to nine planes that separate
    the cells. If one of them lowers no value, `v` stays as it is. `frame` is (normal, side),
    `limits` are `BallLimits`, `work` is `PlaneWork`.
    """
    f, m, e, best, slopes = work.trial, work.plane, work.axis, work.best, work.slopes
    normal = frame[0]
    margin = ROUNDING * limits.size
    uniform = _uniform_radius(a, b, frame, v, margin, m)
    if uniform >= max(max(v[0], v[1]), max(v[2], v[3])):
        return False
    best[:] = uniform
    best_score = _score(best, v, limits.goal)
    # Planes with the normals ± of b, across the line of middles, and tilts of the separating plane.
    for k in range(9):
        if k < 2:
            sign = 1.0 - 2.0 * k
            for c in range(3):
                m[c] = sign * b["normal"][c]
            if m[0] == 0.0 and m[1] == 0.0 and m[2] == 0.0:
                continue
        elif k == 2:
            if not unit(
                b["middle"][0] - a["middle"][0],
                b["middle"][1] - a["middle"][1],
                b["middle"][2] - a["middle"][2],
                m,
            ):
                continue
        elif k == 3:
            if not _separating_axis(a, b, normal, e, m):
                break
            # Tilts of the separating plane away from the ball, as far as the cell b allows.
            height = -math.inf
            for i in range(4):
                x = a["corner"][i]
                height = max(height, normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2])
            edge = math.inf
            for i in range(4):
                x = b["corner"][i]
                edge = min(edge, e[0] * x[0] + e[1] * x[1] + e[2] * x[2])
            min_tilt = max(a["extent"] / (4.0 * limits.cap), 1e-6)
            max_slope = 1.0 / min_tilt
            slack = 1e-12 * limits.size + b["rise"] + b["sink"]
            for i in range(4):
                x = b["corner"][i]
                z = normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2] - height - slack
                y = e[0] * x[0] + e[1] * x[1] + e[2] * x[2] - edge
                if z > 0.0:
                    max_slope = min(max_slope, y / z)
            slopes[0] = max_slope
            slopes[1] = 0.5 * max_slope
            slopes[2] = min(max_slope, 1.0 / max(a["tilt"], min_tilt))
            slopes[3] = min(max_slope, 0.3 / max(a["tilt"], min_tilt))
            slopes[4] = min(max_slope, 3.0)
            slopes[5] = 0.0
        if k > 2:
            slope = slopes[k - 3]
            unit(e[0] - slope * normal[0], e[1] - slope * normal[1], e[2] - slope * normal[2], m)
        offset = math.inf
        for i in range(4):
            x = b["corner"][i]
            offset = min(offset, m[0] * x[0] + m[1] * x[1] + m[2] * x[2])
        _ball_before(a, m, offset - _overhang(b, m, -1.0) - margin, normal, f)
        if _is_above(f, v):
            return False
        score = _score(f, v, limits.goal)
        if score > best_score:
            best_score = score
            for i in range(4):
                best[i] = f[i]
    for i in range(4):
        v[i] = min(v[i], best[i])
    return True


@inner()
def enclosing_ball(a, normal, side, v):
    """Return centre (x, y, z) and radius of a ball that contains all balls that touch the cell.

    Their radii are at most the largest of the corner values `v`, to the side of `normal`.
    """
    radius = max(max(v[0], v[1]), max(v[2], v[3]))
    sign = 2.0 * side - 1.0
    x = a["middle"][0] + radius * normal[0]
    y = a["middle"][1] + radius * normal[1]
    z = a["middle"][2] + radius * normal[2]
    square = 0.0
    for i in range(4):
        p = a["corner"][i]
        n = a["corner_normal"][i]
        dx = p[0] + sign * radius * n[0] - x
        dy = p[1] + sign * radius * n[1] - y
        dz = p[2] + sign * radius * n[2] - z
        square = max(square, dx * dx + dy * dy + dz * dz)
    return x, y, z, radius + math.sqrt(square) + radius * a["wobble"] + a["bulge"]


@inner()
def _uniform_radius(a, b, frame, v, margin, m):
    """Return a radius of balls that touch cell a anywhere and that one plane separates from cell b.

    It is at most the largest of `v`, found in two trials, zero if a plane separates none. The
    balls' centres Q + ρN are in the bilinear patch of those at the corners, except for its bulge
    and the wobble of the normals. `m` is work.
    """
    normal, side = frame
    trial_radius = max(max(v[0], v[1]), max(v[2], v[3]))
    sign = 2.0 * side - 1.0
    best = 0.0
    for _ in range(2):
        if not unit(
            b["middle"][0] - a["middle"][0] - trial_radius * normal[0],
            b["middle"][1] - a["middle"][1] - trial_radius * normal[1],
            b["middle"][2] - a["middle"][2] - trial_radius * normal[2],
            m,
        ):
            return best
        offset = math.inf
        for i in range(4):
            corner = b["corner"][i]
            offset = min(offset, m[0] * corner[0] + m[1] * corner[1] + m[2] * corner[2])
        offset -= _overhang(b, m, -1.0) + margin + _overhang(a, m, 1.0)
        radius = trial_radius
        for i in range(4):
            corner = a["corner"][i]
            n = a["corner_normal"][i]
            gap = offset - (m[0] * corner[0] + m[1] * corner[1] + m[2] * corner[2])
            factor = 1.0 + sign * (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) + a["wobble"]
            if gap <= 0.0:
                return best
            if gap < radius * factor:
                radius = gap / factor
        best = max(best, radius)
        if best >= trial_radius:
            return best
        trial_radius = best
    return best


@inner()
def box_is_far(a, tree, node, normal, v, work):
    """Return whether the plane that touches a node's box lowers no corner value of cell a.

    The plane is perpendicular to the line from the cell's middle to the nearest place of the box;
    False if the middle is in the box.
    """
    f, m, x = work.trial, work.plane, a["middle"]
    low, high = tree[node]["low"], tree[node]["high"]
    px = min(max(x[0], low[0]), high[0])
    py = min(max(x[1], low[1]), high[1])
    pz = min(max(x[2], low[2]), high[2])
    if not unit(px - x[0], py - x[1], pz - x[2], m):
        return False
    _ball_before(a, m, m[0] * px + m[1] * py + m[2] * pz, normal, f)
    return _is_above(f, v)
