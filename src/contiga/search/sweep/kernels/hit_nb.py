"""Crossings of swept points: the segments p0 → p1 against the exact surface.

The hierarchy is traversed along the path, nearest boxes first; a leaf is searched cell by cell
(`crossing_nb`). Lengths below `slack`, a few times the rounding of the coordinates, count as zero.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import AT_START, BUDGET, EITHER, ENTRIES, OK, OUT
from contiga.arrays.kernels.query_nb import begin_path
from contiga.arrays.path_records import Segment
from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.jit import inner, kernel
from contiga.search.closest.kernels.edge_width_nb import OUTSIDE, edge_width
from contiga.search.hierarchy.kernels.face_nb import has_pole
from contiga.search.hierarchy.kernels.plates_nb import is_passed
from contiga.search.sweep.kernels.crossing_nb import MAX_PENDING, next_crossing
from contiga.search.sweep.kernels.piece_lists_nb import is_clear
from contiga.search.sweep.sweep_records import CellWork, Ends, LeafPath, Queue

GRAZING = 32.0
"""Largest distance beyond an edge at which a path may cross the carrier of the face, in widths of
the edge."""
X, ELEMENT, S, T, EDGE, X_TOL = 0, 1, 2, 3, 4, 5
"""Columns of a crossing: x, element, s, t, width of an edge near it, uncertainty of x."""


@inner()
def meets_box(node, p, inverse, span, slack):
    """Return whether the path p + x d meets the box of a node widened by `slack`, and the least x.

    `span` is (x_min, x_max), the range of x; `inverse` is one over d, component by component
    (`reciprocal`). Paths that miss the box by rounding count as meeting it, and the x of others
    that miss it has no meaning.
    """
    x_min, x_max = span
    for c in range(3):
        low = node["low"][c] - slack - p[c]
        high = node["high"][c] + slack - p[c]
        if math.isinf(inverse[c]):
            if low > 0.0 or high < 0.0:
                return False, 0.0
        else:
            a = low * inverse[c]
            b = high * inverse[c]
            x_min = max(x_min, min(a, b))
            x_max = min(x_max, max(a, b))
    return x_min <= x_max * (1.0 + 1e-12) + 1e-300, x_min


@inner()
def reciprocal(x):
    """Return 1/x, or infinity if |x| is too small."""
    return 1.0 / x if abs(x) > 1e-290 else math.inf


@inner()
def next_leaves(tree, p, inverse, span, slack, queue, top):
    """Return the next node of leaves that the path meets within `span`, and the number pending.

    The node is −1 if there is none. In `queue` the inner nodes on the way are replaced by those
    children that the path meets, the nearer one on top.
    """
    nodes, entry = queue.nodes, queue.entry
    leaf_node = -1
    while top > 0 and leaf_node < 0:
        top -= 1
        if entry[top] > span[1]:
            continue
        node = nodes[top]
        if tree[node]["count"] > 0:
            leaf_node = node
            continue
        first = tree[node]["first"]
        meets_a, entry_a = meets_box(tree[first], p, inverse, span, slack)
        meets_b, entry_b = meets_box(tree[first + 1], p, inverse, span, slack)
        # The nearer child goes on top.
        order = 1 if meets_a and meets_b and entry_a <= entry_b else 0
        for i in range(2):
            child = i ^ order
            if (meets_a, meets_b)[child]:
                nodes[top] = first + child
                entry[top] = (entry_a, entry_b)[child]
                top += 1
    return leaf_node, top


@inner()
def _room_beside(elements, e, side, slack):
    """Return the largest distance beyond a side at which a crossing belongs to the element, length.

    Beyond a smooth joint a crossing belongs to the neighbour, unless all of the neighbour is
    trimmed away. Distances up to `slack` are zero.
    """
    row = elements.table[e]
    across = row["neighbour"][side]
    in_patch = across >= 0 and elements.table[across]["patch"] == row["patch"]
    cut_off = in_patch and elements.table[across]["trim"] == OUT
    room = row["edge_tolerance"] if cut_off else row["width"][side]
    return room if room > slack else 0.0


@inner(error_model="numpy")
def _place_on_element(elements, e, place, path, x, h):
    """Return the place (s, t) of an element that stands for a crossing at `place`, and x there.

    A crossing that is outside the element by rounding, as seen along the path, is far outside if
    the element is flat along the path: it is moved to where the side is nearest to the path. `h`
    holds the derivatives at the crossing, and those at the new place afterwards.
    """
    if abs(place[0]) <= 0.5 and abs(place[1]) <= 0.5:
        return place, x
    p, d = path.p, path.d
    aa = ab = bb = da = db = 0.0
    for c in range(3):
        da += d[c] * h[c, 1]
        db += d[c] * h[c, 2]
    for c in range(3):
        s = h[c, 1] - da * d[c]
        t = h[c, 2] - db * d[c]
        aa += s * s
        ab += s * t
        bb += t * t
    s = min(max(place[0], -0.5), 0.5)
    t = min(max(place[1], -0.5), 0.5)
    # Move along the side to where, seen along the path, the step onto it is shortest.
    if s != place[0] and t == place[1] and bb > 0.0:
        t = min(max(t - (s - place[0]) * ab / bb, -0.5), 0.5)
    elif t != place[1] and s == place[0] and aa > 0.0:
        s = min(max(s - (t - place[1]) * ab / aa, -0.5), 0.5)
    evaluate(elements, e, s, t, h)
    x = (h[0, 0] - p[0]) * d[0] + (h[1, 0] - p[1]) * d[1] + (h[2, 0] - p[2]) * d[2]
    return (s, t), x


@inner()
def keep_first(crossings, e, place, x, slope, x_tol, width):
    """Store a crossing of element e in `crossings` if it is before the entry, or exit, so far.

    The entry is row 0, the exit row 1; `slope` is negative for an entry. `place` (s, t) is clipped
    to the element. `x_tol` is the uncertainty of x, `width` the width of an edge near the crossing.
    """
    side = 0 if slope < 0.0 else 1
    if x < crossings[side, X]:
        crossings[side, X] = x
        crossings[side, ELEMENT] = e
        crossings[side, S] = min(max(place[0], -0.5), 0.5)
        crossings[side, T] = min(max(place[1], -0.5), 0.5)
        crossings[side, EDGE] = width
        crossings[side, X_TOL] = x_tol


@inner(linked=False)
def _search(tables, segment, loose, sense, crossings, queue, work):
    """Write the first entry of a `Segment` to crossings[0], its first exit to crossings[1].

    x is infinite for none; exits are searched if `sense` is EITHER, up to `spare` beyond the first
    crossing. `loose` (2,) is the largest distance beyond either end of a crossing at an edge, in
    widths of that edge; `queue` is a `Queue`, `work` is `CellWork`, whose counts[1] is 1 afterwards
    if cells were given up, else 0.
    """
    tree, leaves, elements = tables.tree, tables.leaves, tables.elements
    trims, piece_width = tables.trims, tables.piece_width
    stack, h, count = work.stack, work.h, work.counts
    p, d, length = segment.p, segment.d, segment.length
    slack, spare = segment.slack, segment.spare
    inverse = (reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2]))
    crossings[0, X] = math.inf
    crossings[1, X] = math.inf
    count[0] = 0
    count[1] = 0
    max_x = length + spare
    beyond = spare if sense == EITHER else 0.0
    queue.nodes[0] = 0
    queue.entry[0] = -spare
    top = 1 if meets_box(tree[0], p, inverse, (-spare, max_x), slack)[0] else 0
    while top > 0:
        node, top = next_leaves(tree, p, inverse, (-spare, max_x), slack, queue, top)
        if node < 0:
            break
        for i in range(tree[node]["first"], tree[node]["first"] + tree[node]["count"]):
            leaf = leaves[i]
            e = leaf["element"]
            if e < 0:
                continue
            # Skip leaves that the path meets neither inside their edges nor within their width.
            plate, row = tables.plates[i], elements.table[e]
            reach = max(spare, GRAZING * plate["edge_tolerance"])
            span = (-reach, min(max_x + reach, length + reach))
            if is_passed(plate, p, d, span, slack + plate["edge_tolerance"]):
                continue
            origin, leaf_slack = row["origin"], slack + row["noise"]
            local = (p[0] - origin[0], p[1] - origin[1], p[2] - origin[2])
            path = LeafPath(local, d, leaf_slack, 0.0, (0.0, 0.0, 0.0, 0.0))
            if row["edge_tolerance"] > leaf_slack:
                room = (
                    _room_beside(elements, e, 0, leaf_slack),
                    _room_beside(elements, e, 1, leaf_slack),
                    _room_beside(elements, e, 2, leaf_slack),
                    _room_beside(elements, e, 3, leaf_slack),
                )
                path = LeafPath(local, d, leaf_slack, row["edge_tolerance"], room)
            is_thin_s = leaf["bound"][0] * (leaf["box"][1] - leaf["box"][0]) <= slack
            is_thin_t = leaf["bound"][1] * (leaf["box"][3] - leaf["box"][2]) <= slack
            if is_thin_s or is_thin_t:
                continue  # narrower than rounding: its neighbours extend over it
            for c in range(4):
                stack[0, c] = leaf["box"][c]
            cells = 1
            pole = has_pole(elements, e)
            edge_extra = GRAZING * path.wide
            while cells > 0:
                ends = Ends(length, max(spare, edge_extra), max_x + edge_extra, sense)
                x, s, t, slope, cells = next_crossing(elements, leaf, pole, path, ends, work, cells)
                if x == math.inf:
                    continue
                min_width = 3.0 * path.slack if sense == EITHER else 0.0
                width, place, shift = edge_width(
                    elements, trims, piece_width, e, (s, t), path, min_width, h
                )
                if width == OUTSIDE:
                    continue
                # A face that the path meets beyond an edge is crossed where the path passes the
                # edge.
                x_tol = min(path.slack / abs(slope), spare)
                if shift != 0.0:
                    x += shift
                    x = max(x, min(x + loose[0] * width, 0.0))
                    x = min(x, max(x - loose[1] * width, length))
                else:
                    place, x = _place_on_element(elements, e, place, path, x, h)
                if x < max_x and -x_tol <= x <= length + x_tol:
                    keep_first(crossings, e, place, x, slope, x_tol, width)
                    max_x = min(max_x, x + beyond)


@inner()
def write_crossing(elements, out, i, crossing, length, h):
    """Write a crossing to row i of the hits `out`, except its status.

    `length` is the length of the path in units of x; the fraction is clipped to [0, 1].
    """
    e = int(crossing[ELEMENT])
    evaluate(elements, e, crossing[S], crossing[T], h)
    out.fraction[i] = min(max(crossing[X] / length, 0.0), 1.0)
    out.patch[i] = elements.table[e]["patch"]
    out.uv[i, 0], out.uv[i, 1] = parameters(elements, e, crossing[S], crossing[T])
    for c in range(3):
        out.point[i, c] = h[c, 0] + elements.table[e]["origin"][c]


@inner()
def write_last(elements, out, verdict, i, crossings, lengths, h):
    """Write the first crossing of a backward search to row i of the hits `out` and of `verdict`.

    Entry or exit counts, whichever has the smaller x. The status is OK, or AT_START at the start of
    the forward path. Without a crossing nothing is written. `lengths` are the length of the path in
    units of x, and the slack; for `verdict` see `last_crossings`.
    """
    side = 0 if crossings[0, X] <= crossings[1, X] else 1
    last, other = crossings[side], crossings[1 - side]
    if last[X] < math.inf:
        length, slack = lengths
        write_crossing(elements, out, i, last, length, h)
        out.fraction[i] = 1.0 - out.fraction[i]
        out.status[i] = AT_START if last[X] >= length else OK
        verdict[i, 0] = 2.0 * side - 1.0
        verdict[i, 1] = last[EDGE]
        if other[X] - other[X_TOL] <= last[X] + last[X_TOL]:
            verdict[i, 1] = max(verdict[i, 1], slack)


@inner()
def search_memory():
    """Return work arrays of a search: crossings (2, 6), `Queue` of nodes, `CellWork` of a leaf."""
    queue = Queue(np.empty(128, np.int64), np.empty(128))
    stack, k, corner = np.empty((MAX_PENDING, 4)), np.empty(9), np.empty((2, 3))
    work = CellWork(stack, np.empty((4, 6)), k, corner, np.zeros(2, np.int64))
    return np.empty((2, 6)), queue, work


@kernel(error_model="numpy")
def first_hits(tables, lists, p0, p1, rows, out, start, stop):
    """Write the first entry of each segment p0[rows[i]] → p1[rows[i]] to row i of `out`.

    The status is OK, AT_START for an entry at x ≤ 0 (by rounding before p0), NO_HIT, also for a
    path without length, NOT_FINITE, or BUDGET if cells were given up: such a row has the first
    entry found, if any, which is not proved. x is the distance from p0 along the path. `p0` and
    `p1` are (n, 3), in body axes. `lists` are `PieceLists`, which make the search faster and do not
    change the results.
    """
    elements = tables.elements
    crossings, queue, work = search_memory()
    size = tables.scale[0]
    for i in range(start, stop):
        j = rows[i]
        p = (p0[j, 0], p0[j, 1], p0[j, 2])
        q = (p1[j, 0], p1[j, 1], p1[j, 2])
        length, d, slack = begin_path(out, i, p, q, size)
        if length == 0.0 or tables.leaves.shape[0] == 0:
            continue
        spare = math.sqrt(slack * size)
        if is_clear(lists, p, q, spare):
            continue
        segment = Segment(p, d, length, slack, spare)
        _search(tables, segment, (0.0, 0.0), ENTRIES, crossings, queue, work)
        if crossings[0, X] < math.inf:
            write_crossing(elements, out, i, crossings[0], length, work.h)
            out.status[i] = AT_START if crossings[0, X] <= 0.0 else OK
        if work.counts[1] != 0:
            out.status[i] = BUDGET


@kernel(error_model="numpy")
def last_crossings(tables, lists, p0, p1, loose, out, verdict, start, stop):
    """Write the crossing nearest the end of each segment p0[i] → p1[i] to row i of `out`.

    Statuses are those of `first_hits`, AT_START for a crossing at p0. `p0` and `p1` are (n, 3);
    `loose` (2,) is the largest distance beyond p0 and p1 of a crossing at an edge, in widths of
    that edge; `lists` as for `first_hits`. Writes to `verdict` (n, 2) the sense, 1 for an entry, −1
    for an exit, 0 for none; and the width, a length, within which the result depends on rounding:
    the width of an edge at the crossing, or the slack where an entry and an exit are in one place;
    otherwise zero.
    """
    elements = tables.elements
    crossings, queue, work = search_memory()
    size = tables.scale[0]
    for i in range(start, stop):
        # The search goes backwards: what it finds as an entry is an exit.
        p = (p1[i, 0], p1[i, 1], p1[i, 2])
        q = (p0[i, 0], p0[i, 1], p0[i, 2])
        verdict[i] = 0.0
        length, d, slack = begin_path(out, i, p, q, size)
        if length == 0.0 or tables.leaves.shape[0] == 0:
            continue
        spare = math.sqrt(slack * size)
        if is_clear(lists, p, q, spare):
            continue
        segment = Segment(p, d, length, slack, spare)
        _search(tables, segment, (loose[1], loose[0]), EITHER, crossings, queue, work)
        write_last(elements, out, verdict, i, crossings, (length, slack), work.h)
        if work.counts[1] != 0:
            out.status[i] = BUDGET
