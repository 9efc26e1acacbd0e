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
    """Triangles and quadrilaterals, and their original faces."""

    blocks: tuple[CellBlock, ...]
    parents: tuple[Int64Array, ...]

    def rows(self, faces: NDArray[Any]) -> tuple[Int64Array, ...]:
        """Return for each block the rows that come from some faces."""
        return tuple(np.flatnonzero(np.isin(parent, faces)) for parent in self.parents)


def blocks_of(points: FloatArray, faces: Sequence[Sequence[int]], where: str) -> Blocks:
    """Return blocks of faces; those of more than four corners are split into triangles.

    A face of fewer than three corners is a point or a line, and passed over.

    Warns
    -----
    ContigaWarning
        Faces were split.
    """
    of_three: list[Sequence[int]] = []
    of_four: list[Sequence[int]] = []
    parents: tuple[list[int], list[int]] = ([], [])
    split = []
    for k, face in enumerate(faces):
        if len(face) == 4:
            of_four.append(face)
            parents[1].append(k)
            continue
        triangles = [face] if len(face) == 3 else []
        if len(face) > 4:
            corners = points[list(face)]
            triangles = [[face[i] for i in triple] for triple in split_polygon(corners)]
            split.append(len(face))
        of_three += triangles
        parents[0].extend([k] * len(triangles))
    if split:
        warnings.warn(
            f"{where}: polygons of more than four corners were split: {len(split)}, of up to "
            f"{max(split)} corners, into {sum(split) - 2 * len(split)} triangles",
            ContigaWarning,
            stacklevel=2,
        )
    made = [
        (CellBlock(kind, np.array(rows, dtype=np.int64)), np.array(parent, dtype=np.int64))
        for kind, rows, parent in (
            ("triangle", of_three, parents[0]),
            ("quad", of_four, parents[1]),
        )
        if rows
    ]
    return Blocks(tuple(block for block, _ in made), tuple(parent for _, parent in made))
