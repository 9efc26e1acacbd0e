"""The quick certificate (`branch_nb`) of many feet of one element at once, as Newton's method has
left them in its lanes (`lanes_nb`).

By the bounds kept around each foot, and for a start in the surroundings of the same patch: nearly
all feet of small steps. Ways over a pole or a joint are left to be tried one by one.
"""

from __future__ import annotations

import math

from contiga.num.jit import inner
from contiga.search.kernels.bins_nb import BEFORE, NOW, START
from contiga.search.kernels.branch_nb import ball_radius, seen_from
from contiga.search.kernels.lanes_nb import LANES, ROW_FOOT, ROW_NORMAL, ROW_STATE, ROW_T
from contiga.search.kernels.newton_nb import DONE
from contiga.search.kernels.part_nb import part_of

# Rows of the work array, each LANES long: the point before and now, in the body's axes, the start,
# what is kept around the foot, and what is found.
ROW_BEFORE, ROW_NOW, ROW_START = 0, 3, 6
ROW_CURVATURE, ROW_ROOM, ROW_SPEED, ROW_WIDTH, ROW_BLOCK, ROW_ENDS = 8, 10, 11, 13, 15, 19
ROW_RADIUS = 23
PROOF_ROWS = 24
FRAME = 9
"""Of an element: u0, v0, its length in u and in v, u1, v1, origin (3)."""


@inner()
def load_path(proof, l, row):
    """The way of a row, and its start (u, v), into lane l, of what lanes are handed of it."""
    for c in range(3):
        proof[(ROW_BEFORE + c) * LANES + l] = row[BEFORE + c]
        proof[(ROW_NOW + c) * LANES + l] = row[NOW + c]
    for c in range(2):
        proof[(ROW_START + c) * LANES + l] = row[START + c]


@inner()
def load_surroundings(elements, rings, e, lanes, n, proof, frame):
    """What is kept around the feet of the first n lanes into the work arrays, and their element."""
    box = elements.table[e]["box"]
    frame[0], frame[1], frame[4], frame[5] = box[0], box[2], box[1], box[3]
    frame[2], frame[3] = box[1] - box[0], box[3] - box[2]
    for c in range(3):
        frame[6 + c] = elements.table[e]["origin"][c]
    for l in range(n):
        proof[ROW_ROOM * LANES + l] = -1.0
        if lanes[ROW_STATE * LANES + l] != DONE:
            continue
        ring = rings[e, part_of(lanes[l], lanes[ROW_T * LANES + l])]
        proof[ROW_ROOM * LANES + l] = ring["room"]
        for c in range(2):
            proof[(ROW_CURVATURE + c) * LANES + l] = ring["curvature"][c]
            proof[(ROW_SPEED + c) * LANES + l] = ring["speed"][c]
            proof[(ROW_WIDTH + c) * LANES + l] = ring["width"][c]
        for c in range(4):
            proof[(ROW_BLOCK + c) * LANES + l] = ring["block"][c]
            proof[(ROW_ENDS + c) * LANES + l] = ring["ends"][c]


@inner(linked=False)
def prove_lanes(lanes, fours, proof, frame, tolerance):
    """Radii of balls that prove the feet of so many fours of lanes, or 0.

    Trims are left to be looked at.
    """
    n = LANES
    for l in range(4 * fours):
        u = frame[0] + (lanes[l] + 0.5) * frame[2]
        v = frame[1] + (lanes[ROW_T * n + l] + 0.5) * frame[3]
        foot = (
            lanes[ROW_FOOT * n + l] + frame[6],
            lanes[(ROW_FOOT + 1) * n + l] + frame[7],
            lanes[(ROW_FOOT + 2) * n + l] + frame[8],
        )
        normal = (
            lanes[ROW_NORMAL * n + l],
            lanes[(ROW_NORMAL + 1) * n + l],
            lanes[(ROW_NORMAL + 2) * n + l],
        )
        a = (proof[l], proof[n + l], proof[2 * n + l])
        b = (
            proof[ROW_NOW * n + l],
            proof[(ROW_NOW + 1) * n + l],
            proof[(ROW_NOW + 2) * n + l],
        )
        seen = seen_from(foot, normal, a, b, tolerance)
        u0, v0 = proof[ROW_START * n + l], proof[(ROW_START + 1) * n + l]
        around = (
            (proof[ROW_BLOCK * n + l] <= u0)
            & (u0 <= proof[(ROW_BLOCK + 1) * n + l])
            & (proof[(ROW_BLOCK + 2) * n + l] <= v0)
            & (v0 <= proof[(ROW_BLOCK + 3) * n + l])
        )
        way = abs(u0 - u) * proof[ROW_SPEED * n + l] + abs(v0 - v) * proof[(ROW_SPEED + 1) * n + l]
        way = way if around else math.inf
        width_u, width_v = proof[ROW_WIDTH * n + l], proof[(ROW_WIDTH + 1) * n + l]
        off_0, off_1 = (u - frame[0]) * width_u, (frame[4] - u) * width_u
        off_2, off_3 = (v - frame[1]) * width_v, (frame[5] - v) * width_v
        off_0 = off_0 if proof[ROW_ENDS * n + l] > 0.0 else math.inf
        off_1 = off_1 if proof[(ROW_ENDS + 1) * n + l] > 0.0 else math.inf
        off_2 = off_2 if proof[(ROW_ENDS + 2) * n + l] > 0.0 else math.inf
        off_3 = off_3 if proof[(ROW_ENDS + 3) * n + l] > 0.0 else math.inf
        margin = min(min(off_0, off_1), min(off_2, off_3))
        curvature = (proof[ROW_CURVATURE * n + l], proof[(ROW_CURVATURE + 1) * n + l])
        room = proof[ROW_ROOM * n + l]
        proof[ROW_RADIUS * n + l] = ball_radius(curvature, room, margin, way, seen, tolerance)
