"""Whether one branch joins two feet: a part of a motion, proved at once.

By the bounds kept around the foot (`neighbourhood_nb`), or by those of a cell about it that is just
large enough. The theorem stands in `branch_nb`.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import SMOOTH
from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.search.certify.certify_records import Cells
from contiga.search.certify.kernels.bend_nb import BENDS, INNER, OUTER, bend_work, principal
from contiga.search.certify.kernels.branch_nb import (
    WIDER,
    by_neighbourhood,
    holds,
    seen_from,
    way_beyond,
    way_within,
)
from contiga.search.certify.kernels.cells_nb import CELL, cells_about, in_element, touched
from contiga.search.certify.kernels.crease_nb import crease_beside, over_crease
from contiga.search.certify.kernels.part_nb import part_of
from contiga.search.certify.kernels.vertex_nb import (
    along_crease,
    common_crease,
    is_corner,
    leaves_vertex,
    stays_at_vertex,
)


@inner(error_model="numpy")
def _by_cell(near, foot, last, seen, size, work):
    """Whether bounds of a cell about the foot, which crosses one smooth side at most, prove it.

    `last` is the start (e, s, t), `seen` a `Seen`, `size` (r, half the cell in s, in t).
    """
    elements, tolerance = near.elements, near.tolerance
    e, s, t = foot
    r, far_s, far_t = size
    side = touched(s, t, far_s, far_t)
    if side == -2 or (side >= 0 and elements.table[e]["kind"][side] != SMOOTH):
        return False
    way = cells_about(elements, foot, last, size, side, work)
    bend, other = work.here, work.beyond
    inner, outer = bend[INNER], bend[OUTER]
    if side >= 0:
        inner = max(inner, other[INNER])
        outer = max(outer, other[OUTER])
    return 0.0 <= way <= r - tolerance and holds((inner, outer), seen, r)


@inner(error_model="numpy")
def least_bend(curvature, m):
    """Least curvature of f at a foot: 1 − max(κ_i m, −κ_o m)."""
    return 1.0 - max(curvature[0] * m, -curvature[1] * m)


@inner(error_model="numpy")
def _by_neighbourhood(near, foot, last, seen, off, boxes):
    """Whether the bounds kept around the foot prove the start `last`, given to within `off`."""
    elements, neighbourhoods, trimmed, tolerance = (
        near.elements,
        near.neighbourhoods,
        near.trimmed,
        near.tolerance,
    )
    e, s, t = foot
    table = elements.table
    patch, other = table[e]["patch"], table[last[0]]["patch"]
    at = parameters(elements, e, s, t)
    neighbourhood = neighbourhoods[e, part_of(s, t)]
    box = table[e]["box"]
    way = math.inf
    if patch == other:
        way = way_within(neighbourhood, box, at, parameters(elements, last[0], last[1], last[2]))
    if way == math.inf and trimmed[patch] == 0 and trimmed[other] == 0:
        way = way_beyond(table, neighbourhoods, foot, last)
    r = by_neighbourhood(neighbourhood, box, at, way, seen, tolerance + off)
    boxes[0, 0], boxes[0, 1], boxes[0, 2] = e, s, t
    boxes[0, 3] = r / (neighbourhood["width"][0] * (box[1] - box[0]))
    boxes[0, 4] = r / (neighbourhood["width"][1] * (box[3] - box[2]))
    return r > 0.0


@inner(error_model="numpy")
def prove_work():
    """Cells for `prove`, nothing in them."""
    return Cells(
        np.empty(BENDS),
        np.empty(BENDS),
        np.empty((4, 6)),
        bend_work(),
        bend_work(),
        np.empty((2, 5)),
    )


@inner(linked=False, error_model="numpy")
def prove(near, foot, last, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1], (e, s, t) each.

    `work` is of `prove_work`; that nothing is trimmed away from its cells is to be seen to.
    """
    elements = near.elements
    moved = 0.0
    work.boxes[:, 0] = -1.0
    if is_corner(foot) and foot == last:
        h = work.derivatives
        return stays_at_vertex(near, foot, path, h) or leaves_vertex(near, foot, path, work)
    if foot[0] != last[0]:
        last, moved = in_element(elements, last, foot[0])
    if foot[0] != last[0]:
        here, off = in_element(elements, foot, last[0])
        if off == 0.0:
            foot = here
    if _by_surroundings(near, foot, (last, moved), path, work):
        return True
    if moved != 0.0:
        return False
    side = crease_beside(elements, foot, last)
    if side >= 0 and over_crease(near, foot, last, side, path, work):
        return True
    side = common_crease(elements, foot, last) if foot[0] == last[0] else -1
    return side >= 0 and along_crease(near, foot, last, side, path, work)


@inner(error_model="numpy")
def _by_surroundings(near, foot, start, path, work):
    """As `prove` where no crease is near; `start` is (last, how far it was moved)."""
    elements, tolerance = near.elements, near.tolerance
    last, moved = start
    e, s, t = foot
    h = work.derivatives
    normal = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, metric = principal(h)
    seen = seen_from(at, normal, path[0], path[1], tolerance)
    m = seen.heights
    # Twice the speeds at the foot: within a hair of the start they are not much larger.
    off = 2.0 * moved * (metric[0] + metric[1])
    if _by_neighbourhood(near, foot, last, seen, off, work.boxes):
        return True
    if not metric[2] > 0.0:
        return False
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    if not least > 0.0:
        return False
    if last[0] == e:
        way = abs(last[1] - s) * metric[0] + abs(last[2] - t) * metric[1]
    else:
        normal_at(elements, last[0], last[1], last[2], h)
        origin = elements.table[last[0]]["origin"]
        square = 0.0
        for c in range(3):
            square += (h[c, 0] + origin[c] - at[c]) ** 2
        way = 1.4 * math.sqrt(square)
    r = WIDER * max(1.1 * way + off + tolerance, seen.slip / least)
    size = (r, CELL * r / metric[2], CELL * r / metric[3])
    return moved == 0.0 and _by_cell(near, foot, last, seen, size, work)
