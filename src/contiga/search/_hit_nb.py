"""First entry of a swept point: the segment p0 → p1 against the exact surface.

S(s, t) = p0 + τ (p1 − p0) is solved cell by cell. With M = [S_s, S_t, −d] at the cell's middle,
every solution in the cell lies within |rows of M⁻¹| · (departure from the tangent plane) of the
linear one: a cell whose interval misses it is dropped. Where the derivative changes so little
over the cell that Newton's map contracts (‖M⁻¹ ΔM‖ < 1) there is at most one solution, and
Newton's method finds it; other cells are halved (interval Newton, Moore, Kearfott & Cloud 2009,
ch. 8).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._bounds_nb import cell_bounds
from contiga.search._element_nb import evaluate, parameters
from contiga.search._global_nb import DEEP, has_pole, in_face
from contiga.search._sides_nb import normal_at

OK, NOT_FINITE, NO_HIT, AT_START = 0, 5, 6, 7
POINT = 1e-10
"""A cell smaller than this share of the body is taken as a point: at a pole, where the path
grazes, and where it meets a kink in the parametrisation."""
MAX_CELLS = 20000
INCLUSIVE = 1e-9
"""Solutions this far outside an element (local parameters) still belong to it."""


@njit(inline="always")
def _segment_meets(node, p, inverse, limit):
    """Whether p + τ d, 0 ≤ τ ≤ limit, meets the node's box, and the smallest such τ.

    `inverse` is one over d, component by component.
    """
    near = 0.0
    far = limit
    for c in range(3):
        low = node["low"][c] - p[c]
        high = node["high"][c] - p[c]
        if math.isinf(inverse[c]):
            if low > 0.0 or high < 0.0:
                return False, 0.0
        else:
            a = low * inverse[c]
            b = high * inverse[c]
            near = max(near, min(a, b))
            far = min(far, max(a, b))
    return near <= far * (1.0 + 1e-12) + 1e-15, near


@njit(cache=True)
def _reciprocal(x):
    return 1.0 / x if x != 0.0 else math.inf


@njit(cache=True)
def _inverse(h, hs, ht, d, m):
    """Inverse of [S_s hs, S_t ht, −d] into m[3, 3]; returns False where it is singular."""
    a0 = h[0, 1] * hs
    a1 = h[1, 1] * hs
    a2 = h[2, 1] * hs
    b0 = h[0, 2] * ht
    b1 = h[1, 2] * ht
    b2 = h[2, 2] * ht
    # Rows of the inverse are the cross products of the other two columns over the determinant.
    n0 = a1 * b2 - a2 * b1
    n1 = a2 * b0 - a0 * b2
    n2 = a0 * b1 - a1 * b0
    det = -(n0 * d[0] + n1 * d[1] + n2 * d[2])
    size = math.sqrt((n0 * n0 + n1 * n1 + n2 * n2) * (d[0] ** 2 + d[1] ** 2 + d[2] ** 2))
    if abs(det) <= 1e-14 * size or size == 0.0:
        return False
    i = 1.0 / det
    m[0, 0] = -(b1 * d[2] - b2 * d[1]) * i
    m[0, 1] = -(b2 * d[0] - b0 * d[2]) * i
    m[0, 2] = -(b0 * d[1] - b1 * d[0]) * i
    m[1, 0] = -(d[1] * a2 - d[2] * a1) * i
    m[1, 1] = -(d[2] * a0 - d[0] * a2) * i
    m[1, 2] = -(d[0] * a1 - d[1] * a0) * i
    m[2, 0] = n0 * i
    m[2, 1] = n1 * i
    m[2, 2] = n2 * i
    return True


@njit(cache=True)
def _row_length(m, i):
    return math.sqrt(m[i, 0] ** 2 + m[i, 1] ** 2 + m[i, 2] ** 2)


@njit(cache=True)
def _solve(elements, e, cell, start, p, d, h, m):
    """Newton for (s, t, τ) from `start`; returns converged, s, t, τ."""
    s, t, tau = start
    width = cell[1] - cell[0]
    height = cell[3] - cell[2]
    length = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
    for _ in range(12):
        evaluate(elements, e, s, t, h)
        if not _inverse(h, 1.0, 1.0, d, m):
            return False, s, t, tau
        r0 = p[0] + tau * d[0] - h[0, 0]
        r1 = p[1] + tau * d[1] - h[1, 0]
        r2 = p[2] + tau * d[2] - h[2, 0]
        ds = m[0, 0] * r0 + m[0, 1] * r1 + m[0, 2] * r2
        dt = m[1, 0] * r0 + m[1, 1] * r1 + m[1, 2] * r2
        dtau = m[2, 0] * r0 + m[2, 1] * r1 + m[2, 2] * r2
        s = min(max(s + ds, cell[0] - width), cell[1] + width)
        t = min(max(t + dt, cell[2] - height), cell[3] + height)
        tau += dtau
        miss = math.sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        if max(abs(ds), abs(dt), abs(dtau)) < 1e-13 or miss < 1e-15 * length:
            return True, s, t, tau
    return False, s, t, tau


@njit(inline="always")
def _next_entry(elements, leaf, path, best, top, work):
    """Next solution below `best` at which the path enters through one leaf, trimmed or not.

    `path` is (p0, d, slack, size): slack is how far before its start (in fractions) a hit still
    counts, size the length below which a cell is a point. The stack in `work` holds the `top` cells
    still to be searched. Returns the fraction (infinity where there is none), s, t, and how many
    cells are left. Whoever asks decides about trims: handed to every leaf, their arrays would cost
    more than the search.
    """
    stack, h, m, k = work
    p0, d, slack, small = path
    e = leaf["element"]
    tau_found, s_found, t_found = math.inf, 0.0, 0.0
    pole = has_pole(elements, e)
    whole = DEEP * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
    origin = elements.table[e]["origin"]
    p = (p0[0] - origin[0], p0[1] - origin[1], p0[2] - origin[2])
    opened = 0
    while top > 0 and tau_found == math.inf:
        top -= 1
        opened += 1
        s0, s1, t0, t1 = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        sc = 0.5 * (s0 + s1)
        tc = 0.5 * (t0 + t1)
        hs = 0.5 * (s1 - s0)
        ht = 0.5 * (t1 - t0)
        evaluate(elements, e, sc, tc, h)
        r0 = p[0] - h[0, 0]
        r1 = p[1] - h[1, 0]
        r2 = p[2] - h[2, 0]
        if 4.0 * hs * ht < whole and pole:
            cell_bounds(elements, e, (s0, s1, t0, t1), k)
        else:
            for c in range(9):
                k[c] = leaf["bound"][c]
        # The part of the path nearest to the cell's middle must come within its radius.
        kx = k[0] * hs
        ky = k[1] * ht
        dd = d[0] ** 2 + d[1] ** 2 + d[2] ** 2
        tau = -(r0 * d[0] + r1 * d[1] + r2 * d[2]) / dd
        tau = min(max(tau, -slack), min(1.0 + slack, best))
        a0 = r0 + tau * d[0]
        a1 = r1 + tau * d[1]
        a2 = r2 + tau * d[2]
        if a0 * a0 + a1 * a1 + a2 * a2 > ((kx + ky) * (1.0 + 1e-9)) ** 2:
            continue
        kxx = k[2] * hs * hs
        kxy = k[3] * hs * ht
        kyy = k[4] * ht * ht
        bend = 0.5 * (kxx + kyy) + kxy
        n0 = h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2]
        n1 = h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2]
        n2 = h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2]
        n = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if n > 0.0:
            # Both ends on the same side of the slab that holds the cell.
            w = (r0 * n0 + r1 * n1 + r2 * n2) / n
            w1 = w + (d[0] * n0 + d[1] * n1 + d[2] * n2) / n
            pad = bend + slack * math.sqrt(dd)
            if (w > pad and w1 > pad) or (w < -pad and w1 < -pad):
                continue
            # Leaving wherever in the cell: n·d > 0 for all its normals.
            turn = ((kxx + kxy) * ky + kx * (kxy + kyy)) / (hs * ht) * math.sqrt(dd)
            if n0 * d[0] + n1 * d[1] + n2 * d[2] > turn * (1.0 + 1e-6):
                continue
        unique = False
        start = (sc, tc, tau)
        if _inverse(h, hs, ht, d, m):
            x = m[0, 0] * r0 + m[0, 1] * r1 + m[0, 2] * r2
            y = m[1, 0] * r0 + m[1, 1] * r1 + m[1, 2] * r2
            z = m[2, 0] * r0 + m[2, 1] * r1 + m[2, 2] * r2
            g0 = _row_length(m, 0)
            g1 = _row_length(m, 1)
            g2 = _row_length(m, 2)
            tiny = INCLUSIVE / min(hs, ht)
            if (
                abs(x) - g0 * bend > 1.0 + tiny
                or abs(y) - g1 * bend > 1.0 + tiny
                or z + g2 * bend < -slack
                or z - g2 * bend > min(best, 1.0 + slack)
            ):
                continue
            unique = max(g0, g1, g2 * 1.0) * (kxx + 2.0 * kxy + kyy) < 1.0
            start = (sc + min(max(x, -1.0), 1.0) * hs, tc + min(max(y, -1.0), 1.0) * ht, z)
        point_like = kx + ky < small
        if unique or point_like:
            good, s, t, tau_s = _solve(elements, e, (s0, s1, t0, t1), start, p, d, h, m)
            inside = (
                s >= s0 - INCLUSIVE
                and s <= s1 + INCLUSIVE
                and t >= t0 - INCLUSIVE
                and t <= t1 + INCLUSIVE
            )
            if point_like and not (good and inside):
                s = sc
                t = tc
                tau_s = tau
                good = inside = True
            if good and inside and -slack <= tau_s <= 1.0 + slack and tau_s < best:
                s = min(max(s, -0.5), 0.5)
                t = min(max(t, -0.5), 0.5)
                n0, n1, n2 = normal_at(elements, e, s, t, h)
                if n0 * d[0] + n1 * d[1] + n2 * d[2] < 0.0:
                    tau_found, s_found, t_found = tau_s, s, t
            continue
        if opened > MAX_CELLS or top > 61:
            continue
        extent_s = h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2
        extent_t = h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2
        if extent_s * hs * hs >= extent_t * ht * ht:
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s0, sc, t0, t1
            stack[top + 1, 0], stack[top + 1, 1] = sc, s1
            stack[top + 1, 2], stack[top + 1, 3] = t0, t1
        else:
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s0, s1, t0, tc
            stack[top + 1, 0], stack[top + 1, 1] = s0, s1
            stack[top + 1, 2], stack[top + 1, 3] = tc, t1
        top += 2
    return tau_found, s_found, t_found, top


@njit(inline="always")
def _next_leaves(tree, p0, inverse, best, top, queue):
    """Next node of leaves that the path meets before `best`, −1 for none, and nodes left."""
    nodes, entry = queue
    found = -1
    while top > 0 and found < 0:
        top -= 1
        if entry[top] > best:
            continue
        node = nodes[top]
        if tree[node]["count"] > 0:
            found = node
            continue
        first = tree[node]["first"]
        limit = min(1.0, best)
        a, near_a = _segment_meets(tree[first], p0, inverse, limit)
        b, near_b = _segment_meets(tree[first + 1], p0, inverse, limit)
        swap = 1 if a and b and near_a <= near_b else 0  # the nearer child goes on top
        for i in range(2):
            child = i ^ swap
            if (a, b)[child]:
                nodes[top] = first + child
                entry[top] = (near_a, near_b)[child]
                top += 1
    return found, top


@njit(cache=True, nogil=True)
def first_hits(tables, p0, p1, rows, out, start, stop):
    """First entry of each segment p0[rows[i]] → p1[rows[i]] into row i of `out`."""
    tree, leaves, elements, trims = tables.tree, tables.leaves, tables.elements, tables.trims
    stack, h = np.empty((64, 4)), np.empty((4, 6))
    work = (stack, h, np.empty((3, 3)), np.empty(9))
    queue = (np.empty(128, np.int64), np.empty(128))
    small = POINT * tables.scale[0]
    for i in range(start, stop):
        j = rows[i]
        p = (p0[j, 0], p0[j, 1], p0[j, 2])
        d = (p1[j, 0] - p[0], p1[j, 1] - p[1], p1[j, 2] - p[2])
        length = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
        out.patch[i] = -1
        out.fraction[i] = math.nan
        out.uv[i] = math.nan
        out.point[i] = math.nan
        if not (math.isfinite(p[0] + p[1] + p[2]) and math.isfinite(length)):
            out.status[i] = NOT_FINITE
            continue
        out.status[i] = NO_HIT
        if length == 0.0 or leaves.shape[0] == 0:
            continue
        slack = tables.scale[1] / length
        path = (p, d, slack, small)
        inverse = (_reciprocal(d[0]), _reciprocal(d[1]), _reciprocal(d[2]))
        best, e, s, t = math.inf, -1, 0.0, 0.0
        queue[0][0] = 0
        queue[1][0] = 0.0
        top = 1 if _segment_meets(tree[0], p, inverse, 1.0)[0] else 0
        while top > 0:
            node, top = _next_leaves(tree, p, inverse, best + slack, top, queue)
            if node < 0:
                break
            for k in range(tree[node]["first"], tree[node]["first"] + tree[node]["count"]):
                leaf = leaves[k]
                if leaf["element"] < 0:
                    continue
                for c in range(4):
                    stack[0, c] = leaf["box"][c]
                cells = 1
                while cells > 0:
                    tau, s_k, t_k, cells = _next_entry(elements, leaf, path, best, cells, work)
                    if tau < best and in_face(elements, trims, leaf["element"], s_k, t_k):
                        best, e, s, t = tau, leaf["element"], s_k, t_k
        if e < 0:
            continue
        evaluate(elements, e, s, t, h)
        out.fraction[i] = min(max(best, 0.0), 1.0)
        out.patch[i] = elements.table[e]["patch"]
        out.uv[i, 0], out.uv[i, 1] = parameters(elements, e, s, t)
        for c in range(3):
            out.point[i, c] = h[c, 0] + elements.table[e]["origin"][c]
        out.status[i] = AT_START if best <= 0.0 else OK
