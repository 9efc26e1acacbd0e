"""The closest point of a body: branch and bound with rigorous lower bounds.

A leaf is searched cell by cell. With the point's residual r and the derivative bounds of the
leaf, a cell is dropped when

* its tangent parallelogram, less the largest departure from it, is farther than the best foot;
* the gradient of f = |S − P|²/2 cannot vanish in it (at a border or a kink it may press outward);

and it is finished when f is convex on it (the Hessian at its middle outweighs the largest change
over the cell), because Newton then finds its only minimum. What is neither is halved.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.bounds_nb import look_closer
from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.num.codes import CUT, IN, POLE, SMOOTH
from contiga.num.jit import inner
from contiga.search.kernels.curve_nb import closest_on_stretch
from contiga.search.kernels.local_nb import expand
from contiga.search.kernels.tree_nb import box_distance2

MAX_CELLS = 20000
"""Cells one query may open; then it is given up."""
EASY = 12
"""Cells of a leaf after which its bounds are taken for too loose, and each cell gets its own."""
MANY = 100
"""Cells of a query after which all get bounds of their own."""
SMALLEST = 1e-6
"""Half-size of a cell (local parameters) that is not halved further."""
DEEP = 1.0 / 64.0
"""Cells of an element with a pole, smaller than this share of their leaf, get bounds of their own:
the leaf's do not shrink towards the pole."""
MINIMUM_STEPS = 30
SEEN = 1.0 + 1e-9
"""Rounding of a distance that a search starts from, with much to spare."""
DROPPED, GIVEN_UP = 0.5, 1.0
"""What a search has left out: a cell too small to be halved, or all that was over its budget."""
UNTOLD = 100.0
"""A smallest cell that may come closer than the best foot by this many times the least gain asked
for (1e-9 of the body's size) is not told from a closer foot."""
PRUNE = 10.0
"""A cell must promise this many tolerances less distance to be opened."""


@inner()
def in_face(elements, trims, e, s, t):
    """Whether (s, t) of element e belongs to the trimmed face."""
    state = elements.table[e]["trim"]
    if state == CUT:
        u, v = parameters(elements, e, s, t)
        return point_in_trim(trims, elements.table[e]["patch"], u, v) != 0
    return state == IN


@inner()
def has_pole(elements, e):
    """Whether a side of element e is one point."""
    kind = elements.table[e]["kind"]
    return kind[0] == POLE or kind[1] == POLE or kind[2] == POLE or kind[3] == POLE


@inner()
def _slopes_away(elements, e, side, kept, g, change):
    """Whether f has no minimum in a cell because its slope across it keeps its sign.

    `kept` tells for `side` (0: s, 2: t) which of the two ends the cell reaches; a minimum may
    stand there against the slope where the surface has a kink or ends. `g` is the slope in the
    cell's middle, `change` its largest change.
    """
    kind = elements.table[e]["kind"]
    if g > change:
        return not (kept[0] and kind[side] != SMOOTH)
    if -g > change:
        return not (kept[1] and kind[side + 1] != SMOOTH)
    return False


@inner()
def _plate_distance(rr, rx, ry, xx, xy, yy):
    """Smallest |r + x a + y b| over |x|, |y| ≤ 1, from the products of r, a and b."""
    det = xx * yy - xy * xy
    if det > 1e-12 * xx * yy:
        x = (-rx * yy + ry * xy) / det
        y = (-ry * xx + rx * xy) / det
        if -1.0 <= x <= 1.0 and -1.0 <= y <= 1.0:
            return math.sqrt(max(0.0, rr + x * rx + y * ry))
    best = math.inf
    for k in range(2):
        fix = 1.0 - 2.0 * k
        y = -(ry + fix * xy) / yy if yy > 0.0 else 0.0
        y = min(max(y, -1.0), 1.0)
        best = min(best, rr + xx + y * y * yy + 2.0 * (fix * rx + y * ry + fix * y * xy))
        x = -(rx + fix * xy) / xx if xx > 0.0 else 0.0
        x = min(max(x, -1.0), 1.0)
        best = min(best, rr + yy + x * x * xx + 2.0 * (fix * ry + x * rx + fix * x * xy))
    return math.sqrt(max(0.0, best))


@inner()
def _cell_minimum(elements, e, cell, point, h):
    """Minimum of f on a cell where it is convex: s, t and the distance.

    Newton's method with the sides of the cell as an active set; steps that do not lower f are
    halved.
    """
    s = 0.5 * (cell[0] + cell[1])
    t = 0.5 * (cell[2] + cell[3])
    q = expand(elements, e, s, t, point, h)
    for _ in range(MINIMUM_STEPS):
        f, g_s, g_t, h_ss, h_st, h_tt, _, _ = q
        fixed_s = (s <= cell[0] and g_s > 0.0) or (s >= cell[1] and g_s < 0.0)
        fixed_t = (t <= cell[2] and g_t > 0.0) or (t >= cell[3] and g_t < 0.0)
        d_s = 0.0 if fixed_s else -g_s / h_ss
        d_t = 0.0 if fixed_t else -g_t / h_tt
        if not fixed_s and not fixed_t:
            det = h_ss * h_tt - h_st * h_st
            n_s = (-g_s * h_tt + g_t * h_st) / det
            n_t = (-g_t * h_ss + g_s * h_st) / det
            # Where it would leave the cell at once, the steps of one variable each stand in.
            if not (
                (s <= cell[0] and n_s < 0.0)
                or (s >= cell[1] and n_s > 0.0)
                or (t <= cell[2] and n_t < 0.0)
                or (t >= cell[3] and n_t > 0.0)
            ):
                d_s = n_s
                d_t = n_t
        better = False
        for _ in range(MINIMUM_STEPS):
            new_s = min(max(s + d_s, cell[0]), cell[1])
            new_t = min(max(t + d_t, cell[2]), cell[3])
            if new_s == s and new_t == t:
                break
            q = expand(elements, e, new_s, new_t, point, h)
            better = q[0] < f
            if better:
                break
            d_s *= 0.5
            d_t *= 0.5
        if not better:
            return s, t, math.sqrt(2.0 * f)
        s = new_s
        t = new_t
        if f - q[0] <= 1e-15 * f:
            break
    return s, t, math.sqrt(2.0 * q[0])


@inner()
def _search_leaf(elements, trims, leaf, point, limits, found, stack, h):
    """Improve the best distance and `found` (element, s, t) by one surface leaf.

    `limits` is (best, slack, cells opened before). Returns the best distance and the number of
    cells opened here. `stack` (64, 4) and `h` are work.
    """
    best, slack, before = limits
    easy = EASY if before < MANY else 0
    e = leaf["element"]
    k = np.empty(9)
    pole = has_pole(elements, e)
    whole = DEEP * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
    origin = elements.table[e]["origin"]
    local = (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])
    for c in range(4):
        stack[0, c] = leaf["box"][c]
    top = 1
    opened = 0
    while top > 0:
        top -= 1
        opened += 1
        cell = (stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3])
        sc = 0.5 * (cell[0] + cell[1])
        tc = 0.5 * (cell[2] + cell[3])
        hs = 0.5 * (cell[1] - cell[0])
        ht = 0.5 * (cell[3] - cell[2])
        evaluate(elements, e, sc, tc, h)
        rr = rx = ry = xx = xy = yy = hxx = hxy = hyy = 0.0
        for c in range(3):
            r = h[c, 0] - local[c]
            x = h[c, 1] * hs
            y = h[c, 2] * ht
            rr += r * r
            rx += r * x
            ry += r * y
            xx += x * x
            xy += x * y
            yy += y * y
            hxx += r * h[c, 3]
            hxy += r * h[c, 4]
            hyy += r * h[c, 5]
        distance = math.sqrt(rr)
        if distance < best and in_face(elements, trims, e, sc, tc):
            best = distance
            found[0] = e
            found[1] = sc
            found[2] = tc
        hard = opened > easy
        if hard or (pole and 4.0 * hs * ht < whole):
            if look_closer(elements, e, cell, local, best - slack, k):
                continue
        else:
            for c in range(9):
                k[c] = leaf["bound"][c]
        kx = k[0] * hs
        ky = k[1] * ht
        kxx = k[2] * hs * hs
        kxy = k[3] * hs * ht
        kyy = k[4] * ht * ht
        bend = 0.5 * (kxx + kyy) + kxy
        least = _plate_distance(rr, rx, ry, xx, xy, yy) - bend
        if least > best - slack:
            continue
        kxxx = k[5] * hs**3
        kxxy = k[6] * hs * hs * ht
        kxyy = k[7] * hs * ht * ht
        kyyy = k[8] * ht**3
        far = distance + kx + ky
        hxx = hxx * hs * hs + xx
        hxy = hxy * hs * ht + xy
        hyy = hyy * ht * ht + yy
        dxx = 3.0 * kxx * kx + 2.0 * kxy * kx + ky * kxx + far * (kxxx + kxxy)
        dyy = 3.0 * kyy * ky + 2.0 * kxy * ky + kx * kyy + far * (kyyy + kxyy)
        dxy = 2.0 * kxy * (kx + ky) + kxx * ky + kx * kyy + far * (kxxy + kxyy)
        if _slopes_away(
            elements, e, 0, (cell[0] <= -0.5, cell[1] >= 0.5), rx, abs(hxx) + dxx + abs(hxy) + dxy
        ) or _slopes_away(
            elements, e, 2, (cell[2] <= -0.5, cell[3] >= 0.5), ry, abs(hyy) + dyy + abs(hxy) + dxy
        ):
            continue
        low = hxx - dxx
        low_y = hyy - dyy
        convex = low > 0.0 and low_y > 0.0 and low * low_y > (abs(hxy) + dxy) ** 2
        if convex:
            s, t, distance = _cell_minimum(elements, e, cell, point, h)
            if distance < best and in_face(elements, trims, e, s, t):
                best = distance
                found[0] = e
                found[1] = s
                found[2] = t
            continue
        if max(hs, ht) < SMALLEST:
            if least < best - UNTOLD * slack:
                found[3] = max(found[3], DROPPED)
            continue
        if before + opened > MAX_CELLS or top > 61:
            found[3] = GIVEN_UP
            continue
        # Halved where the surface is longer, or f varies more; the lower half is pushed last.
        wide = abs(rx) + abs(hxx) >= abs(ry) + abs(hyy) if hard else xx >= yy
        if wide:
            if rx > 0.0:
                stack[top] = (sc, cell[1], cell[2], cell[3])
                stack[top + 1] = (cell[0], sc, cell[2], cell[3])
            else:
                stack[top] = (cell[0], sc, cell[2], cell[3])
                stack[top + 1] = (sc, cell[1], cell[2], cell[3])
        elif ry > 0.0:
            stack[top] = (cell[0], cell[1], tc, cell[3])
            stack[top + 1] = (cell[0], cell[1], cell[2], tc)
        else:
            stack[top] = (cell[0], cell[1], cell[2], tc)
            stack[top + 1] = (cell[0], cell[1], tc, cell[3])
        top += 2
    return best, opened


@inner()
def _least_middle(tables, point, reach, nodes, bounds):
    """Distance to the nearest of the leaves' middles, or `reach`: no foot is farther.

    It costs a tenth of a search and spares it three quarters of its cells on a body of many faces.
    """
    tree = tables.tree
    leaves = tables.leaves
    x, y, z = point
    best = reach * reach
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1 if leaves.shape[0] > 0 else 0
    while top > 0:
        top -= 1
        if bounds[top] >= best:
            continue
        n = tree[nodes[top]]["count"]
        first = tree[nodes[top]]["first"]
        if n == 0:
            a = box_distance2(tree, first, x, y, z)
            b = box_distance2(tree, first + 1, x, y, z)
            near = 0 if a <= b else 1
            nodes[top] = first + 1 - near
            bounds[top] = b if near == 0 else a
            nodes[top + 1] = first + near
            bounds[top + 1] = a if near == 0 else b
            top += 2
            continue
        for k in range(first, first + n):
            m = leaves[k]["middle"]
            best = min(best, (m[0] - x) ** 2 + (m[1] - y) ** 2 + (m[2] - z) ** 2)
    return math.sqrt(best)


@inner()
def closest(tables, point, only, reach, found, h):
    """Closest point to `point` no farther than `reach`, on patch `only` (−1: on any).

    Fills `found` with element, s, t, or with −1 − piece and the piece's parameter when a trimming
    curve is closest, and found[3] with 0, DROPPED or GIVEN_UP. Returns the distance,
    infinite where nothing was found.
    """
    tree = tables.tree
    leaves = tables.leaves
    elements = tables.elements
    trims = tables.trims
    x, y, z = point
    best = reach
    found[3] = 0.0
    hit = False
    opened = 0
    nodes = np.empty(128, np.int64)
    bounds = np.empty(128)
    stack = np.empty((64, 4))
    slack = PRUNE * tables.scale[1]
    # Above the bound by more than a leaf must promise, so that the leaf it comes from is opened.
    if only < 0 and reach == math.inf:
        seen = _least_middle(tables, point, best, nodes, bounds)
        best = min(best, seen * SEEN + 2.0 * slack)
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1 if leaves.shape[0] > 0 else 0
    while top > 0:
        top -= 1
        limit = best - slack
        if limit <= 0.0 and hit:
            break
        if bounds[top] > limit * limit:
            continue
        node = nodes[top]
        n = tree[node]["count"]
        first = tree[node]["first"]
        if n == 0:
            a = box_distance2(tree, first, x, y, z)
            b = box_distance2(tree, first + 1, x, y, z)
            near = 0 if a <= b else 1
            nodes[top] = first + 1 - near
            bounds[top] = b if near == 0 else a
            nodes[top + 1] = first + near
            bounds[top + 1] = a if near == 0 else b
            top += 2
            continue
        for k in range(first, first + n):
            leaf = leaves[k]
            if only >= 0 and leaf["patch"] != only:
                continue
            e = leaf["element"]
            if e >= 0:
                if opened > MAX_CELLS:
                    found[3] = GIVEN_UP
                    continue
                distance, cells = _search_leaf(
                    elements, trims, leaf, point, (best, slack, opened), found, stack, h
                )
                opened += cells
                if distance < best:
                    best = distance
                    hit = True
            else:
                r, distance, left = closest_on_stretch(tables, leaf, point, best, slack, h)
                if left:
                    found[3] = max(found[3], DROPPED)
                if distance < best:
                    best = distance
                    found[0] = e
                    found[1] = r
                    hit = True
    return best if hit else math.inf
