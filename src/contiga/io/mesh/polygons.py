"""Faces of any number of corners as blocks of triangles and quadrilaterals."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import ContigaWarning
from contiga.records import FloatArray
from contiga.slaves.polygons import split_polygon
from contiga.slaves.skin import CellBlock, Int64Array


class Blocks(NamedTuple):
    """Blocks of cells, and the cells or faces of the file that they come from."""

    blocks: tuple[CellBlock, ...]
    parents: tuple[Int64Array, ...]
    """(m,) index of the original face of each cell, for each block."""

    def rows(self, faces: NDArray[Any]) -> tuple[Int64Array, ...]:
        """Return for each block the rows, ascending, that come from `faces`."""
        return tuple(np.flatnonzero(np.isin(parent, faces)) for parent in self.parents)


def blocks_of(points: FloatArray, faces: Sequence[Sequence[int]], where: str) -> Blocks:
    """Return up to two blocks of faces, rows of `points`: triangles, then quadrilaterals.

    Faces of more than four corners are split into triangles; those of fewer than three are left
    out. A kind that does not occur has no block.

    Warns
    -----
    ContigaWarning
        Faces were split.
    """
    triangles: list[Sequence[int]] = []
    quads: list[Sequence[int]] = []
    triangle_parents: list[int] = []
    quad_parents: list[int] = []
    split_sizes = []
    for k, face in enumerate(faces):
        if len(face) == 4:
            quads.append(face)
            quad_parents.append(k)
        elif len(face) == 3:
            triangles.append(face)
            triangle_parents.append(k)
        elif len(face) > 4:
            triples = split_polygon(points[list(face)])
            triangles += [[face[i] for i in triple] for triple in triples]
            triangle_parents += [k] * len(triples)
            split_sizes.append(len(face))
    if split_sizes:
        n_triangles = sum(split_sizes) - 2 * len(split_sizes)
        warnings.warn(
            f"{where}: polygons of more than four corners were split: {len(split_sizes)}, of up to "
            f"{max(split_sizes)} corners, into {n_triangles} triangles",
            ContigaWarning,
            stacklevel=2,
        )
    pieces = [
        (CellBlock(kind, np.array(rows, dtype=np.int64)), np.array(parents, dtype=np.int64))
        for kind, rows, parents in (
            ("triangle", triangles, triangle_parents),
            ("quad", quads, quad_parents),
        )
        if rows
    ]
    return Blocks(tuple(block for block, _ in pieces), tuple(parents for _, parents in pieces))
