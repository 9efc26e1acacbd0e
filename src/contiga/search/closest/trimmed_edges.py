"""Edges where a trimmed face joins another: which faces, how wide, how much the surface turns.

Made once a body, for the certificates of feet on and beside such edges (`edge_nb`).
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Records
from contiga.geometry.faces import Faces
from contiga.records import IntArray
from contiga.search.closest.kernels import joint_nb
from contiga.search.hierarchy.table_types import JOINT, Joints, Tables

# Pieces below which a second thread does not pay.
PIECES = 16
# Places along an edge at least, and along each piece of it.
PLACES, AT_LEAST = 8, 2
# An element this little longer than an edge (share of its patch) runs along it.
HAIR = 1e-9
# Between samples an edge may turn and slip a little more.
MORE = 1.02


def build_joints(body: Faces, tables: Tables) -> Joints:
    """Joints of all edges of `body` that a trimmed face uses, and which sides run along them."""
    edges = np.zeros(len(body.edges), JOINT)
    edges["patch"] = -1
    trims = tables.trims
    edge_of, patch_of = np.asarray(trims.piece_edge), np.asarray(trims.piece_patch)
    across = np.full(len(edge_of), -1, np.int32)
    for k, edge in enumerate(body.edges):
        first, second = (use.patch for use in edge.uses) if len(edge.uses) == 2 else (0, 0)
        if first == second:
            continue
        edges["patch"][k] = first, second
    known = np.flatnonzero(edge_of >= 0)
    # Seen from one of its faces an edge is seen whole: from the first that is trimmed.
    owner = np.full(len(edges), -1)
    owner[edge_of[known[::-1]]] = patch_of[known[::-1]]
    seen = known[patch_of[known] == owner[edge_of[known]]]
    faces = edges["patch"][edge_of[seen]]
    across[seen] = np.where(faces[:, 0] == patch_of[seen], faces[:, 1], faces[:, 0])
    count = np.bincount(edge_of[seen], minlength=len(edges))
    samples = np.full(len(edge_of), AT_LEAST)
    samples[seen] = np.maximum(AT_LEAST, -(-PLACES // count[edge_of[seen]]))
    measured = np.full((len(edge_of), 2), np.inf)
    run_ranges(joint_nb.measure_pieces, len(edge_of), PIECES, tables, across, samples, measured)
    largest = np.full((len(edges), 3), np.inf)
    largest[count > 0] = 0.0
    width = np.asarray(tables.piece_width)[seen]
    np.maximum.at(largest, edge_of[seen], np.column_stack([measured[seen], width]))
    edges["turn"], edges["slip"] = MORE * largest[:, 0], MORE * largest[:, 1]
    edges["width"] = largest[:, 2]
    edges["patch"][~np.isfinite(largest[:, 0])] = -1
    return Joints(edges, _sides(body, tables, edges))


def _sides(body: Faces, tables: Tables, edges: Records) -> IntArray:
    """(elements, 4) the edge that a natural side of an untrimmed patch is a part of, −1 none."""
    table = tables.elements.table
    sides = np.full((len(table), 4), -1, np.int32)
    for k in np.flatnonzero(edges["patch"][:, 0] >= 0):
        edge = body.edges[k]
        for i, use in enumerate(edge.uses):
            if use.loop >= 0:
                continue
            end = body.patches[use.patch].domain[use.index // 2][use.index % 2]
            along = 1 - use.index // 2
            box = table["box"][:, 2 * along : 2 * along + 2]
            low, high = edge.span(i) or (-np.inf, np.inf)
            hair = HAIR * float(np.ptp(body.patches[use.patch].domain[along]))
            rows = (table["patch"] == use.patch) & (table["box"][:, use.index] == end)
            rows &= (box[:, 0] >= low - hair) & (box[:, 1] <= high + hair)
            sides[rows, use.index] = k
    return sides
