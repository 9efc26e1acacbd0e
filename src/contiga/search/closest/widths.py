"""Measure the widths of edges: within its width an edge belongs to both faces that meet there.

The faces of a file meet within its tolerances, not exactly. A path that slips through between
them must meet one of them, so a face reaches beyond an edge by twice the distance between the
edge and the faces' own images of it, where a second face joins; where the surface ends, nowhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CUT, POLE
from contiga.elements.element_arrays import Elements
from contiga.elements.kernels import sides_nb
from contiga.geometry.faces import Faces
from contiga.geometry.slits import gaping_edges
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray

SIDE_TOL = 1e-3
"""Distance of a trimming curve to a side of its patch's rectangle, as a share of it, below which it
runs along that side."""
MAX_WIDTH = 1e-4
"""Largest width of an edge, as a share of the body's size: wider ones are openings."""


def joints_of_faces(body: Faces) -> NDArray[np.bool_]:
    """Return (edges,) whether faces join at each edge: several share it, and it does not gape."""
    is_shared = np.array([len(edge.uses) > 1 for edge in body.edges], dtype=bool)
    return is_shared & ~gaping_edges(body)


def edge_widths(body: Faces, elements: Elements, trims: TrimTables) -> FloatArray:
    """Return the widths (pieces,) of trimming pieces, length; zero where no second face joins.

    A width is twice the tolerance of the edge there and some rounding, at most `MAX_WIDTH` of the
    body's size. Also writes the columns `width` (one for each side) and `edge_tolerance` (the
    largest width of the sides and of the trims of its patch, if a trim cuts it) of the elements.
    """
    rounding = 4.0 * float(np.finfo(float).eps) * body.size
    max_width = MAX_WIDTH * body.size
    edge_width = np.array([min(2.0 * edge.tolerance + rounding, max_width) for edge in body.edges])
    is_joint = joints_of_faces(body)
    piece_edge = np.asarray(trims.piece_edge)
    piece_width = np.zeros(len(piece_edge))
    edge_pieces = np.flatnonzero(piece_edge >= 0)
    if len(edge_pieces):
        joint_pieces = edge_pieces[is_joint[piece_edge[edge_pieces]]]
        piece_width[joint_pieces] = edge_width[piece_edge[joint_pieces]]
    # Straight pieces that close a gap in a loop are as wide as the narrower piece next to them.
    loop = np.column_stack([trims.piece_patch, trims.piece_loop[:, 0]])
    for piece in np.flatnonzero(trims.piece_loop[:, 1] < 0):
        in_loop = np.flatnonzero((loop == loop[piece]).all(axis=1))
        k = int(np.searchsorted(in_loop, piece))
        piece_width[piece] = piece_width[in_loop[[k - 1, (k + 1) % len(in_loop)]]].min()
    table = elements.table
    table["width"] = 0.0
    # Natural sides that the topology names.
    for edge, is_shared, width in zip(body.edges, is_joint, edge_width, strict=True):
        for k, use in enumerate(edge.uses):
            if use.loop >= 0 or not is_shared:
                continue
            end = body.patches[use.patch].domain[use.index // 2][use.index % 2]
            axis = 1 - use.index // 2
            box = table["box"][:, 2 * axis : 2 * axis + 2]
            low, high = edge.span(k) or (-np.inf, np.inf)
            in_span = (table["patch"] == use.patch) & (box[:, 0] < high) & (box[:, 1] > low)
            rows = np.flatnonzero(in_span & (table["box"][:, use.index] == end))
            table["width"][rows, use.index] = np.maximum(table["width"][rows, use.index], width)
    # Sides of two patches joined because they coincide: twice their distance.
    across = table["neighbour"]
    is_other_patch = table["patch"][across] != table["patch"][:, None]
    e, s = np.nonzero((across >= 0) & is_other_patch & (table["width"] < rounding))
    if len(e):
        points, _ = sides_nb.sample(elements)
        points_across = points[across[e, s], table["neighbour_side"][e, s]]
        is_flipped = table["flip"][e, s] == 1
        points_across[is_flipped] = points_across[is_flipped, ::-1]
        distance = np.linalg.norm(points[e, s] - points_across, axis=2).max(axis=1)
        table["width"][e, s] = 2.0 * distance + rounding
    # Sides of a trimmed patch's rectangle are as wide as the trimming pieces along them. Where
    # other pieces along them end the surface, the kernel asks the pieces themselves.
    ends = trims.piece_ends.reshape(-1, 2, 2)
    for patch in np.unique(trims.piece_patch[piece_width > 0.0]):
        rows = np.flatnonzero(table["patch"] == patch)
        low, high = trims.domain[patch].reshape(2, 2).T
        pieces = np.flatnonzero((trims.piece_patch == patch) & (piece_width > 0.0))
        places = (ends[pieces] - low) / (high - low)
        extent = np.ptp(places, axis=1)
        box = (table["box"][rows].reshape(-1, 2, 2) - low[:, None]) / (high - low)[:, None]
        for side in range(4):
            across_axis, axis = side // 2, 1 - side // 2
            distance = np.abs(places[:, :, across_axis] - side % 2).max(axis=1)
            # A short piece that ends in a corner is near the side, but not along it.
            is_along = (distance <= SIDE_TOL) & (extent[:, axis] > extent[:, across_axis])
            on_side = (table["box"][rows, side] == (low, high)[side % 2][across_axis]) & (
                table["kind"][rows, side] != POLE
            )
            if is_along.any() and on_side.any():
                start, stop = box[on_side, axis].T
                spans = np.sort(places[is_along, :, axis], axis=1)
                overlaps = (spans[:, 0] < stop[:, None]) & (spans[:, 1] > start[:, None])
                width = np.where(overlaps, piece_width[pieces[is_along]], 0.0).max(axis=1)
                column = table["width"][:, side]
                column[rows[on_side]] = np.maximum(column[rows[on_side]], width)
    largest = np.zeros(len(body.patches))
    np.maximum.at(largest, trims.piece_patch, piece_width)
    inner = np.where(table["trim"] == CUT, largest[table["patch"]], 0.0)
    table["edge_tolerance"] = np.maximum(table["width"].max(axis=1), inner)
    return piece_width
