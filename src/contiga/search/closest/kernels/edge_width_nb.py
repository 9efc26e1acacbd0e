"""Edges have width: a path that meets the carrier of a face beside it also meets the face where it
passes its edge, as seen along the path, within the width of that edge."""

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

OUTSIDE = -1.0
"""Width of a crossing that does not belong to the face."""
WINDOW_FACTOR = 2.0
"""Factor by which the search window exceeds that of the tangent plane: surfaces have curvature."""
N_SAMPLES = 4
"""Number of intervals of a trimming piece whose ends are tried as starts."""
MAX_STEPS = 24
MIN_STEP = 1e-14
"""Smallest step in a piece's parameter."""
REMAINDER_SHARE = 0.1
"""Share of an edge's width that the remainder of second order may have without an exact check."""
MAX_WINDOW = 1.0 / 64.0
"""Largest search window, as a share of the patch's rectangle."""


@inner(error_model="numpy")
def _offset(form, x, y, c):
    """Return component c of the surface's displacement by (x, y) in the patch's parameters.

    The expansion `form` is of second order; component 3 is along the path.
    """
    first = form[0, c] * x + form[1, c] * y
    return first + (form[2, c] * x + form[3, c] * y) * x + form[4, c] * y * y


@inner(error_model="numpy")
def _square_at(trims, piece, t, place, form, columns, c):
    """Return the squared distance of a place from a trimming piece at t, and the step in t.

    The step is that of Gauss-Newton, zero where the distance does not depend on t. Writes the
    parameters (u, v) there to c[0]. The distance is in space with all four `columns` of `form`, as
    seen along the path with the first three.
    """
    piece_parameters(trims, piece, t, c)
    x = c[0, 0] - place[0]
    y = c[0, 1] - place[1]
    square = slope = speed = 0.0
    for k in range(columns):
        r = _offset(form, x, y, k)
        rx = form[0, k] + 2.0 * form[2, k] * x + form[3, k] * y
        ry = form[1, k] + form[3, k] * x + 2.0 * form[4, k] * y
        r1 = rx * c[1, 0] + ry * c[1, 1]
        square += r * r
        slope += r * r1
        speed += r1 * r1
    return square, (-slope / speed if speed > 0.0 else 0.0)


@inner(error_model="numpy")
def _nearest_on_piece(trims, piece, place, form, columns, c):
    """Return the distance of a place, or of the path, to a trimming piece, and u, v, t there.

    The method is Gauss-Newton from the best of a few samples; steps that do not come nearer are
    halved, because the question is whether a tiny distance is zero. `columns` as for `_square_at`:
    4 for the place, 3 for the path.
    """
    best_square = math.inf
    t = step = 0.0
    for k in range(N_SAMPLES + 1):
        square, new_step = _square_at(trims, piece, k / N_SAMPLES, place, form, columns, c)
        if square < best_square:
            best_square, step, t = square, new_step, k / N_SAMPLES
    for _ in range(MAX_STEPS):
        new = min(max(t + step, 0.0), 1.0)
        if abs(new - t) <= MIN_STEP:
            break
        square, new_step = _square_at(trims, piece, new, place, form, columns, c)
        if square < best_square:
            best_square, step, t = square, new_step, new
        else:
            step = 0.5 * (new - t)
    _square_at(trims, piece, t, place, form, columns, c)
    return math.sqrt(best_square), c[0, 0], c[0, 1], t


@inner(error_model="numpy")
def _pass_at(trims, piece, t, place, carrier, c, h):
    """Return the distance at which the path passes a trimming piece at t, the step in t, and x.

    The step is that of Gauss-Newton, x the position along the path. `carrier` is (elements, e, (s,
    t) of `place`, path). Writes (u, v) to c[0]; `h` is work.
    """
    elements, e, start, path = carrier
    p, d = path.p, path.d
    box = elements.table[e]["box"]
    piece_parameters(trims, piece, t, c)
    su = 1.0 / (box[1] - box[0])
    sv = 1.0 / (box[3] - box[2])
    new_s, new_t = start[0] + (c[0, 0] - place[0]) * su, start[1] + (c[0, 1] - place[1]) * sv
    evaluate(elements, e, new_s, new_t, h)
    r = minus(column(h, 0), p)
    x = dot(r, d)
    square = slope = speed = 0.0
    rates = c[1, 0] * su, c[1, 1] * sv
    axial_rate = dot(column(h, 1), d) * rates[0] + dot(column(h, 2), d) * rates[1]
    for k in range(3):
        offset = r[k] - x * d[k]
        offset_rate = h[k, 1] * rates[0] + h[k, 2] * rates[1] - axial_rate * d[k]
        square += offset * offset
        slope += offset * offset_rate
        speed += offset_rate * offset_rate
    return math.sqrt(square), (-slope / speed if speed > 0.0 else 0.0), x


@inner(error_model="numpy")
def _closest_pass(trims, piece, t, place, carrier, c):
    """Return the smallest distance at which the path passes a trimming piece, u, v there, and x.

    x is the position along the path. Gauss-Newton runs on the surface itself, from the t of the
    nearest place to second order.
    """
    h = scratch(4, 6)
    best_distance, step, x = _pass_at(trims, piece, t, place, carrier, c, h)
    for _ in range(MAX_STEPS):
        new = min(max(t + step, 0.0), 1.0)
        if abs(new - t) <= MIN_STEP:
            break
        distance, new_step, new_x = _pass_at(trims, piece, new, place, carrier, c, h)
        if distance < best_distance:
            best_distance, step, t, x = distance, new_step, new, new_x
        else:
            step = 0.5 * (new - t)
    _pass_at(trims, piece, t, place, carrier, c, h)
    return best_distance, c[0, 0], c[0, 1], x


@inner(linked=False, error_model="numpy")
def _pieces_near_path(trims, piece_width, place, x, form, widths, carrier):
    """Find the trimming pieces that the path passes within their width.

    Returns their largest width, zero for none; whether the path is within the own width of one of
    them (not just the least width); the (u, v) on the nearest such piece along the path, or `place`
    if there is none; and the signed distance along the path to where its width begins, else zero.
    Only pieces in a window of the patch around `place` are tested, at most `MAX_WINDOW` wide.
    `place` (u, v) is where the path meets the carrier, at `x`; `form` is the surface about it.
    `widths` are the largest width, and the least width of a piece with an adjoining face; `carrier`
    is that of `_pass_at`.
    """
    max_width, min_width = widths
    elements, e = carrier[0], carrier[1]
    patch = elements.table[e]["patch"]
    is_shared = False
    u, v = place
    uu = form[0, 0] ** 2 + form[0, 1] ** 2 + form[0, 2] ** 2
    uv = form[0, 0] * form[1, 0] + form[0, 1] * form[1, 1] + form[0, 2] * form[1, 2]
    vv = form[1, 0] ** 2 + form[1, 1] ** 2 + form[1, 2] ** 2
    domain = trims.domain[patch]
    det = uu * vv - uv * uv
    max_du = MAX_WINDOW * (domain[1] - domain[0])
    max_dv = MAX_WINDOW * (domain[3] - domain[2])
    du = min(WINDOW_FACTOR * max_width * math.sqrt(vv / det), max_du) if det > 0.0 else max_du
    dv = min(WINDOW_FACTOR * max_width * math.sqrt(uu / det), max_dv) if det > 0.0 else max_dv
    i0, j0 = cell_of(trims, patch, u - du, v - dv)
    i1, j1 = cell_of(trims, patch, u + du, v + dv)
    width = 0.0
    best_shift = math.inf
    edge_shift = 0.0
    edge = place
    c = scratch(3, 3)
    for j in range(j0, j1 + 1):
        for i in range(i0, i1 + 1):
            cell = trims.grid_start[patch] + j * trims.grid_shape[patch, 0] + i
            for k in range(trims.cell_start[cell], trims.cell_start[cell + 1]):
                piece = trims.cell_pieces[k]
                ends = trims.piece_ends[piece]
                padded = max(piece_width[piece], min_width) if piece_width[piece] > 0.0 else 0.0
                if (
                    min(ends[0], ends[2]) > u + du
                    or max(ends[0], ends[2]) < u - du
                    or min(ends[1], ends[3]) > v + dv
                    or max(ends[1], ends[3]) < v - dv
                ):
                    continue
                # The distance of the crossing, or else of its path, to the piece, and the shift
                # along the path to where it passes the piece.
                distance, ue, ve, t = _nearest_on_piece(trims, piece, place, form, 4, c)
                shift = 0.0
                if distance > padded:
                    distance, ue, ve, t = _nearest_on_piece(trims, piece, place, form, 3, c)
                    # The surface leaves its tangent plane there by the second-order term, which
                    # higher orders are assumed not to exceed.
                    du_there, dv_there, square = ue - u, ve - v, 0.0
                    shift = _offset(form, du_there, dv_there, 3)
                    for n in range(3):
                        second = (form[2, n] * du_there + form[3, n] * dv_there) * du_there
                        second += form[4, n] * dv_there * dv_there
                        square += second * second
                    remainder = math.sqrt(square)
                    if remainder > REMAINDER_SHARE * padded and distance <= padded + remainder:
                        distance, ue, ve, edge_x = _closest_pass(trims, piece, t, place, carrier, c)
                        shift = edge_x - x
                if distance > padded:
                    continue
                width = max(width, padded)
                half_chord = math.sqrt(padded * padded - distance * distance)
                shift = math.copysign(max(abs(shift) - half_chord, 0.0), shift)
                if distance <= piece_width[piece] and abs(shift) < best_shift:
                    is_shared = True
                    best_shift = abs(shift)
                    edge_shift = shift
                    edge = (ue, ve)
    return width, is_shared, edge, edge_shift


@inner(linked=False, error_model="numpy")
def edge_width(elements, trims, piece_width, e, place, path, min_width, h):
    """Return (width, place, shift) of a crossing at `place` (s, t) of element e.

    The width is that of the edge within whose width the crossing is, zero inside the face, OUTSIDE
    if the crossing does not belong to the face. The place is on the edge if the crossing is beyond
    a trimming piece, and then `shift` is the way to it along the path, a length, else zero. `path`
    is a `LeafPath`, `h` holds the derivatives at `place`. Edges other than smooth joints and
    borders are at least `min_width` wide.
    """
    max_width = max(path.wide, min_width)
    s = min(max(place[0], -0.5), 0.5)
    t = min(max(place[1], -0.5), 0.5)
    if max_width == 0.0:
        return (0.0 if in_face(elements, trims, e, s, t) else OUTSIDE), place, 0.0
    # The largest width of the sides that the place is within, and whether it is off the element. A
    # side where the surface ends has no width, every other one that is no smooth joint `min_width`.
    d, slack = path.d, path.slack
    row = elements.table[e]
    width, is_off = 0.0, False
    for side in range(4):
        inset = 0.5 - place[side // 2] if side % 2 == 1 else 0.5 + place[side // 2]
        i, j = (1, 2) if side < 2 else (2, 1)  # the derivatives across the side and along it
        x = h[1, j] * d[2] - h[2, j] * d[1]
        y = h[2, j] * d[0] - h[0, j] * d[2]
        z = h[0, j] * d[1] - h[1, j] * d[0]
        area = abs(h[0, i] * x + h[1, i] * y + h[2, i] * z)
        along = math.sqrt(x * x + y * y + z * z)
        if along > 0.0:
            distance = inset * area / along
        else:
            distance = inset * math.sqrt(h[0, i] ** 2 + h[1, i] ** 2 + h[2, i] ** 2)
        across = row["neighbour"][side]
        side_width = row["width"][side]
        in_patch = across >= 0 and elements.table[across]["patch"] == row["patch"]
        cut_off = in_patch and elements.table[across]["trim"] == OUT
        if distance < -max(2.5 * slack, side_width) and not cut_off:
            return OUTSIDE, place, 0.0
        is_off = is_off or distance < -2.5 * slack
        if row["kind"][side] != SMOOTH and row["kind"][side] != BORDER:
            side_width = max(side_width, min_width)
        if abs(distance) <= side_width:
            width = max(width, side_width)
    state = row["trim"]
    if state != CUT:
        return (width if state == IN else OUTSIDE), place, 0.0
    # The surface about the place, to second order in the parameters of the patch: for (u, v, uu/2,
    # uv, vv/2) the components (x, y, z) perpendicular to d, and the component along d.
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
    uv = parameters(elements, e, s, t)
    x = dot(minus(column(h, 0), path.p), path.d)
    carrier = (elements, e, (s, t), path)
    widths = (max_width, min_width)
    trim_width, is_shared, edge, shift = _pieces_near_path(
        trims, piece_width, uv, x, form, widths, carrier
    )
    if not is_off and in_face(elements, trims, e, s, t):
        return max(width, trim_width), place, 0.0
    # Off the element or cut away: the crossing belongs to the face only within an edge's width.
    if not is_shared:
        return OUTSIDE, place, 0.0
    if shift != 0.0:
        place = (
            s + (edge[0] - uv[0]) / (box[1] - box[0]),
            t + (edge[1] - uv[1]) / (box[3] - box[2]),
        )
    return max(width, trim_width), place, shift
