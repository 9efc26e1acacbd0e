"""Edges have width: a path that meets the carrier of a face beside it still meets the face where
it passes its edge, as seen along the path, within the width of that edge."""

from __future__ import annotations

import math

from contiga.geometry._trim_nb import cell_of, other_coordinate
from contiga.num.jit import inner
from contiga.search._element_nb import parameters
from contiga.search._global_nb import CUT, IN, OUT, SMOOTH, in_face

BESIDE = -1.0
BORDER = 2
LARGEST_WINDOW = 1.0 / 64.0
"""Share of a patch's rectangle in which edges are looked for at most."""


@inner(error_model="numpy")
def _piece_distance(trims, piece, u, v, metric):
    """Distance of (u, v) to a trimming piece in the constant `metric` (uu, uv, vv).

    The piece is replaced by its chord between the points at the same v and at the same u, or by
    the nearer of its ends.
    """
    uu, uv, vv = metric
    ends = trims.piece_ends[piece]
    best = math.inf
    for k in range(2):
        x = ends[2 * k] - u
        y = ends[2 * k + 1] - v
        best = min(best, uu * x * x + 2.0 * uv * x * y + vv * y * y)
    low_u, high_u = min(ends[0], ends[2]), max(ends[0], ends[2])
    low_v, high_v = min(ends[1], ends[3]), max(ends[1], ends[3])
    x = math.inf
    y = math.inf
    if low_v <= v <= high_v:
        x = other_coordinate(trims, piece, 1, v) - u
        best = min(best, uu * x * x)
    if low_u <= u <= high_u:
        y = other_coordinate(trims, piece, 0, u) - v
        best = min(best, vv * y * y)
    if not (math.isfinite(x) and math.isfinite(y)):
        return math.sqrt(max(best, 0.0))
    # The foot on the line through (x, 0) and (0, y).
    den = uu * x * x - 2.0 * uv * x * y + vv * y * y
    f = (uu * x * x - uv * x * y) / den if den > 0.0 else 0.0
    x *= 1.0 - f
    y *= f
    if low_u <= u + x <= high_u and low_v <= v + y <= high_v:
        best = min(best, uu * x * x + 2.0 * uv * x * y + vv * y * y)
    return math.sqrt(max(best, 0.0))


@inner(error_model="numpy")
def _piece_beside(trims, piece_width, patch, place, metric, widths):
    """Largest width of the pieces within whose width (u, v) lies, zero where there is none, and
    whether one of them is an edge that has width.

    `widths` is the largest to look for, and that which every piece has at least at which another
    face joins.
    """
    wide, least = widths
    shared = False
    u, v = place
    uu, uv, vv = metric
    domain = trims.domain[patch]
    det = uu * vv - uv * uv
    most_u = LARGEST_WINDOW * (domain[1] - domain[0])
    most_v = LARGEST_WINDOW * (domain[3] - domain[2])
    du = min(wide * math.sqrt(vv / det), most_u) if det > 0.0 else most_u
    dv = min(wide * math.sqrt(uu / det), most_v) if det > 0.0 else most_v
    i0, j0 = cell_of(trims, patch, u - du, v - dv)
    i1, j1 = cell_of(trims, patch, u + du, v + dv)
    width = 0.0
    for j in range(j0, j1 + 1):
        for i in range(i0, i1 + 1):
            cell = trims.grid_start[patch] + j * trims.grid_shape[patch, 0] + i
            for k in range(trims.cell_start[cell], trims.cell_start[cell + 1]):
                piece = trims.cell_pieces[k]
                ends = trims.piece_ends[piece]
                own = max(piece_width[piece], least) if piece_width[piece] > 0.0 else 0.0
                if (
                    min(ends[0], ends[2]) > u + du
                    or max(ends[0], ends[2]) < u - du
                    or min(ends[1], ends[3]) > v + dv
                    or max(ends[1], ends[3]) < v - dv
                ):
                    continue
                away = _piece_distance(trims, piece, u, v, metric)
                if away <= own:
                    width = max(width, own)
                    shared = shared or away <= piece_width[piece]
    return width, shared


@inner(error_model="numpy")
def _from_side(h, d, side, within):
    """Distance at which a line along d passes a side `within` away in (s, t), as seen along d."""
    i, j = (1, 2) if side < 2 else (2, 1)  # the derivatives across the side and along it
    x = h[1, j] * d[2] - h[2, j] * d[1]
    y = h[2, j] * d[0] - h[0, j] * d[2]
    z = h[0, j] * d[1] - h[1, j] * d[0]
    c = abs(h[0, i] * x + h[1, i] * y + h[2, i] * z)
    along = math.sqrt(x * x + y * y + z * z)
    if along > 0.0:
        return within * c / along
    return within * math.sqrt(h[0, i] ** 2 + h[1, i] ** 2 + h[2, i] ** 2)


@inner(error_model="numpy")
def _rim(elements, e, place, path, least, h):
    """Width of the element's sides within whose width a place lies, BESIDE where it lies beyond,
    and whether it lies off the element.

    Sides that are no smooth joint are at least `least` wide; where the surface ends, none is.
    """
    d, slack = path[1], path[2]
    row = elements.table[e]
    width = 0.0
    off = False
    for side in range(4):
        within = 0.5 - place[side // 2] if side % 2 == 1 else 0.5 + place[side // 2]
        away = _from_side(h, d, side, within)
        across = row["neighbour"][side]
        own = row["width"][side]
        inner = across >= 0 and elements.table[across]["patch"] == row["patch"]
        cut_off = inner and elements.table[across]["trim"] == OUT
        if away < -max(2.5 * slack, own) and not cut_off:
            return BESIDE, True
        off = off or away < -2.5 * slack
        if row["kind"][side] != SMOOTH and row["kind"][side] != BORDER:
            own = max(own, least)
        if abs(away) <= own:
            width = max(width, own)
    return width, off


@inner(error_model="numpy")
def edge_width(elements, trims, piece_width, e, place, path, least, h):
    """Whether a crossing at `place` (s, t) of element e belongs to its face.

    `path` is (p, d, slack, wide, room), `h` holds the derivatives there. Returns BESIDE if it does
    not, else the width of the edge within whose width it lies, zero in the midst of the face.
    Edges that are no smooth joint are at least `least` wide.
    """
    wide = max(path[3], least)
    s = min(max(place[0], -0.5), 0.5)
    t = min(max(place[1], -0.5), 0.5)
    if wide == 0.0:
        return 0.0 if in_face(elements, trims, e, s, t) else BESIDE
    width, off = _rim(elements, e, place, path, least, h)
    state = elements.table[e]["trim"]
    if width == BESIDE or state != CUT:
        return width if state == IN else BESIDE
    d = path[1]
    aa = ab = bb = ad = bd = 0.0
    for c in range(3):
        ad += h[c, 1] * d[c]
        bd += h[c, 2] * d[c]
    for c in range(3):
        x = h[c, 1] - ad * d[c]
        y = h[c, 2] - bd * d[c]
        aa += x * x
        ab += x * y
        bb += y * y
    box = elements.table[e]["box"]
    du = box[1] - box[0]
    dv = box[3] - box[2]
    metric = (aa / (du * du), ab / (du * dv), bb / (dv * dv))
    at = parameters(elements, e, s, t)
    patch = elements.table[e]["patch"]
    beside, outer = _piece_beside(trims, piece_width, patch, at, metric, (wide, least))
    # Off the element or cut away: only an edge that has width lends it to the face.
    if not outer and (off or not in_face(elements, trims, e, s, t)):
        return BESIDE
    return max(width, beside)
