"""The outer loops of tracking: ranges of rows, each row solved on its own."""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import locate
from contiga.num.codes import CUT, FACE, GENERAL, NOT_FINITE, OK, OUT, RATIONAL_CUBIC
from contiga.num.jit import inner, kernel
from contiga.num.kernels.query_nb import blank_foot
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

BY_ROW, GO_ON = 1, 2
"""Flags of rows that the lanes did not finish: to be done one by one, or gone on with."""


@inner()
def _finite(points, k):
    return math.isfinite(points[k, 0] + points[k, 1] + points[k, 2])


@kernel()
def project_tracked(tables, points, starts, rows, out, start, stop):
    """Continued feet of points[rows[start:stop]] from starts = (patch, uv), one by one."""
    h = np.empty((4, 6))
    found = np.empty(4)
    patch, uv = starts
    for i in range(start, stop):
        k = rows[i]
        if not _finite(points, k):
            blank_foot(out, k, NOT_FINITE)
            continue
        point = (points[k, 0], points[k, 1], points[k, 2])
        foot = locate(tables.grid, patch[k], uv[k, 0], uv[k, 1])
        tracked_foot(tables, k, foot, point, out, found, h)


@inner()
def _first_places(counts):
    """Turn counts (elements,) into first places; returns where each element's bin starts."""
    n = counts.shape[0]
    start = np.empty(n + 1, np.int64)
    total = 0
    for e in range(n):
        start[e] = total
        here = counts[e]
        counts[e] = total
        total += here
    start[n] = total
    return start


@inner()
def _blocks_of(start):
    """Blocks of at most LANES rows of one element: (n, 3) element, first, one past the last."""
    count = start.shape[0] - 1
    n = 0
    for e in range(count):
        n += (start[e + 1] - start[e] + LANES - 1) // LANES
    blocks = np.empty((n, 3), np.int64)
    b = 0
    for e in range(count):
        for first in range(start[e], start[e + 1], LANES):
            blocks[b, 0] = e
            blocks[b, 1] = first
            blocks[b, 2] = min(first + LANES, start[e + 1])
            b += 1
    return blocks


@kernel()
def bin_rows(grid, feet, back, wanted, size, start, stop):
    """Rows start … stop with a foot and the flag `wanted`, ordered by element, and their blocks.

    `feet` is (patch, uv), `size` the number of elements.
    """
    patch, uv = feet
    element = np.empty(stop - start, np.int32)
    places = np.zeros(size, np.int64)
    for k in range(start, stop):
        e = np.int32(-1)
        if back[k] == wanted and patch[k] >= 0:
            e = np.int32(locate(grid, patch[k], uv[k, 0], uv[k, 1])[0])
            places[e] += 1
        element[k - start] = e
    first = _first_places(places)
    order = np.empty(first[-1], np.int32)
    for k in range(start, stop):
        e = element[k - start]
        if e >= 0:
            order[places[e]] = k
            places[e] += 1
    return order, _blocks_of(first)


@inner()
def _load(elements, e, rows, points, uv, results, lanes):
    """Fill the lanes of a block; lanes beyond its rows repeat the last one, already done.

    A row that is gone on with has its squared distance so far in the place of its gap.
    """
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    scale_u = 1.0 / (elements.table[e]["box"][1] - u0)
    scale_v = 1.0 / (elements.table[e]["box"][3] - v0)
    n = rows.shape[0]
    for l in range(LANES):
        k = rows[min(l, n - 1)]
        lanes[l] = local_place(uv[k, 0], u0, scale_u)
        lanes[ROW_T * LANES + l] = local_place(uv[k, 1], v0, scale_v)
        for c in range(3):
            lanes[(ROW_X + c) * LANES + l] = points[k, c] - elements.table[e]["origin"][c]
        lanes[ROW_F * LANES + l] = results[0].gap[k] if results[1][k] == GO_ON else math.inf
        lanes[ROW_STATE * LANES + l] = ACTIVE if l < n else DONE


@inner()
def _active(lanes):
    n = 0
    for l in range(LANES):
        if lanes[ROW_STATE * LANES + l] == ACTIVE:
            n += 1
    return n


@kernel()
def project_lanes(tables, path, starts, bins, results, start, stop):
    """Fast tracking of the binned rows of blocks start … stop, with their quick certificates.

    `path` is (points before, points now), the first without rows where nothing is to be certified;
    `starts` (parameters from which feet are looked for, those of the last feet); `bins` is (order,
    blocks), `results` (projection, flags). A row is flagged, to be done one by
    one, when it does not descend, or its element is trimmed away at the foot or of too high a
    degree; and to be gone on with from the parameters then in `results` when it leaves its element
    for another of its patch.
    """
    order, blocks = bins
    elements = tables.elements
    tolerance = tables.scale[1] ** 2
    lanes, proof = np.empty(ROWS * LANES), np.zeros(PROOF_ROWS * LANES)
    k, frame = np.empty(64), np.empty(FRAME)
    proves = path[0].shape[0] > 0
    for b in range(start, stop):
        e = blocks[b, 0]
        rows = order[blocks[b, 1] : blocks[b, 2]]
        form = elements.table[e]["form"]
        if form == GENERAL or elements.table[e]["trim"] == OUT:
            for row in rows:
                results[1][row] = BY_ROW
            continue
        _load(elements, e, rows, path[1], starts[0], results, lanes)
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
                load_path(proof, l, rows[l], path, starts[1])
            load_surroundings(elements, tables.rings, e, lanes, rows.shape[0], proof, frame)
            prove_lanes(lanes, proof, frame, tables.scale[1])
        _store(tables, e, rows, (lanes, proof), results)


@inner(linked=False)
def _is_whole(tables, patch, uv, proof, l):
    """Whether nothing is trimmed away from the ball about the foot (u, v) of a lane."""
    r = proof[ROW_RADIUS * LANES + l]
    far_u = r / proof[ROW_WIDTH * LANES + l]
    return is_whole(tables, patch, uv, far_u, r / proof[(ROW_WIDTH + 1) * LANES + l])


@inner()
def _store(tables, e, rows, work, results):
    lanes, proof = work
    out, back = results
    elements = tables.elements
    u0 = elements.table[e]["box"][0]
    v0 = elements.table[e]["box"][2]
    du = elements.table[e]["box"][1] - u0
    dv = elements.table[e]["box"][3] - v0
    patch = elements.table[e]["patch"]
    cut = elements.table[e]["trim"] == CUT
    trimmed = tables.trims.trimmed[patch] != 0
    for l in range(rows.shape[0]):
        k = rows[l]
        s = lanes[l]
        t = lanes[ROW_T * LANES + l]
        state = lanes[ROW_STATE * LANES + l]
        if state == LEFT and back[k] != GO_ON and may_go_on(elements, e, s, t):
            back[k] = GO_ON
            out.patch[k] = patch
            out.uv[k, 0] = u0 + (s + 0.5) * du
            out.uv[k, 1] = v0 + (t + 0.5) * dv
            out.gap[k] = lanes[ROW_F * LANES + l]
            continue
        if state != DONE or (cut and not in_face(elements, tables.trims, e, s, t)):
            back[k] = BY_ROW
            continue
        back[k] = 0
        out.patch[k] = patch
        out.uv[k, 0] = u0 + (s + 0.5) * du
        out.uv[k, 1] = v0 + (t + 0.5) * dv
        for c in range(3):
            out.point[k, c] = lanes[(ROW_FOOT + c) * LANES + l] + elements.table[e]["origin"][c]
            out.normal[k, c] = lanes[(ROW_NORMAL + c) * LANES + l]
        out.gap[k] = lanes[ROW_GAP * LANES + l]
        out.feature[k] = FACE
        out.status[k] = OK
        proved = proof[ROW_RADIUS * LANES + l] > 0.0
        if proved and trimmed:
            proved = _is_whole(tables, patch, (out.uv[k, 0], out.uv[k, 1]), proof, l)
        out.certified[k] = 1 if proved else 0
