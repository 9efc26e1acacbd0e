"""Proof that a foot is the closest point of a body, by the growth of f = |S − P|²/2 around it.

Around a foot, with the exact Hessian H there,

    f(Δ) ≥ f + ½ Δᵀ H Δ − ⅙ (d_ss Δ_s² + 2 d_st |Δ_s Δ_t| + d_tt Δ_t²),

where d bound the changes of the second derivatives up to Δ, by bounds of the surface's derivatives.
So no point of a nearby leaf is closer than the foot if H minus a third of d is positive definite.
Distant leaves are excluded by their plates, as in a search. Leaves that neither excludes, such as
leaves across a kink, are searched cell by cell.
"""

from __future__ import annotations

from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_nb import MIN_GAIN, search_leaf
from contiga.search.closest.kernels.global_scope_nb import SearchLimits, all_patches
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
"""Number of cells after which a search that begins with the nearest leaves is faster."""
BORDER_TOL = 1e-9
"""Rounding error of an element's borders in the parameters of the next element."""


@inner()
def _local_interval(box, other, first, low, high):
    """Return an interval (low, high) of one element's parameter in that of another of its patch.

    `low` … `high` is along s (`first` 0) or t (`first` 2) of the element with the parameter box
    `other`; the result is along the same parameter of the element with `box`.
    """
    width = box[first + 1] - box[first]
    middle = 0.5 * (other[first] + other[first + 1]) - box[first]
    scale, start = (other[first + 1] - other[first]) / width, middle / width - 0.5
    return start + scale * low, start + scale * high


@inner()
def _rises_over(tables, surroundings, foot, leaf, local, h):
    """Return whether f is proved nowhere smaller on a leaf than at the foot (element, s, t).

    `h` (4, 6) are the derivatives of the surface at the foot, and `local` is the point relative to
    the origin of the foot's element.
    """
    e, s, t = foot
    table, other = tables.elements.table, leaf["element"]
    s0, s1, t0, t1 = leaf["box"]
    if other != e:
        if table[other]["patch"] != table[e]["patch"]:
            return False
        box, reach = table[e]["box"], surroundings.reach[e]
        s0, s1 = _local_interval(box, table[other]["box"], 0, s0, s1)
        t0, t1 = _local_interval(box, table[other]["box"], 2, t0, t1)
        if s0 < reach[0] - BORDER_TOL or s1 > reach[1] + BORDER_TOL:
            return False
        if t0 < reach[2] - BORDER_TOL or t1 > reach[3] + BORDER_TOL:
            return False
    x, y = max(s - s0, s1 - s), max(t - t0, t1 - t)
    f = hessian(middle(h, local, x, y), scaled(surroundings.bound[e], x, y), x, y)
    return convex(Hessian(f.xx, f.xy, f.yy, THIRD * f.dxx, THIRD * f.dxy, THIRD * f.dyy))


@inner(linked=False)
def is_closest(tables, surroundings, foot, point, distance):
    """Return whether the foot (element, s, t), at a distance, is proved the closest point.

    Points that are closer by less than `MIN_GAIN` tolerances do not count; trimming curves are
    skipped, because they lie on their faces. False if the proof fails or takes more than
    `MAX_OPENED` cells.
    """
    nodes, bounds, h = stack_int64(128), scratch(128), scratch(4, 6)
    nearest, stack, h_cell = scratch(4), scratch(64, 4), scratch(4, 6)
    slack = MIN_GAIN * tables.scale[1]
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
            # Leaves of trimming curves lie on their faces, whose leaves are searched.
            if leaf["element"] < 0 or is_beyond(tables.plates[k], point, limit):
                continue
            if _rises_over(tables, surroundings, foot, leaf, local, h):
                continue
            limits = SearchLimits(distance, slack, opened, all_patches())
            best, cells = search_leaf(
                tables.elements, tables.trims, leaf, point, limits, nearest, stack, h_cell
            )
            opened += cells
            if best < limit or nearest[LEFT_OUT] != 0.0 or opened > MAX_OPENED:
                return False
