"""Surroundings of parts beside which elements are narrow: whole rows and columns of parts.

Cutting a surface leaves slivers, and of a sliver a quarter (`neighbourhood_nb`) is next to nothing.
Here the parts around one are taken row by row and column by column, from element to element, until
they are about as deep in each direction as parts nearby are wide. They make a rectangle: what
stands where a row and a column cross is the same whichever is gone along first, and all sides
within are smooth. Along a side parameters go on from part to part, and so a way that leaves the
rectangle on the left has gone through every column there, from side to side, in parts of the
rectangle: its length is the sum of the least widths of these columns at least.
"""

from __future__ import annotations

from contiga.arrays.codes import IN, SMOOTH
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import INNER, WIDTH_S
from contiga.search.certify.kernels.part_nb import PARTS, scales, take_metric

MAX_PARTS = 12
"""Parts in one direction,"""
ACROSS = 2 * MAX_PARTS + 1
"""and in both."""
NEAR = 0.75
"""Share of the width of parts nearby that surroundings are to be deep at least,"""
DEEP = 2.0
"""and where they hardly bend."""
BENT = 2.0
"""Wider surroundings may be curved this many times as much,"""
FLAT = 0.1
"""or so much that they turn by this (radians)."""
LEFT, RIGHT, DOWN, UP = 0, 1, 2, 3
"""Directions: of falling and growing s, and of t, in the element that is started from."""


@inner(error_model="numpy")
def _beside(table, cell, way):
    """The part beside a part in a direction; of element −1 where no smooth side leads there.

    A part is (element, i, j, whether its s runs along the t of the start, and whether the
    directions s and t of the start run backwards in it).
    """
    e, i, j, swap, back_s, back_t = cell
    axis, on = way >> 1, way & 1
    own_axis = axis ^ swap
    on = on ^ (back_s if axis == 0 else back_t)
    k = (i if own_axis == 0 else j) + 2 * on - 1
    if 0 <= k < PARTS:
        return e, (k if own_axis == 0 else i), (j if own_axis == 0 else k), swap, back_s, back_t
    side = 2 * own_axis + on
    if table[e]["kind"][side] != SMOOTH:
        return -1, 0, 0, 0, 0, 0
    there, flip = table[e]["neighbour_side"][side], table[e]["flip"][side]
    k = 0 if there & 1 == 0 else PARTS - 1
    along = j if own_axis == 0 else i
    if flip == 1:
        along = PARTS - 1 - along
    turned = (way & 1) ^ (1 - (there & 1))
    back_s, back_t = (turned, back_t ^ flip) if axis == 0 else (back_s ^ flip, turned)
    i, j = (k, along) if there < 2 else (along, k)
    return table[e]["neighbour"][side], i, j, (there >> 1) ^ axis, back_s, back_t


@inner(error_model="numpy")
def _far(table, cell, way, count):
    """The part so many parts off in a direction."""
    for _ in range(count):
        if cell[0] >= 0:
            cell = _beside(table, cell, way)
    return cell


@inner(error_model="numpy")
def _width(raw, cell, axis):
    """Least width of a part along an axis of the start."""
    return raw[cell[0], cell[1] * PARTS + cell[2], WIDTH_S + (axis ^ cell[3])] / PARTS


@inner(error_model="numpy")
def _at(table, home, a, b):
    """The part a columns to the right of a part and b rows up; of element −1 where that is not the
    same whichever is gone first."""
    across, along = (RIGHT if a >= 0 else LEFT), (UP if b >= 0 else DOWN)
    cell = _far(table, _far(table, home, across, abs(a)), along, abs(b))
    other = _far(table, _far(table, home, along, abs(b)), across, abs(a))
    if cell != other:
        return -1, 0, 0, 0, 0, 0
    return cell


@inner(error_model="numpy")
def _look(table, raw, home, extents, work):
    """Least widths of the columns and rows around a part, and the largest curvatures in them, into
    `work` = ((2, 2 MAX_PARTS + 1), (2,)).

    Returns whether they make a rectangle, of which nothing is trimmed away that the patch of the
    part does not tell.
    """
    widths, bent = work
    widths[:] = 1e300
    bent[:] = 0.0
    patch = table[home[0]]["patch"]
    same = whole = True
    for a in range(-extents[LEFT], extents[RIGHT] + 1):
        for b in range(-extents[DOWN], extents[UP] + 1):
            cell = _at(table, home, a, b)
            if cell[0] < 0:
                return False
            widths[0, MAX_PARTS + a] = min(widths[0, MAX_PARTS + a], _width(raw, cell, 0))
            widths[1, MAX_PARTS + b] = min(widths[1, MAX_PARTS + b], _width(raw, cell, 1))
            for c in range(2):
                bent[c] = max(bent[c], raw[cell[0], cell[1] * PARTS + cell[2], INNER + c])
            same = same and table[cell[0]]["patch"] == patch
            whole = whole and table[cell[0]]["trim"] == IN
    return same or whole


@inner(error_model="numpy")
def _edge(table, cell, way):
    """Parameter at which a part ends in a direction; to the bit that of its element, if it does."""
    axis, end = way >> 1, way & 1
    low, high = table[cell[0]]["box"][2 * axis], table[cell[0]]["box"][2 * axis + 1]
    k = cell[1 + axis] + end
    return low if k == 0 else (high if k == PARTS else low + k * (high - low) / PARTS)


@inner(error_model="numpy")
def widen(elements, raw, e, part, neighbourhood):
    """Put wider surroundings of a part (i, j) of element e into its record, if they are any good.

    `raw` (elements, parts, 6) bounds every part by itself. Speeds and widths are in local
    parameters of e. Surroundings that end somewhere or turn round a pole stay as they are.
    """
    table = elements.table
    home = (e, part[0], part[1], 0, 0, 0)
    ends = neighbourhood["ends"]
    if neighbourhood["pole"] >= 0 or ends[0] + ends[1] + ends[2] + ends[3] > 0:
        return
    # How wide parts of this element and of those beside it are, along the narrower axis.
    nearby = 1e300
    for axis in range(2):
        widest = _width(raw, home, axis)
        k = home[1 + axis]
        for end in range(2):
            cell = _far(table, home, 2 * axis + end, k + 1 if end == 0 else PARTS - k)
            if cell[0] >= 0:
                widest = max(widest, _width(raw, cell, axis))
        nearby = min(nearby, widest)
    bent = max(neighbourhood["curvature"][0], neighbourhood["curvature"][1])
    wanted = max(NEAR * nearby, min(DEEP * nearby, FLAT / bent))
    if not neighbourhood["room"] < wanted:
        return
    extents, own = stack_int64(4), stack_int64(4)
    widths, bends = scratch(2, ACROSS), scratch(2)
    for way in range(4):
        depth, count, cell = 0.0, 0, _beside(table, home, way)
        while cell[0] >= 0 and count < MAX_PARTS and depth < wanted:
            depth += _width(raw, cell, way >> 1)
            count += 1
            cell = _beside(table, cell, way)
        extents[way] = count
    if not _look(table, raw, home, extents, (widths, bends)):
        return
    # A way that leads out goes through all columns or rows on one side.
    room = 1e300
    for way in range(4):
        depth = 0.0
        for k in range(1, extents[way] + 1):
            depth += widths[way >> 1, MAX_PARTS + (k if way & 1 == 1 else -k)]
        room = min(room, depth)
    turn = max(BENT * bent * room, FLAT)
    if not (room > neighbourhood["room"] and max(bends[0], bends[1]) * room <= turn):
        return
    neighbourhood["room"] = room
    for c in range(2):
        neighbourhood["curvature"][c] = max(neighbourhood["curvature"][c], bends[c])
    # As far as parts have the parameters of the patch, turned in no way, they are told in these.
    for way in range(4):
        cell, count = home, 0
        while count < extents[way]:
            after = _beside(table, cell, way)
            same = table[after[0]]["patch"] == table[e]["patch"]
            if after[3] | after[4] | after[5] != 0 or not same:
                break
            if _edge(table, after, way ^ 1) != _edge(table, cell, way):
                break
            cell = after
            count += 1
        own[way] = count
        neighbourhood["block"][way] = _edge(table, cell, way)
        k = home[1 + (way >> 1)]
        beyond = extents[way] - (k if way & 1 == 0 else PARTS - 1 - k)
        neighbourhood["reach"][way] = min(max(beyond, 0), PARTS)
    for a in range(-own[LEFT], own[RIGHT] + 1):
        for b in range(-own[DOWN], own[UP] + 1):
            n, i, j, _, _, _ = _at(table, home, a, b)
            scale_s, scale_t = scales(elements, e, n)
            take_metric(neighbourhood, raw[n, i * PARTS + j], scale_s, scale_t)
