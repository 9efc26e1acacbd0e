"""The outer loops of tracking: each row is solved on its own, in lanes or one by one."""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import locate
from contiga.num.codes import CUT, GENERAL, NOT_FINITE, OUT, RATIONAL_CUBIC
from contiga.num.jit import inner, kernel
from contiga.num.kernels.query_nb import blank_foot
from contiga.num.scratch import scratch
from contiga.search.kernels.bins_nb import bin_rows, fetch_rows, hand_rows
from contiga.search.kernels.branch_nb import is_whole, kept_ball, seen_from
from contiga.search.kernels.face_nb import in_face
from contiga.search.kernels.foot_nb import tracked_foot
from contiga.search.kernels.lane_proof_nb import WIDTH, load_surroundings, prove_lanes
from contiga.search.kernels.lanes_nb import (
    BY_ROW,
    FLAG,
    FOOT,
    GAP,
    NORMAL,
    PATCH,
    PLACE,
    PROVED,
    ROW_BEFORE,
    ROW_F,
    ROW_KEPT,
    ROW_NOW,
    ROW_RADIUS,
    ROW_S,
    ROW_START,
    ROW_STATE,
    ROW_T,
    TOLD,
    WIDE,
    finish_polynomial,
    finish_rational,
    load,
    new_lanes,
    newton_polynomial,
    newton_rational,
    start_lanes,
    tell,
    unload,
)
from contiga.search.kernels.newton_nb import ACTIVE, DONE, LEFT, ROUNDS
from contiga.search.kernels.one_foot_nb import (
    foot_in,
    parameters_of,
)
from contiga.search.kernels.onward_nb import onward


@inner()
def _finite(points, k):
    return math.isfinite(points[k, 0] + points[k, 1] + points[k, 2])


@kernel()
def project_tracked(tables, points, starts, rows, out, first):
    """Continued feet of points[rows] from starts[rows] = (patch, uv) into out[first + rows]."""
    h = scratch(4, 6)
    found = scratch(4)
    patch, uv = starts
    for i in rows:
        if not _finite(points, i):
            blank_foot(out, first + i, NOT_FINITE)
            continue
        point = (points[i, 0], points[i, 1], points[i, 2])
        foot = locate(tables.grid, patch[i], uv[i, 0], uv[i, 1])
        tracked_foot(tables, first + i, foot, point, out, found, h)


@inner()
def _lanes_in(state, lanes, banks):
    """How many lanes of so many banks are in a state."""
    n = 0
    for b in range(banks):
        bank = lanes[b]
        for l in range(WIDE):
            n += bank[ROW_STATE * WIDE + l] == state
    return n


@inner(linked=False)
def _go_on(tables, proves, left, row, found):
    """The foot of a row that has left its element, from where it is, with its quick certificate.

    `left` is (element, s, t, the square of the distance so far), `row` what the lanes were handed,
    `found` what they answer of it.
    """
    e, s, t, best = left
    elements = tables.elements
    found[FLAG] = BY_ROW
    other, place = onward(tables, e, s, t)
    if other < 0:
        return
    n = locate(tables.grid, other, place[0], place[1])[0]
    point = (row[ROW_NOW], row[ROW_NOW + 1], row[ROW_NOW + 2])
    (s, t), state, record = foot_in(tables, n, place, best, point)
    own = elements.table[n]
    if state != DONE or (own["trim"] == CUT and not in_face(elements, tables.trims, n, s, t)):
        return
    at, normal, gap = record
    uv = parameters_of(own["box"], (s, t))
    found[FLAG], found[PATCH], found[GAP] = 0.0, other, gap
    found[PLACE], found[PLACE + 1] = uv
    for c in range(3):
        found[FOOT + c], found[NORMAL + c] = at[c], normal[c]
    found[PROVED] = 0.0
    if proves:
        before = (row[ROW_BEFORE], row[ROW_BEFORE + 1], row[ROW_BEFORE + 2])
        seen = seen_from(at, normal, before, point, tables.scale[1])
        patches, start = (elements.table[e]["patch"], other), (row[ROW_START], row[ROW_START + 1])
        taken = (tables.grid, elements.table, tables.rings)
        if kept_ball(tables, taken, patches, uv, start, seen) > 0.0:
            found[PROVED] = 1.0


@inner(linked=False)
def _is_whole(tables, patch, uv, bank, l):
    """Whether nothing is trimmed away from the ball about the foot (u, v) of a lane."""
    r = bank[ROW_RADIUS * WIDE + l]
    far_u = r / bank[(ROW_KEPT + WIDTH) * WIDE + l]
    return is_whole(tables, patch, uv, far_u, r / bank[(ROW_KEPT + WIDTH + 1) * WIDE + l])


@inner(linked=False)
def _one_by_one(tables, proves, block, handed, lanes, found):
    """What is left to be seen to of a block that lanes have found: feet that have left its element,
    and trims."""
    elements = tables.elements
    e, first, last = block
    patch = elements.table[e]["patch"]
    cut = elements.table[e]["trim"] == CUT
    trimmed = tables.trims.trimmed[patch] != 0
    for i in range(first, last):
        bank, l = lanes[(i - first) // WIDE], (i - first) % WIDE
        s, t, state = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l], bank[ROW_STATE * WIDE + l]
        if state == LEFT:
            _go_on(tables, proves, (e, s, t, bank[ROW_F * WIDE + l]), handed[i], found[i])
        elif state == DONE and cut and not in_face(elements, tables.trims, e, s, t):
            found[i, FLAG] = BY_ROW
        elif trimmed and found[i, PROVED] != 0.0:
            uv = found[i, PLACE], found[i, PLACE + 1]
            found[i, PROVED] = 1.0 if _is_whole(tables, patch, uv, bank, l) else 0.0


@inner(linked=False)
def _project_blocks(tables, proves, handed, blocks, found):
    """Feet of the rows of all blocks, with their quick certificates.

    A row is flagged, to be done one by one, when it does not descend, or its element is trimmed
    away at the foot or of too high a degree, or left over other than smooth sides.
    """
    elements = tables.elements
    lanes, told = new_lanes(), scratch(TOLD)
    last = -1
    for b in range(blocks.shape[0]):
        e, first, end = blocks[b, 0], blocks[b, 1], blocks[b, 2]
        form, trim = elements.table[e]["form"], elements.table[e]["trim"]
        if form == GENERAL or trim == OUT:
            found[first:end, FLAG] = BY_ROW
            continue
        if e != last:
            tell(elements, e, tables.scale[1] ** 2, told)
            last = e
        banks = load(handed, first, end, lanes)
        start_lanes(lanes, end - first, told)
        for _ in range(ROUNDS):
            if form == RATIONAL_CUBIC:
                newton_rational(lanes, banks, told)
            else:
                newton_polynomial(lanes, banks, told)
            if _lanes_in(ACTIVE, lanes, banks) == 0:
                break
        if form == RATIONAL_CUBIC:
            finish_rational(lanes, banks, told)
        else:
            finish_polynomial(lanes, banks, told)
        if proves:
            load_surroundings(tables.rings, e, lanes, banks)
            prove_lanes(lanes, banks, told, tables.scale[1])
        unload(lanes, found, first, end)
        trimmed = tables.trims.trimmed[elements.table[e]["patch"]] != 0
        if trimmed or trim == CUT or _lanes_in(DONE, lanes, banks) < banks * WIDE:
            _one_by_one(tables, proves, (e, first, end), handed, lanes, found)


@kernel()
def track_lanes(tables, path, starts, room, results, first):
    """Fast tracking of rows in lanes, each in the element of its start.

    `path` is (points before, points now), the first without rows where nothing is to be certified;
    `starts` (patch, uv) are the last feet, `room` (handed, found) tables of as many rows or more to
    work in, `results` (projection, from its row `first` on; flags).
    """
    uv = starts[1]
    place, blocks = bin_rows(tables, starts)
    if blocks.shape[0] == 0:
        return
    handed, found = room
    hand_rows(place, path, uv, handed)
    _project_blocks(tables, path[0].shape[0] > 0, handed, blocks, found)
    fetch_rows(place, found, first, results)
