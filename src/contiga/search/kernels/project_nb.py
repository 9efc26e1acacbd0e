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
    BY_ROW,
    FLAG,
    FOOT,
    FOUND,
    FROM,
    GAP,
    GO_ON,
    HANDED,
    HANDED_ON,
    NORMAL,
    NOW,
    PLACE,
    PROVED,
    SO_FAR,
    START,
    bin_rows,
    fetch_rows,
    hand_on_rows,
    hand_rows,
)
from contiga.search.kernels.branch_nb import is_whole
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
from contiga.search.kernels.one_foot_nb import may_go_on


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
    """Fill the lanes with what a block is handed; lanes beyond repeat its last row, done."""
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    scale_u = 1.0 / (elements.table[e]["box"][1] - u0)
    scale_v = 1.0 / (elements.table[e]["box"][3] - v0)
    n = handed.shape[0]
    goes_on = handed.shape[1] > HANDED
    at = FROM if goes_on else START
    for l in range(LANES):
        i = min(l, n - 1)
        lanes[l] = local_place(handed[i, at], u0, scale_u)
        lanes[ROW_T * LANES + l] = local_place(handed[i, at + 1], v0, scale_v)
        for c in range(3):
            lanes[(ROW_X + c) * LANES + l] = handed[i, NOW + c] - elements.table[e]["origin"][c]
        lanes[ROW_F * LANES + l] = handed[i, SO_FAR] if goes_on else math.inf
        lanes[ROW_STATE * LANES + l] = ACTIVE if l < n else DONE


@inner()
def _active(lanes):
    n = 0
    for l in range(LANES):
        if lanes[ROW_STATE * LANES + l] == ACTIVE:
            n += 1
    return n


@inner(linked=False)
def _project_blocks(tables, proves, handed, blocks, found):
    """Feet of the rows of all blocks, with their quick certificates.

    A row is flagged, to be done one by one, when it does not descend, or its element is trimmed
    away at the foot or of too high a degree; and to be gone on with from the place found when it
    leaves its element for another of its patch.
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
        _load(elements, e, rows, lanes)
        for i in range(64):
            k[i] = elements.table[e]["cubic"][i]
        for _ in range(ROUNDS):
            if form == RATIONAL_CUBIC:
                newton_rational(lanes, k, tolerance)
            else:
                newton_polynomial(lanes, k, tolerance)
            if _active(lanes) == 0:
                break
        if form == RATIONAL_CUBIC:
            finish_rational(lanes, k, tolerance)
        else:
            finish_polynomial(lanes, k, tolerance)
        if proves:
            for l in range(rows.shape[0]):
                load_path(proof, l, rows[l])
            load_surroundings(elements, tables.rings, e, lanes, rows.shape[0], proof, frame)
            prove_lanes(lanes, proof, frame, tables.scale[1])
        _store(tables, e, rows, (lanes, proof), answers)


@kernel()
def track_lanes(tables, path, starts, wanted, results, first):
    """Fast tracking of the rows that have the flag `wanted`: 0 or GO_ON.

    `path` is (points before, points now), the first without rows where nothing is to be certified;
    `starts` (patch, uv) are the last feet, from which those with the flag 0 are looked for, others
    from where they are in `results` = (projection, from its row `first` on; flags).
    """
    patch, uv = starts
    out, back = results
    if wanted == GO_ON:
        last = first + patch.shape[0]
        feet = (out.patch[first:last], out.uv[first:last])
        place, blocks = bin_rows(tables, feet, back, wanted)
    else:
        place, blocks = bin_rows(tables, starts, back, wanted)
    if blocks.shape[0] == 0:
        return
    n = blocks[-1, 2]
    handed = np.empty((n, HANDED_ON if wanted == GO_ON else HANDED))
    hand_rows(place, path, uv, handed)
    if wanted == GO_ON:
        hand_on_rows(place, out, first, handed)
    found = np.empty((n, FOUND))
    _project_blocks(tables, path[0].shape[0] > 0, handed, blocks, found)
    # Rows that go on stay on their patch.
    fetch_rows(place, found, patch, first, results)


@inner(linked=False)
def _is_whole(tables, patch, uv, proof, l):
    """Whether nothing is trimmed away from the ball about the foot (u, v) of a lane."""
    r = proof[ROW_RADIUS * LANES + l]
    far_u = r / proof[ROW_WIDTH * LANES + l]
    return is_whole(tables, patch, uv, far_u, r / proof[(ROW_WIDTH + 1) * LANES + l])


@inner()
def _store(tables, e, handed, work, found):
    lanes, proof = work
    elements = tables.elements
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    du = elements.table[e]["box"][1] - u0
    dv = elements.table[e]["box"][3] - v0
    patch = elements.table[e]["patch"]
    cut = elements.table[e]["trim"] == CUT
    trimmed = tables.trims.trimmed[patch] != 0
    goes_on = handed.shape[1] > HANDED
    for l in range(handed.shape[0]):
        s = lanes[l]
        t = lanes[ROW_T * LANES + l]
        state = lanes[ROW_STATE * LANES + l]
        u = u0 + (s + 0.5) * du
        v = v0 + (t + 0.5) * dv
        found[l, PLACE] = u
        found[l, PLACE + 1] = v
        if state == LEFT and not goes_on and may_go_on(elements, e, s, t):
            found[l, FLAG] = GO_ON
            found[l, GAP] = lanes[ROW_F * LANES + l]
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
