"""Measure the widths of edges: within its width an edge belongs to both faces that meet there.

The faces of a file meet within its tolerances, not exactly. A path that slips through between
them must meet one of them, so a face reaches beyond an edge by twice the distance between the
edge and the faces' own images of it, where a second face joins; where the surface ends, nowhere.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import CUT, POLE
from contiga.elements.element_arrays import Elements
from contiga.elements.kernels import sides_nb
from contiga.geometry.faces import Faces
from contiga.geometry.slits import gaping_edges
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray

# A trimming curve this close to a side of its patch's rectangle, as a share of it, runs along it.
NEAR = 1e-3
# Widest edge, as a share of the body's size: what is farther apart is an opening.
WIDEST = 1e-4


def edge_widths(body: Faces, elements: Elements, trims: TrimTables) -> FloatArray:
    """Return the widths (pieces,) of trimming pieces.

    It fills `width` and `edge_tolerance` of the elements.

    Twice the tolerance of the edge there and some rounding, at most `WIDEST`; lengths.
    """
    least = 4.0 * float(np.finfo(float).eps) * body.size
    most = WIDEST * body.size
    of_edge = np.array([min(2.0 * edge.tolerance + least, most) for edge in body.edges])
    shared = np.array([len(edge.uses) > 1 for edge in body.edges], dtype=bool)
    shared &= ~gaping_edges(body)
    piece_edge = np.asarray(trims.piece_edge)
    pieces = np.zeros(len(piece_edge))
    known = np.flatnonzero(piece_edge >= 0)
    joined = known[shared[piece_edge[known]]] if len(known) else known
    pieces[joined] = of_edge[piece_edge[joined]]
    # Straight pieces that close a gap in a loop are as wide as the narrower piece beside them.
    loop = np.column_stack([trims.piece_patch, trims.piece_loop[:, 0]])
    for piece in np.flatnonzero(trims.piece_loop[:, 1] < 0):
        in_loop = np.flatnonzero((loop == loop[piece]).all(axis=1))
        at = int(np.searchsorted(in_loop, piece))
        beside = in_loop[[at - 1, (at + 1) % len(in_loop)]]
        pieces[piece] = pieces[beside].min()
    table = elements.table
    table["width"] = 0.0
    # Natural sides that the topology names.
    for edge, is_shared, width in zip(body.edges, shared, of_edge, strict=True):
        for k, use in enumerate(edge.uses):
            if use.loop >= 0 or not is_shared:
                continue
            end = body.patches[use.patch].domain[use.index // 2][use.index % 2]
            along = 1 - use.index // 2
            box = table["box"][:, 2 * along : 2 * along + 2]
            low, high = edge.span(k) or (-np.inf, np.inf)
            within = (table["patch"] == use.patch) & (box[:, 0] < high) & (box[:, 1] > low)
            rows = np.flatnonzero(within & (table["box"][:, use.index] == end))
            table["width"][rows, use.index] = np.maximum(table["width"][rows, use.index], width)
    # Sides of two patches joined because they lie in one place: twice their distance.
    across = table["neighbour"]
    other = table["patch"][across] != table["patch"][:, None]
    e, s = np.nonzero((across >= 0) & other & (table["width"] < least))
    if len(e):
        points, _ = sides_nb.sample(elements)
        here, beyond = points[e, s], points[across[e, s], table["neighbour_side"][e, s]]
        turned = table["flip"][e, s] == 1
        beyond[turned] = beyond[turned, ::-1]
        off = np.linalg.norm(here - beyond, axis=2).max(axis=1)
        table["width"][e, s] = 2.0 * off + least
    # Sides of a trimmed patch's rectangle are as wide as the trimming pieces along them. Where
    # others of them end the surface, the kernel asks the pieces themselves.
    ends = trims.piece_ends.reshape(-1, 2, 2)
    for patch in np.unique(trims.piece_patch[pieces > 0.0]):
        rows = np.flatnonzero(table["patch"] == patch)
        low, high = trims.domain[patch].reshape(2, 2).T
        wide = np.flatnonzero((trims.piece_patch == patch) & (pieces > 0.0))
        places = (ends[wide] - low) / (high - low)
        box = (table["box"][rows].reshape(-1, 2, 2) - low[:, None]) / (high - low)[:, None]
        for side in range(4):
            off = np.abs(places[:, :, side // 2] - side % 2)
            way = np.ptp(places, axis=1)
            # A short piece that comes in to a corner is near the side, but not along it.
            near = (off.max(axis=1) <= NEAR) & (way[:, 1 - side // 2] > way[:, side // 2])
            rim = (table["box"][rows, side] == (low, high)[side % 2][side // 2]) & (
                table["kind"][rows, side] != POLE
            )
            if near.any() and rim.any():
                start, stop = box[rim, 1 - side // 2].T
                spans = np.sort(places[near, :, 1 - side // 2], axis=1)
                beside = (spans[:, 0] < stop[:, None]) & (spans[:, 1] > start[:, None])
                widest = np.where(beside, pieces[wide[near]], 0.0).max(axis=1)
                column = table["width"][:, side]
                column[rows[rim]] = np.maximum(column[rows[rim]], widest)
    largest = np.zeros(len(body.patches))
    np.maximum.at(largest, trims.piece_patch, pieces)
    inner = np.where(table["trim"] == CUT, largest[table["patch"]], 0.0)
    table["edge_tolerance"] = np.maximum(table["width"].max(axis=1), inner)
    return pieces
