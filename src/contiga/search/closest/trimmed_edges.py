"""Edges where a trimmed face joins another: how much the surface turns there."""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.geometry.faces import Faces
from contiga.records import FloatArray
from contiga.search.closest.kernels import joint_nb
from contiga.search.hierarchy.table_types import Tables

# Pieces below which a second thread does not pay.
PIECES = 16
# Places along an edge at least, and along each piece of it.
PLACES, AT_LEAST = 8, 2
# Between samples an edge may turn a little more.
MORE = 1.02


def edge_turns(body: Faces, tables: Tables) -> FloatArray:
    """(edges,) largest angles between the normals of two faces along the edges of `body`, radians,
    as measured; infinite where no trimmed face uses an edge."""
    trims = tables.trims
    edge_of, patch_of = np.asarray(trims.piece_edge), np.asarray(trims.piece_patch)
    across = np.full(len(edge_of), -1, np.int32)
    uses = [[use.patch for use in edge.uses] for edge in body.edges]
    pairs = [pair if len(pair) == 2 and pair[0] != pair[1] else (-1, -1) for pair in uses]
    faces = np.array(pairs, np.int32).reshape(-1, 2)
    known = np.flatnonzero(edge_of >= 0)
    # Seen from one of its faces an edge is seen whole: from the first that is trimmed.
    owner = np.full(len(faces), -1)
    owner[edge_of[known[::-1]]] = patch_of[known[::-1]]
    seen = known[patch_of[known] == owner[edge_of[known]]]
    first, second = faces[edge_of[seen]].T
    across[seen] = np.where(first == patch_of[seen], second, first)
    count = np.bincount(edge_of[seen], minlength=len(faces))
    samples = np.full(len(edge_of), AT_LEAST)
    samples[seen] = np.maximum(AT_LEAST, -(-PLACES // count[edge_of[seen]]))
    measured = np.full(len(edge_of), np.inf)
    run_ranges(joint_nb.measure_pieces, len(edge_of), PIECES, tables, across, samples, measured)
    largest = np.where(count > 0, 0.0, np.inf)
    np.maximum.at(largest, edge_of[seen], measured[seen])
    return MORE * largest
