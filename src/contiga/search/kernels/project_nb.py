"""The outer loops of tracking: each row is solved on its own, in lanes or one by one."""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import locate
from contiga.num.codes import CUT, GENERAL, NOT_FINITE, OUT, RATIONAL_CUBIC
from contiga.num.jit import inner, kernel
from contiga.num.kernels.query_nb import blank_foot
from contiga.num.scratch import scratch
from contiga.search.kernels.bins_nb import (
    BEFORE,
    BY_ROW,
    FLAG,
    FOOT,
    GAP,
    NORMAL,
    NOW,
    PATCH,
    PLACE,
    PROVED,
    START,
    bin_rows,
    fetch_rows,
    hand_rows,
)
from contiga.search.kernels.branch_nb import is_whole, kept_ball, seen_from
from contiga.search.kernels.face_nb import in_face
from contiga.search.kernels.foot_nb import tracked_foot
from contiga.search.kernels.lane_proof_nb import (
    FRAME,
    PROOF_ROWS,
    ROW_RADIUS,
    ROW_WIDTH,
    load_path,
    load_surroundings,
    prove_lanes,
)
from contiga.search.kernels.lanes_nb import (
    LANES,
    ROW_F,
    ROW_FOOT,
    ROW_GAP,
    ROW_NORMAL,
    ROW_STATE,
    ROW_T,
    ROW_X,
    ROWS,
    finish_polynomial,
    finish_rational,
    newton_polynomial,
    newton_rational,
)
from contiga.search.kernels.newton_nb import ACTIVE, DONE, LEFT, ROUNDS, local_place
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
def _load(elements, e, handed, lanes):
    """Fill the lanes with what a block is handed; lanes beyond repeat its last row, done.

    Returns how many fours of lanes hold rows.
    """
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    scale_u = 1.0 / (elements.table[e]["box"][1] - u0)
    scale_v = 1.0 / (elements.table[e]["box"][3] - v0)
    n = handed.shape[0]
    fours = (n + 3) // 4
    for l in range(4 * fours):
        i = min(l, n - 1)
        lanes[l] = local_place(handed[i, START], u0, scale_u)
        lanes[ROW_T * LANES + l] = local_place(handed[i, START + 1], v0, scale_v)
        for c in range(3):
            lanes[(ROW_X + c) * LANES + l] = handed[i, NOW + c] - elements.table[e]["origin"][c]
        lanes[ROW_F * LANES + l] = math.inf
        lanes[ROW_STATE * LANES + l] = ACTIVE if l < n else DONE
    return fours


@inner()
def _active(lanes, fours):
    n = 0
    for l in range(4 * fours):
        if lanes[ROW_STATE * LANES + l] == ACTIVE:
            n += 1
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
    point = (row[NOW], row[NOW + 1], row[NOW + 2])
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
        before = (row[BEFORE], row[BEFORE + 1], row[BEFORE + 2])
        seen = seen_from(at, normal, before, point, tables.scale[1])
        patches, start = (elements.table[e]["patch"], other), (row[START], row[START + 1])
        taken = (tables.grid, elements.table, tables.rings)
        if kept_ball(tables, taken, patches, uv, start, seen) > 0.0:
            found[PROVED] = 1.0


@inner(linked=False)
def _is_whole(tables, patch, uv, proof, l):
    """Whether nothing is trimmed away from the ball about the foot (u, v) of a lane."""
    r = proof[ROW_RADIUS * LANES + l]
    far_u = r / proof[ROW_WIDTH * LANES + l]
    return is_whole(tables, patch, uv, far_u, r / proof[(ROW_WIDTH + 1) * LANES + l])


@inner()
def _store(tables, proves, e, handed, work, found):
    """What the lanes found of a block, into `found`; `work` is (lanes, proof)."""
    lanes, proof = work
    elements = tables.elements
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    du = elements.table[e]["box"][1] - u0
    dv = elements.table[e]["box"][3] - v0
    patch = elements.table[e]["patch"]
    cut = elements.table[e]["trim"] == CUT
    trimmed = tables.trims.trimmed[patch] != 0
    for l in range(found.shape[0]):
        s = lanes[l]
        t = lanes[ROW_T * LANES + l]
        state = lanes[ROW_STATE * LANES + l]
        u = u0 + (s + 0.5) * du
        v = v0 + (t + 0.5) * dv
        found[l, PLACE] = u
        found[l, PLACE + 1] = v
        found[l, PATCH] = patch
        if state == LEFT:
            left = e, s, t, lanes[ROW_F * LANES + l]
            _go_on(tables, proves, left, handed[l], found[l])
            continue
        if state != DONE or (cut and not in_face(elements, tables.trims, e, s, t)):
            found[l, FLAG] = BY_ROW
            continue
        found[l, FLAG] = 0.0
        for c in range(3):
            found[l, FOOT + c] = lanes[(ROW_FOOT + c) * LANES + l] + elements.table[e]["origin"][c]
            found[l, NORMAL + c] = lanes[(ROW_NORMAL + c) * LANES + l]
        found[l, GAP] = lanes[ROW_GAP * LANES + l]
        proved = proof[ROW_RADIUS * LANES + l] > 0.0
        if proved and trimmed:
            proved = _is_whole(tables, patch, (u, v), proof, l)
        found[l, PROVED] = 1.0 if proved else 0.0


@inner(linked=False)
def _project_blocks(tables, proves, handed, blocks, found):
    """Feet of the rows of all blocks, with their quick certificates.

    A row is flagged, to be done one by one, when it does not descend, or its element is trimmed
    away at the foot or of too high a degree, or left over other than smooth sides.
    """
    elements = tables.elements
    tolerance = tables.scale[1] ** 2
    lanes, proof = np.empty(ROWS * LANES), np.zeros(PROOF_ROWS * LANES)
    k, frame = scratch(64), scratch(FRAME)
    for b in range(blocks.shape[0]):
        e = blocks[b, 0]
        rows = handed[blocks[b, 1] : blocks[b, 2]]
        answers = found[blocks[b, 1] : blocks[b, 2]]
        form = elements.table[e]["form"]
        if form == GENERAL or elements.table[e]["trim"] == OUT:
            answers[:, FLAG] = BY_ROW
            continue
        fours = _load(elements, e, rows, lanes)
        for i in range(64):
            k[i] = elements.table[e]["cubic"][i]
        for _ in range(ROUNDS):
            if form == RATIONAL_CUBIC:
                newton_rational(lanes, fours, k, tolerance)
            else:
                newton_polynomial(lanes, fours, k, tolerance)
            if _active(lanes, fours) == 0:
                break
        if form == RATIONAL_CUBIC:
            finish_rational(lanes, fours, k, tolerance)
        else:
            finish_polynomial(lanes, fours, k, tolerance)
        if proves:
            for l in range(rows.shape[0]):
                load_path(proof, l, rows[l])
            load_surroundings(elements, tables.rings, e, lanes, rows.shape[0], proof, frame)
            prove_lanes(lanes, fours, proof, frame, tables.scale[1])
        _store(tables, proves, e, rows, (lanes, proof), answers)


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
