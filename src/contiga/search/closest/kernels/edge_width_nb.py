"""Edges have width: a path that meets the carrier of a face beside it still meets the face where
it passes its edge, as seen along the path, within the width of that edge."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import BORDER, CUT, IN, OUT, SMOOTH
from contiga.arrays.kernels.vector_nb import column, dot, minus
from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.geometry.kernels.trim_nb import cell_of
from contiga.jit import inner
from contiga.jit.scratch import scratch
from contiga.search.hierarchy.kernels.curve_nb import piece_parameters
from contiga.search.hierarchy.kernels.face_nb import in_face

BESIDE = -1.0
WINDOW = 2.0
"""How much farther edges are looked for than the tangent plane says: surfaces bend."""
SAMPLES = 4
STEPS = 24
SHORT = 1e-14
"""Of a piece's parameter: steps below are none."""
SHARP = 0.1
"""Share of an edge's width that what second order leaves out may be without being looked at."""
LARGEST_WINDOW = 1.0 / 64.0
"""Share of a patch's rectangle in which edges are looked for at most."""


@inner(error_model="numpy")
def _seen(form, x, y, c):
    """Component c of where the surface is, x and y away in its parameters; 3 is along the path."""
    first = form[0, c] * x + form[1, c] * y
    return first + (form[2, c] * x + form[3, c] * y) * x + form[4, c] * y * y


@inner(error_model="numpy")
def _square_at(trims, piece, t, place, form, columns, c):
    """Squared distance of a place from the point at t of a trimming piece, and the step in t to
    where the piece's tangent comes nearest to it. Into c[0] go the parameters (u, v) there.

    By all four `columns` of `form` in space, by the first three as seen along the path.
    """
    piece_parameters(trims, piece, t, c)
    x = c[0, 0] - place[0]
    y = c[0, 1] - place[1]
    square = slope = speed = 0.0
    for k in range(columns):
        r = _seen(form, x, y, k)
        rx = form[0, k] + 2.0 * form[2, k] * x + form[3, k] * y
        ry = form[1, k] + form[3, k] * x + 2.0 * form[4, k] * y
        r1 = rx * c[1, 0] + ry * c[1, 1]
        square += r * r
        slope += r * r1
        speed += r1 * r1
    return square, (-slope / speed if speed > 0.0 else 0.0)


@inner(error_model="numpy")
def _nearest_on_piece(trims, piece, place, form, columns, c):
    """Return how near a place, or the path, comes to a trimming piece, and (u, v, t) there.

    Gauss-Newton from the best of a few samples, with steps halved where they do not come nearer:
    what is asked is whether a distance that is nearly nothing is one. `columns` as in `_square_at`.
    """
    least = math.inf
    t = step = 0.0
    for k in range(SAMPLES + 1):
        square, move = _square_at(trims, piece, k / SAMPLES, place, form, columns, c)
        if square < least:
            least, step, t = square, move, k / SAMPLES
    for _ in range(STEPS):
        new = min(max(t + step, 0.0), 1.0)
        if abs(new - t) <= SHORT:
            break
        square, move = _square_at(trims, piece, new, place, form, columns, c)
        if square < least:
            least, step, t = square, move, new
        else:
            step = 0.5 * (new - t)
    _square_at(trims, piece, t, place, form, columns, c)
    return math.sqrt(least), c[0, 0], c[0, 1], t


@inner(error_model="numpy")
def _past_piece(trims, piece, t, place, carrier, c, h):
    """Return how far the path passes from the point at t of a trimming piece, the step in t to
    where the piece's tangent comes nearest to it, and where along the path that is.

    `carrier` is (elements, e, (s, t) of `place`, path). Into c[0] go (u, v); `h` is work.
    """
    elements, e, at, path = carrier
    p, d = path.p, path.d
    box = elements.table[e]["box"]
    piece_parameters(trims, piece, t, c)
    su = 1.0 / (box[1] - box[0])
    sv = 1.0 / (box[3] - box[2])
    evaluate(elements, e, at[0] + (c[0, 0] - place[0]) * su, at[1] + (c[0, 1] - place[1]) * sv, h)
    r = minus(column(h, 0), p)
    x = dot(r, d)
    square = slope = speed = 0.0
    way = c[1, 0] * su, c[1, 1] * sv
    along = dot(column(h, 1), d) * way[0] + dot(column(h, 2), d) * way[1]
    for k in range(3):
        off = r[k] - x * d[k]
        off_t = h[k, 1] * way[0] + h[k, 2] * way[1] - along * d[k]
        square += off * off
        slope += off * off_t
        speed += off_t * off_t
    return math.sqrt(square), (-slope / speed if speed > 0.0 else 0.0), x


@inner(error_model="numpy")
def _passes(trims, piece, t, place, carrier, c):
    """Return how near the path passes by a trimming piece, (u, v) there, and where along the path.

    On the surface itself, from the t of the nearest place to second order.
    """
    h = scratch(4, 6)
    least, step, x = _past_piece(trims, piece, t, place, carrier, c, h)
    for _ in range(STEPS):
        new = min(max(t + step, 0.0), 1.0)
        if abs(new - t) <= SHORT:
            break
        away, move, along = _past_piece(trims, piece, new, place, carrier, c, h)
        if away < least:
            least, step, t, x = away, move, new, along
        else:
            step = 0.5 * (new - t)
    _past_piece(trims, piece, t, place, carrier, c, h)
    return least, c[0, 0], c[0, 1], x


@inner(linked=False, error_model="numpy")
def _piece_beside(trims, piece_width, place, x, form, widths, carrier):
    """Find the trimming pieces that the path passes within their width.

    Returns their largest width, zero if there is none; whether one of them is an edge with width;
    the nearest (u, v) of such an edge; and how much farther along the path its width begins.
    `place` (u, v) is where the path meets the carrier, at `x`, `form` the surface about it,
    `widths` the largest to look for, and that which every piece has at least at which another face
    joins; `carrier` as `_past_piece` has it.
    """
    wide, least = widths
    elements, e = carrier[0], carrier[1]
    patch = elements.table[e]["patch"]
    shared = False
    u, v = place
    uu = form[0, 0] ** 2 + form[0, 1] ** 2 + form[0, 2] ** 2
    uv = form[0, 0] * form[1, 0] + form[0, 1] * form[1, 1] + form[0, 2] * form[1, 2]
    vv = form[1, 0] ** 2 + form[1, 1] ** 2 + form[1, 2] ** 2
    domain = trims.domain[patch]
    det = uu * vv - uv * uv
    most_u = LARGEST_WINDOW * (domain[1] - domain[0])
    most_v = LARGEST_WINDOW * (domain[3] - domain[2])
    du = min(WINDOW * wide * math.sqrt(vv / det), most_u) if det > 0.0 else most_u
    dv = min(WINDOW * wide * math.sqrt(uu / det), most_v) if det > 0.0 else most_v
    i0, j0 = cell_of(trims, patch, u - du, v - dv)
    i1, j1 = cell_of(trims, patch, u + du, v + dv)
    width = 0.0
    least_way = math.inf
    way = 0.0
    edge = place
    c = scratch(3, 3)
    for j in range(j0, j1 + 1):
        for i in range(i0, i1 + 1):
            cell = trims.grid_start[patch] + j * trims.grid_shape[patch, 0] + i
            for k in range(trims.cell_start[cell], trims.cell_start[cell + 1]):
                piece = trims.cell_pieces[k]
                ends = trims.piece_ends[piece]
                piece_wide = max(piece_width[piece], least) if piece_width[piece] > 0.0 else 0.0
                if (
                    min(ends[0], ends[2]) > u + du
                    or max(ends[0], ends[2]) < u - du
                    or min(ends[1], ends[3]) > v + dv
                    or max(ends[1], ends[3]) < v - dv
                ):
                    continue
                # How near the crossing is to the piece, or else its path, and how much farther
                # along that the path passes the piece.
                away, ue, ve, t = _nearest_on_piece(trims, piece, place, form, 4, c)
                on = 0.0
                if away > piece_wide:
                    away, ue, ve, t = _nearest_on_piece(trims, piece, place, form, 3, c)
                    # How far the surface is from its tangent plane there, along the path, by the
                    # second-order term, which higher orders are assumed not to exceed.
                    du_there, dv_there, square = ue - u, ve - v, 0.0
                    on = _seen(form, du_there, dv_there, 3)
                    for n in range(3):
                        second = (form[2, n] * du_there + form[3, n] * dv_there) * du_there
                        second += form[4, n] * dv_there * dv_there
                        square += second * second
                    bend = math.sqrt(square)
                    if bend > SHARP * piece_wide and away <= piece_wide + bend:
                        away, ue, ve, passed = _passes(trims, piece, t, place, carrier, c)
                        on = passed - x
                if away > piece_wide:
                    continue
                width = max(width, piece_wide)
                before = math.sqrt(piece_wide * piece_wide - away * away)
                on = math.copysign(max(abs(on) - before, 0.0), on)
                if away <= piece_width[piece] and abs(on) < least_way:
                    shared = True
                    least_way = abs(on)
                    way = on
                    edge = (ue, ve)
    return width, shared, edge, way


@inner(linked=False, error_model="numpy")
def edge_width(elements, trims, piece_width, e, place, path, least, h):
    """Return whether a crossing at `place` (s, t) of element e belongs to its face, and where.

    `path` is a `LeafPath`, `h` holds the derivatives there. Returns BESIDE if it does
    not, else the width of the edge within whose width it lies, zero in the midst of the face; the
    place, which is on the edge if the crossing lies beyond that; and how much farther along the
    path that is. Edges that are no smooth joint are at least `least` wide.
    """
    wide = max(path.wide, least)
    s = min(max(place[0], -0.5), 0.5)
    t = min(max(place[1], -0.5), 0.5)
    if wide == 0.0:
        return (0.0 if in_face(elements, trims, e, s, t) else BESIDE), place, 0.0
    # The largest width of those sides that the place is within, and whether it is off the element.
    # Where the surface ends a side has no width; those that are no smooth joint have `least`.
    d, slack = path.d, path.slack
    row = elements.table[e]
    width, off = 0.0, False
    for side in range(4):
        within = 0.5 - place[side // 2] if side % 2 == 1 else 0.5 + place[side // 2]
        i, j = (1, 2) if side < 2 else (2, 1)  # the derivatives across the side and along it
        x = h[1, j] * d[2] - h[2, j] * d[1]
        y = h[2, j] * d[0] - h[0, j] * d[2]
        z = h[0, j] * d[1] - h[1, j] * d[0]
        area = abs(h[0, i] * x + h[1, i] * y + h[2, i] * z)
        along = math.sqrt(x * x + y * y + z * z)
        if along > 0.0:
            away = within * area / along
        else:
            away = within * math.sqrt(h[0, i] ** 2 + h[1, i] ** 2 + h[2, i] ** 2)
        across = row["neighbour"][side]
        side_width = row["width"][side]
        inner = across >= 0 and elements.table[across]["patch"] == row["patch"]
        cut_off = inner and elements.table[across]["trim"] == OUT
        if away < -max(2.5 * slack, side_width) and not cut_off:
            return BESIDE, place, 0.0
        off = off or away < -2.5 * slack
        if row["kind"][side] != SMOOTH and row["kind"][side] != BORDER:
            side_width = max(side_width, least)
        if abs(away) <= side_width:
            width = max(width, side_width)
    state = row["trim"]
    if state != CUT:
        return (width if state == IN else BESIDE), place, 0.0
    # The surface about the place as seen along d, to second order in the parameters of the patch:
    # for (u, v, uu/2, uv, vv/2) the parts (x, y, z) across d, and the part along d.
    box = row["box"]
    su = 1.0 / (box[1] - box[0])
    sv = 1.0 / (box[3] - box[2])
    scale = (su, sv, 0.5 * su * su, su * sv, 0.5 * sv * sv)
    form = np.empty((5, 4))
    for k in range(5):
        along = h[0, k + 1] * d[0] + h[1, k + 1] * d[1] + h[2, k + 1] * d[2]
        for c in range(3):
            form[k, c] = (h[c, k + 1] - along * d[c]) * scale[k]
        form[k, 3] = along * scale[k]
    at = parameters(elements, e, s, t)
    x = dot(minus(column(h, 0), path.p), path.d)
    carrier = (elements, e, (s, t), path)
    widths = (wide, least)
    beside, outer, edge, way = _piece_beside(trims, piece_width, at, x, form, widths, carrier)
    if not off and in_face(elements, trims, e, s, t):
        return max(width, beside), place, 0.0
    # Off the element or cut away: only an edge that has width lends it to the face.
    if not outer:
        return BESIDE, place, 0.0
    if way != 0.0:
        place = (
            s + (edge[0] - at[0]) / (box[1] - box[0]),
            t + (edge[1] - at[1]) / (box[3] - box[2]),
        )
    return max(width, beside), place, way
