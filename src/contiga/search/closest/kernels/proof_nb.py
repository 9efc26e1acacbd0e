"""Whether a foot is the closest point of a body, told by how f = |S − P|²/2 rises around it.

About a foot with the Hessian H, which is exact there,

    f(Δ) ≥ f + ½ Δᵀ H Δ − ⅙ (d_ss Δ_s² + 2 d_st |Δ_s Δ_t| + d_tt Δ_t²),

d the largest changes of the second derivatives up to Δ, by bounds of the surface's derivatives. So
no place of a leaf near by is nearer than the foot where H less a third of these is positive
definite. Leaves farther off are left out by their plates, as in a search, and those of which this
tells nothing, as across a kink, are searched cell by cell.
"""

from __future__ import annotations

from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_among_nb import SearchLimits, anywhere
from contiga.search.closest.kernels.global_nb import PRUNE, search_leaf
from contiga.search.hierarchy.kernels.closest_cell_nb import (
    Hessian,
    convex,
    hessian,
    middle,
    scaled,
)
from contiga.search.hierarchy.kernels.curve_nb import LEFT_OUT
from contiga.search.hierarchy.kernels.plates_nb import is_beyond
from contiga.search.hierarchy.kernels.tree_nb import next_leaves

THIRD = 1.0 / 3.0
MAX_OPENED = 64
"""Cells after which a search that begins with the nearest leaves is better."""
BORDER = 1e-9
"""Share of an element that rounding may shift its borders by, in the parameters of the next one."""


@inner()
def _across(box, other, first, low, high):
    """The ends `low` and `high` along s (`first` 0) or t (2) of an element of the parameter box
    `other`, in those of the element of `box`."""
    wide = box[first + 1] - box[first]
    middle = 0.5 * (other[first] + other[first + 1]) - box[first]
    scale, start = (other[first + 1] - other[first]) / wide, middle / wide - 0.5
    return start + scale * low, start + scale * high


@inner()
def _rises_over(tables, surroundings, foot, leaf, local, h):
    """Whether f is nowhere on a leaf less than at the foot = (element, s, t), where `h` are the
    derivatives of the surface; the point is `local` to that element."""
    e, s, t = foot
    table, other = tables.elements.table, leaf["element"]
    s0, s1, t0, t1 = leaf["box"]
    if other != e:
        if table[other]["patch"] != table[e]["patch"]:
            return False
        box, reach = table[e]["box"], surroundings.reach[e]
        s0, s1 = _across(box, table[other]["box"], 0, s0, s1)
        t0, t1 = _across(box, table[other]["box"], 2, t0, t1)
        if s0 < reach[0] - BORDER or s1 > reach[1] + BORDER:
            return False
        if t0 < reach[2] - BORDER or t1 > reach[3] + BORDER:
            return False
    x, y = max(s - s0, s1 - s), max(t - t0, t1 - t)
    f = hessian(middle(h, local, x, y), scaled(surroundings.bound[e], x, y), x, y)
    return convex(Hessian(f.xx, f.xy, f.yy, THIRD * f.dxx, THIRD * f.dxy, THIRD * f.dyy))


@inner(linked=False)
def is_closest(tables, surroundings, foot, point, distance):
    """Whether nothing of a body is nearer to a point than the foot = (element, s, t) at this
    distance; False where that is not told."""
    nodes, bounds, h = stack_int64(128), scratch(128), scratch(4, 6)
    nearest, stack, other = scratch(4), scratch(64, 4), scratch(4, 6)
    slack = PRUNE * tables.scale[1]
    limit = distance - slack
    if limit <= 0.0:
        return True
    e, s, t = foot
    evaluate(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    local = (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])
    nearest[LEFT_OUT] = 0.0
    nodes[0] = 0
    bounds[0] = 0.0
    top, opened = 1, 0
    while True:
        node, top = next_leaves(tables.tree, point, limit * limit, nodes, bounds, top)
        if node < 0:
            return True
        first = tables.tree[node]["first"]
        for k in range(first, first + tables.tree[node]["count"]):
            leaf = tables.leaves[k]
            # Leaves of trimming curves have no place that those of their faces have not.
            if leaf["element"] < 0 or is_beyond(tables.plates[k], point, limit):
                continue
            if _rises_over(tables, surroundings, foot, leaf, local, h):
                continue
            limits = SearchLimits(distance, slack, opened, anywhere())
            best, cells = search_leaf(
                tables.elements, tables.trims, leaf, point, limits, nearest, stack, other
            )
            opened += cells
            if best < limit or nearest[LEFT_OUT] != 0.0 or opened > MAX_OPENED:
                return False
