"""Crossings of a swept point: the segment p0 → p1 against the triangles of a mesh.

The line p + x d, d of length one, meets a triangle if it passes within rounding of it as seen along
d: with a and b the sides at its first corner A and c = (a × b)·d, P = A + u a + v b with u = (p −
A)·(b × d)/c and v = (p − A)·(d × a)/c. A displacement of the line by ε changes u by ε |b × d|/|c|:
a crossing that far beyond an edge still counts, at any angle, and no path slips through between
triangles (Moeller & Trumbore 1997, doi 10.1080/10867651.1997.10487468, with lengths for
tolerances).
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import AT_START, EITHER, ENTRIES, OK
from contiga.arrays.kernels.query_nb import begin_path
from contiga.arrays.path_records import Segment
from contiga.jit import inner, kernel
from contiga.triangles.facet_records import Queue
from contiga.triangles.kernels.boxes_nb import NO_CHILD, WIDTH, insert_sorted
from contiga.triangles.kernels.facet_nb import TRIANGLE

MAX_PENDING = 256
"""Largest number of pending nodes."""
PARALLEL = 1e-15
"""Sine of the angle to a triangle's plane below which a path can cross it only at an edge."""
X, SLOT, U, V, X_TOL, EDGE_DISTANCE = 0, 1, 2, 3, 4, 5
"""Columns of a crossing: x, triangle, u, v, uncertainty of x, distance inside its edges."""


@inner()
def _box_entries(box, node, p, inverse, limits, slack, out):
    """Write the x at which the path enters each box of a node, widened by `slack`, to out[WIDTH].

    It is infinite for a box that the path misses between the `limits` (first, last) of x.
    """
    first, last = limits
    for l in range(WIDTH):
        a = (box[node, l] - slack - p[0]) * inverse[0]
        b = (box[node, 24 + l] + slack - p[0]) * inverse[0]
        x_min = max(first, min(a, b))
        x_max = min(last, max(a, b))
        a = (box[node, 8 + l] - slack - p[1]) * inverse[1]
        b = (box[node, 32 + l] + slack - p[1]) * inverse[1]
        x_min = max(x_min, min(a, b))
        x_max = min(x_max, max(a, b))
        a = (box[node, 16 + l] - slack - p[2]) * inverse[2]
        b = (box[node, 40 + l] + slack - p[2]) * inverse[2]
        x_min = max(x_min, min(a, b))
        x_max = min(x_max, max(a, b))
        out[l] = x_min if x_min <= x_max + 1e-12 * abs(x_max) else math.inf


@inner(error_model="numpy")
def _crossing(shape, s, segment, sense):
    """Return where the line p + x d passes through triangle s.

    Returns x (infinite for none), (u, v), the least distance from the edges as seen along the line
    (positive inside), and the slope n·d. A crossing may be `slack` outside the edges, and a
    rounding beyond the ends of the segment. With the sense ENTRIES only lines against the normal
    cross.
    """
    p, d, slack = segment.p, segment.d, segment.slack
    n0, n1, n2 = shape[s, 9], shape[s, 10], shape[s, 11]
    slope = d[0] * n0 + d[1] * n1 + d[2] * n2
    if (slope >= 0.0 and sense == ENTRIES) or abs(slope) <= PARALLEL:
        return math.inf, (0.0, 0.0), 0.0, slope
    r0 = p[0] - shape[s, 0]
    r1 = p[1] - shape[s, 1]
    r2 = p[2] - shape[s, 2]
    x = -(r0 * n0 + r1 * n1 + r2 * n2) / slope
    x_tol = min(slack / abs(slope), segment.spare)
    if x < -x_tol or x > segment.length + x_tol:
        return math.inf, (0.0, 0.0), 0.0, slope
    a0 = shape[s, 12] - shape[s, 0]
    a1 = shape[s, 13] - shape[s, 1]
    a2 = shape[s, 14] - shape[s, 2]
    b0 = shape[s, 15] - shape[s, 0]
    b1 = shape[s, 16] - shape[s, 1]
    b2 = shape[s, 17] - shape[s, 2]
    q0 = b1 * d[2] - b2 * d[1]
    q1 = b2 * d[0] - b0 * d[2]
    q2 = b0 * d[1] - b1 * d[0]
    o0 = d[1] * a2 - d[2] * a1
    o1 = d[2] * a0 - d[0] * a2
    o2 = d[0] * a1 - d[1] * a0
    c = a0 * q0 + a1 * q1 + a2 * q2
    if c == 0.0:
        return math.inf, (0.0, 0.0), 0.0, slope
    u = (r0 * q0 + r1 * q1 + r2 * q2) / c
    v = (r0 * o0 + r1 * o1 + r2 * o2) / c
    w0 = q0 + o0
    w1 = q1 + o1
    w2 = q2 + o2
    # The distance from the line to the three edges, positive inside.
    edge_distance = min(
        u * abs(c) / math.sqrt(q0 * q0 + q1 * q1 + q2 * q2),
        v * abs(c) / math.sqrt(o0 * o0 + o1 * o1 + o2 * o2),
        (1.0 - u - v) * abs(c) / math.sqrt(w0 * w0 + w1 * w1 + w2 * w2),
    )
    return (x if edge_distance >= -slack else math.inf), (u, v), edge_distance, slope


@inner(error_model="numpy")
def _search(facets, segment, sense, crossings, queue):
    """Write the first entry of a `Segment` to crossings[0], its first exit to crossings[1].

    An exit is searched if `sense` is EITHER, up to `spare` beyond the first crossing. The x is
    infinite for none; of triangles at the same x the one with the lowest number counts.
    """
    shape, link, box, child = facets.shape, facets.link, facets.box, facets.child
    nodes, entry, lane = queue.nodes, queue.bounds, queue.lane
    p, d, slack, spare = segment.p, segment.d, segment.slack, segment.spare
    crossings[0, X] = math.inf
    crossings[1, X] = math.inf
    # A path along an axis has no finite inverse; a huge one gives the same boxes.
    inverse = (
        1.0 / d[0] if abs(d[0]) > 1e-290 else 1e290,
        1.0 / d[1] if abs(d[1]) > 1e-290 else 1e290,
        1.0 / d[2] if abs(d[2]) > 1e-290 else 1e290,
    )
    max_x = segment.length + spare
    beyond = spare if sense == EITHER else 0.0
    nodes[0] = 0
    entry[0] = -spare
    top = 1
    while top > 0:
        top -= 1
        if entry[top] > max_x:
            continue
        node = nodes[top]
        _box_entries(box, node, p, inverse, (-spare, max_x), slack, lane)
        if child[node, 0] >= 0:
            base = top
            for l in range(WIDTH):
                if lane[l] < math.inf and child[node, l] != NO_CHILD:
                    top = insert_sorted(nodes, entry, base, top, child[node, l], lane[l])
            continue
        for l in range(WIDTH):
            if lane[l] > max_x or child[node, l] == NO_CHILD:
                continue
            s = -1 - child[node, l]
            x, place, edge_distance, slope = _crossing(shape, s, segment, sense)
            if x == math.inf:
                continue
            side = 0 if slope < 0.0 else 1
            first_crossing = crossings[side]
            if x < first_crossing[X] or (
                x == first_crossing[X]
                and link[s, TRIANGLE] < link[int(first_crossing[SLOT]), TRIANGLE]
            ):
                first_crossing[X], first_crossing[SLOT] = x, s
                first_crossing[U], first_crossing[V] = place
                first_crossing[EDGE_DISTANCE] = edge_distance
                first_crossing[X_TOL] = min(slack / abs(slope), spare)
                max_x = min(max_x, x + beyond)


@inner()
def _write(facets, out, i, crossing, length):
    """Write a crossing to row i of `out` (`Hit`), except its status; fraction, u, v are clipped."""
    shape = facets.shape
    s = int(crossing[SLOT])
    u = min(max(crossing[U], 0.0), 1.0)
    v = min(max(crossing[V], 0.0), 1.0 - u)
    out.fraction[i] = min(max(crossing[X] / length, 0.0), 1.0)
    out.patch[i] = facets.link[s, TRIANGLE]
    out.uv[i, 0] = u
    out.uv[i, 1] = v
    for c in range(3):
        b = u * (shape[s, 12 + c] - shape[s, c])
        out.point[i, c] = shape[s, c] + b + v * (shape[s, 15 + c] - shape[s, c])


@inner()
def _queue():
    """Allocate the queue of a search."""
    return Queue(np.empty(MAX_PENDING, np.int64), np.empty(MAX_PENDING), np.empty(WIDTH))


@kernel(error_model="numpy")
def first_hits(facets, p0, p1, rows, out, start, stop):
    """Write the first entry of each segment p0[rows[i]] → p1[rows[i]] to row i of `out`.

    The status is OK, AT_START for an entry at the start of the path, NO_HIT without an entry, or
    NOT_FINITE for ends that are not finite.
    """
    crossings, queue = np.empty((2, 6)), _queue()
    size = facets.scale[0]
    for i in range(start, stop):
        k = rows[i]
        p = (p0[k, 0], p0[k, 1], p0[k, 2])
        q = (p1[k, 0], p1[k, 1], p1[k, 2])
        length, d, slack = begin_path(out, i, p, q, size)
        if length == 0.0:
            continue
        segment = Segment(p, d, length, slack, math.sqrt(slack * size))
        _search(facets, segment, ENTRIES, crossings, queue)
        if crossings[0, X] < math.inf:
            _write(facets, out, i, crossings[0], length)
            out.status[i] = AT_START if crossings[0, X] <= 0.0 else OK


@kernel(error_model="numpy")
def last_crossings(facets, p0, p1, out, verdict, start, stop):
    """Write the crossing nearest the end of each segment p0[i] → p1[i] to row i of `out`.

    Writes to `verdict` (n, 2) the sense (1 entry, −1 exit, 0 none), and the width, a length, within
    which rounding decides: zero unless the crossing is at an edge, or an entry and an exit are in
    one place. Statuses are those of `first_hits`, AT_START for a crossing at p0.
    """
    crossings, queue = np.empty((2, 6)), _queue()
    size = facets.scale[0]
    for i in range(start, stop):
        # The search goes backwards: what it finds as an entry is an exit.
        p = (p1[i, 0], p1[i, 1], p1[i, 2])
        q = (p0[i, 0], p0[i, 1], p0[i, 2])
        verdict[i] = 0.0
        length, d, slack = begin_path(out, i, p, q, size)
        if length == 0.0:
            continue
        segment = Segment(p, d, length, slack, math.sqrt(slack * size))
        _search(facets, segment, EITHER, crossings, queue)
        side = 0 if crossings[0, X] <= crossings[1, X] else 1
        if crossings[side, X] < math.inf:
            _write(facets, out, i, crossings[side], length)
            out.fraction[i] = 1.0 - out.fraction[i]
            out.status[i] = AT_START if crossings[side, X] >= length else OK
            verdict[i, 0] = 2.0 * side - 1.0
            last, opposite = crossings[side], crossings[1 - side]
            is_paired = opposite[X] - opposite[X_TOL] <= last[X] + last[X_TOL]
            if is_paired or last[EDGE_DISTANCE] <= 2.0 * slack:
                verdict[i, 1] = 2.0 * slack
