"""Neighbourhoods of parts next to narrow elements: complete rows and columns of parts.

Cutting a surface leaves slivers, and a quarter of a sliver (`neighbourhood_nb`) is far too narrow.
Here rows and columns of parts are added around one, from element to element, until they are about
as deep in each direction as parts nearby are wide. They form a rectangle: the part where a row and
a column cross is the same whichever is followed first, and all sides within are smooth. Parameters
along a side continue from part to part; so a path that leaves the rectangle on the left has crossed
every column there, from side to side, within parts of the rectangle, and is at least as long as the
sum of the least widths of these columns.
"""

from __future__ import annotations

from contiga.arrays.codes import IN, SMOOTH
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import INNER, WIDTH_S
from contiga.search.certify.kernels.part_nb import N_PARTS, add_metric, scales

MAX_PARTS = 12
"""Largest number of parts that are added in one direction."""
N_COLUMNS = 2 * MAX_PARTS + 1
"""Largest number of columns, or of rows, with the part itself."""
MIN_DEPTH = 0.75
"""Least depth of a neighbourhood, in widths of parts nearby."""
MAX_DEPTH = 2.0
"""Depth of a neighbourhood that hardly bends, in widths of parts nearby."""
MAX_BEND_RATIO = 2.0
"""Largest ratio of the turns of a wider neighbourhood and of the first one."""
MAX_TURN = 0.1
"""Turn of a neighbourhood, rad, below which that ratio does not count."""
LEFT, RIGHT, DOWN, UP = 0, 1, 2, 3
"""Directions of falling and growing s and t in the first element."""


@inner(error_model="numpy")
def _next_part(table, cell, direction):
    """Return the next part in a direction; of element −1 if no smooth side leads there.

    A part is (element, i, j, whether its s runs along the t of the first element, and whether the
    directions s and t of the first element run backwards in it).
    """
    e, i, j, swap, back_s, back_t = cell
    axis, on = direction >> 1, direction & 1
    own_axis = axis ^ swap
    on = on ^ (back_s if axis == 0 else back_t)
    k = (i if own_axis == 0 else j) + 2 * on - 1
    if 0 <= k < N_PARTS:
        return e, (k if own_axis == 0 else i), (j if own_axis == 0 else k), swap, back_s, back_t
    side = 2 * own_axis + on
    if table[e]["kind"][side] != SMOOTH:
        return -1, 0, 0, 0, 0, 0
    side_there, flip = table[e]["neighbour_side"][side], table[e]["flip"][side]
    k = 0 if side_there & 1 == 0 else N_PARTS - 1
    along = j if own_axis == 0 else i
    if flip == 1:
        along = N_PARTS - 1 - along
    reverses = (direction & 1) ^ (1 - (side_there & 1))
    back_s, back_t = (reverses, back_t ^ flip) if axis == 0 else (back_s ^ flip, reverses)
    i, j = (k, along) if side_there < 2 else (along, k)
    return table[e]["neighbour"][side], i, j, (side_there >> 1) ^ axis, back_s, back_t


@inner(error_model="numpy")
def _walk(table, cell, direction, count):
    """Return the part `count` parts away in a direction; of element −1 beyond a side not smooth."""
    for _ in range(count):
        if cell[0] >= 0:
            cell = _next_part(table, cell, direction)
    return cell


@inner(error_model="numpy")
def _width(raw, cell, axis):
    """Return the least width of a part along an axis of the first element."""
    return raw[cell[0], cell[1] * N_PARTS + cell[2], WIDTH_S + (axis ^ cell[3])] / N_PARTS


@inner(error_model="numpy")
def _part_at(table, home, a, b):
    """Return the part a columns to the right of a part and b rows up.

    Its element is −1 if there is none, or if it depends on whether the row or the column is
    followed first.
    """
    across, along = (RIGHT if a >= 0 else LEFT), (UP if b >= 0 else DOWN)
    cell = _walk(table, _walk(table, home, across, abs(a)), along, abs(b))
    other = _walk(table, _walk(table, home, along, abs(b)), across, abs(a))
    if cell != other:
        return -1, 0, 0, 0, 0, 0
    return cell


@inner(error_model="numpy")
def _survey(table, raw, home, extents, work):
    """Write the least widths of the columns and rows around a part, and their largest curvatures.

    They go to `work` = ((2, 2 MAX_PARTS + 1), (2,)). Returns whether the parts form a rectangle,
    and are all untrimmed or all on the patch of the part `home`; without a rectangle `work` is
    incomplete.
    """
    widths, max_curvature = work
    widths[:] = 1e300
    max_curvature[:] = 0.0
    patch = table[home[0]]["patch"]
    is_same_patch = is_untrimmed = True
    for a in range(-extents[LEFT], extents[RIGHT] + 1):
        for b in range(-extents[DOWN], extents[UP] + 1):
            cell = _part_at(table, home, a, b)
            if cell[0] < 0:
                return False
            widths[0, MAX_PARTS + a] = min(widths[0, MAX_PARTS + a], _width(raw, cell, 0))
            widths[1, MAX_PARTS + b] = min(widths[1, MAX_PARTS + b], _width(raw, cell, 1))
            for c in range(2):
                max_curvature[c] = max(
                    max_curvature[c], raw[cell[0], cell[1] * N_PARTS + cell[2], INNER + c]
                )
            is_same_patch = is_same_patch and table[cell[0]]["patch"] == patch
            is_untrimmed = is_untrimmed and table[cell[0]]["trim"] == IN
    return is_same_patch or is_untrimmed


@inner(error_model="numpy")
def _edge(table, cell, direction):
    """Return the parameter at which a part ends in a direction; the exact one at element sides."""
    axis, end = direction >> 1, direction & 1
    low, high = table[cell[0]]["box"][2 * axis], table[cell[0]]["box"][2 * axis + 1]
    k = cell[1 + axis] + end
    return low if k == 0 else (high if k == N_PARTS else low + k * (high - low) / N_PARTS)


@inner(error_model="numpy")
def widen(elements, raw, e, part, neighbourhood):
    """Replace the neighbourhood of a part (i, j) of element e by a wider one, if that is better.

    It is tried if the room is below `MIN_DEPTH` of the parts nearby, or up to `MAX_DEPTH` where the
    surface hardly bends. Better means more room, without turning by more than `MAX_BEND_RATIO`
    times as much, or than `MAX_TURN`. `raw` (elements, parts, 6) bounds every part by itself.
    Speeds and widths are in local parameters of e. Neighbourhoods with an end or a pole stay as
    they are.
    """
    table = elements.table
    home = (e, part[0], part[1], 0, 0, 0)
    ends = neighbourhood["ends"]
    if neighbourhood["pole"] >= 0 or ends[0] + ends[1] + ends[2] + ends[3] > 0:
        return
    # Width of the parts of this element and of adjoining ones, along the narrower axis.
    nearby_width = 1e300
    for axis in range(2):
        widest = _width(raw, home, axis)
        k = home[1 + axis]
        for end in range(2):
            cell = _walk(table, home, 2 * axis + end, k + 1 if end == 0 else N_PARTS - k)
            if cell[0] >= 0:
                widest = max(widest, _width(raw, cell, axis))
        nearby_width = min(nearby_width, widest)
    max_curvature = max(neighbourhood["curvature"][0], neighbourhood["curvature"][1])
    target_depth = max(
        MIN_DEPTH * nearby_width, min(MAX_DEPTH * nearby_width, MAX_TURN / max_curvature)
    )
    if not neighbourhood["room"] < target_depth:
        return
    extents, patch_extents = stack_int64(4), stack_int64(4)
    widths, curvatures = scratch(2, N_COLUMNS), scratch(2)
    for direction in range(4):
        depth, count, cell = 0.0, 0, _next_part(table, home, direction)
        while cell[0] >= 0 and count < MAX_PARTS and depth < target_depth:
            depth += _width(raw, cell, direction >> 1)
            count += 1
            cell = _next_part(table, cell, direction)
        extents[direction] = count
    if not _survey(table, raw, home, extents, (widths, curvatures)):
        return
    # A path that leaves crosses all columns or rows on one side.
    room = 1e300
    for direction in range(4):
        depth = 0.0
        for k in range(1, extents[direction] + 1):
            depth += widths[direction >> 1, MAX_PARTS + (k if direction & 1 == 1 else -k)]
        room = min(room, depth)
    turn = max(MAX_BEND_RATIO * max_curvature * room, MAX_TURN)
    if not (room > neighbourhood["room"] and max(curvatures[0], curvatures[1]) * room <= turn):
        return
    neighbourhood["room"] = room
    for c in range(2):
        neighbourhood["curvature"][c] = max(neighbourhood["curvature"][c], curvatures[c])
    # Parts with the parameters of the same patch, in the same directions, extend the block.
    for direction in range(4):
        cell, count = home, 0
        while count < extents[direction]:
            after = _next_part(table, cell, direction)
            is_same_patch = table[after[0]]["patch"] == table[e]["patch"]
            if after[3] | after[4] | after[5] != 0 or not is_same_patch:
                break
            if _edge(table, after, direction ^ 1) != _edge(table, cell, direction):
                break
            cell = after
            count += 1
        patch_extents[direction] = count
        neighbourhood["block"][direction] = _edge(table, cell, direction)
        k = home[1 + (direction >> 1)]
        beyond = extents[direction] - (k if direction & 1 == 0 else N_PARTS - 1 - k)
        neighbourhood["reach"][direction] = min(max(beyond, 0), N_PARTS)
    for a in range(-patch_extents[LEFT], patch_extents[RIGHT] + 1):
        for b in range(-patch_extents[DOWN], patch_extents[UP] + 1):
            n, i, j, _, _, _ = _part_at(table, home, a, b)
            scale_s, scale_t = scales(elements, e, n)
            add_metric(neighbourhood, raw[n, i * N_PARTS + j], scale_s, scale_t)
