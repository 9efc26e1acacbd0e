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

from contiga.jit import inner

ROUNDING = 1e-14
"""Distances of planes are shrunk by this share of the body's size."""
ZERO = 1e-9
"""Corner values down to minus this share of the largest are zero but for that."""


@inner()
def _overhang(cell, m, sign):
    """Return how far a cell reaches beyond its corners in direction sign·m."""
    n = cell["normal"]
    up = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
    along = cell["bulge"] * math.sqrt(max(1.0 - up * up, 0.0))
    up *= sign
    return along + (up * cell["rise"] if up > 0.0 else -up * cell["sink"])


@inner()
def _plane(a, b, m, normal, margin, f):
    """Corner values of the ball between cell a and the plane with normal m before cell b, into "
    "f."""
    k = math.inf
    for i in range(4):
        x = b["corner"][i]
        k = min(k, m[0] * x[0] + m[1] * x[1] + m[2] * x[2])
    _ball_before(a, m, k - _overhang(b, m, -1.0) - margin, normal, f)


@inner()
def _ball_before(a, m, k, normal, f):
    """Write the ball before the plane m·x = k into f (4,)."""
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


@inner()
def _covers(f, v):
    return f[0] >= v[0] and f[1] >= v[1] and f[2] >= v[2] and f[3] >= v[3]


@inner()
def _score(f, v, enough):
    """Rate what a bound leaves of `v`: nine places of the cell, each counted up to `enough`.

    A bound that is negative at a corner claims nothing there; scaled down it stays one where it is
    positive, and takes less from others when it is interpolated with them. One that is zero there
    but for rounding, as at an edge, is left as it is: it grows as steeply as the ball does.
    """
    most = max(max(f[0], f[1]), max(f[2], f[3]))
    if most > enough and min(min(f[0], f[1]), min(f[2], f[3])) < -ZERO * most:
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


@inner()
def unit(x, y, z, m):
    """Write (x, y, z) at length one into m; False where it has no length."""
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return False
    m[0] = x / length
    m[1] = y / length
    m[2] = z / length
    return True


@inner()
def unit_normal(h, m):
    """Write the unit normal of the derivatives `h` into m; False where there is none."""
    return unit(
        h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2],
        h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2],
        h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2],
        m,
    )


@inner()
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
        if not unit(
            normal[1] * z - normal[2] * y,
            normal[2] * x - normal[0] * z,
            normal[0] * y - normal[1] * x,
            work,
        ):
            continue
        along = 0.0
        for c3 in range(3):
            along += work[c3] * (b["middle"][c3] - a["middle"][c3])
        if along < 0.0:
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


@inner()
def lower(a, b, pole, limits, v, work):
    """Lower the corner values `v` of cell a to what cell b leaves of them; whether it took any.

    `limits` are `BallLimits`, `work` is `PlaneWork`.
    """
    f, m, e, best, slopes = work.trial, work.plane, work.axis, work.best, work.slopes
    normal = pole[0]
    margin = ROUNDING * limits.size
    even = _even_ball(a, b, pole, v, margin, m)
    if even >= max(max(v[0], v[1]), max(v[2], v[3])):
        return False
    best[:] = even
    top = _score(best, v, limits.goal)
    # Across the normal of b, from middle to middle, and tilted from what parts the cells best.
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
            if not _axis(a, b, normal, e, m):
                break
            # Tilts of the parting plane worth trying: as far from the ball as the cell b allows.
            level = -math.inf
            for i in range(4):
                x = a["corner"][i]
                level = max(level, normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2])
            start = math.inf
            for i in range(4):
                x = b["corner"][i]
                start = min(start, e[0] * x[0] + e[1] * x[1] + e[2] * x[2])
            flat = max(a["extent"] / (4.0 * limits.cap), 1e-6)
            most = 1.0 / flat
            slack = 1e-12 * limits.size + b["rise"] + b["sink"]
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
        if k > 2:
            tau = slopes[k - 3]
            unit(e[0] - tau * normal[0], e[1] - tau * normal[1], e[2] - tau * normal[2], m)
        _plane(a, b, m, normal, margin, f)
        if _covers(f, v):
            return False
        score = _score(f, v, limits.goal)
        if score > top:
            top = score
            for i in range(4):
                best[i] = f[i]
    for i in range(4):
        v[i] = min(v[i], best[i])
    return True


@inner()
def clear_ball(a, normal, side, v):
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


@inner()
def _even_ball(a, b, pole, v, margin, m):
    """Radius of balls that all touch cell a and are parted from cell b by one plane, not over v.

    The balls' centres Q + ρN lie within the bilinear patch of those at the corners, but for its
    bulge and the wobble of the normals.
    """
    normal, side = pole
    rho = max(max(v[0], v[1]), max(v[2], v[3]))
    sign = 2.0 * side - 1.0
    best = 0.0
    for _ in range(2):
        if not unit(
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


@inner()
def far_box(a, tree, node, normal, v, work):
    """Return whether the plane that touches a node's box, towards the cell, keeps all corner
    values."""
    f, m, x = work.trial, work.plane, a["middle"]
    low, high = tree[node]["low"], tree[node]["high"]
    px = min(max(x[0], low[0]), high[0])
    py = min(max(x[1], low[1]), high[1])
    pz = min(max(x[2], low[2]), high[2])
    if not unit(px - x[0], py - x[1], pz - x[2], m):
        return False
    _ball_before(a, m, m[0] * px + m[1] * py + m[2] * pz, normal, f)
    return _covers(f, v)
