"""Elements of a slave: the cells of its mesh by kind, as rows of its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.records import IntArray
from contiga.slaves.cells import N_NODES, SHELLS, SOLIDS
from contiga.slaves.skin import CellBlock, Int64Array

NO_ELEMENTS: Mapping[str, IntArray] = MappingProxyType({})
# Order of corners that gives a mirrored solid a positive volume, for the kinds that deform.
_MIRRORED = {"tetra": (0, 2, 1, 3), "hexahedron": (4, 5, 6, 7, 0, 1, 2, 3)}


def as_elements(
    cells_by_kind: Mapping[str, Any] | None, count: int, name: str
) -> Mapping[str, IntArray]:
    """Return elements by kind as read-only copies (e, k) int32; an empty mapping if there are none.

    Raises
    ------
    MeshError
        An unknown kind, another number of nodes than it has, or a node that is no point.
    """
    elements = {}
    for kind, rows in (cells_by_kind or {}).items():
        cells = np.array(rows)
        n_nodes = N_NODES.get(kind)
        if cells.ndim != 2 or cells.dtype.kind not in "iu" or cells.shape[1] != n_nodes:
            raise MeshError(
                "elements must be rows of points by their kind",
                where=f"{name}: elements",
                found=f"{kind}: shape {cells.shape} of {cells.dtype}",
                allowed=", ".join(f"{kind} (e, {k})" for kind, k in N_NODES.items()),
            )
        if len(cells) and not 0 <= cells.min() <= cells.max() < count:
            raise MeshError(
                "an element names a point that is not there",
                where=f"{name}: elements",
                found=[int(cells.min()), int(cells.max())],
                allowed=f"0 to {count - 1}",
            )
        elements[kind] = np.ascontiguousarray(cells, dtype=np.int32)
        elements[kind].flags.writeable = False
    return MappingProxyType(elements) if elements else NO_ELEMENTS


def mirrored(elements: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Return elements whose points were mirrored, with their nodes in a valid order again.

    Linear shells are reversed, and linear tetrahedra and hexahedra get a positive volume. Other
    kinds, which do not deform, are the same arrays.
    """
    reordered = {}
    for kind, rows in elements.items():
        if kind in SHELLS:
            reordered[kind] = rows[:, ::-1] if SHELLS[kind] == rows.shape[1] else rows
        elif kind in _MIRRORED:
            reordered[kind] = rows[:, list(_MIRRORED[kind])]
        else:
            reordered[kind] = rows  # other solids do not deform
    return reordered


def elements_of(blocks: Sequence[CellBlock]) -> dict[str, IntArray]:
    """Return the elements among the cells by kind, (e, k) int32, in the order of the blocks.

    These are all solids, the shells that have a node on no solid, and the lines that are no edges
    of shells or solids: mesh generators write the borders of their meshes as shells and lines.
    Unknown kinds are left out.
    """
    cells: dict[str, list[Any]] = {}
    solids = [block.nodes for block in blocks if block.kind in SOLIDS and len(block.nodes)]
    corners = np.unique(np.concatenate([np.zeros(0, int), *(nodes.ravel() for nodes in solids)]))
    for block in blocks:
        nodes = block.nodes
        if block.kind in SHELLS and solids:
            nodes = nodes[~np.isin(nodes, corners).all(axis=1)]
        if block.kind == "line":
            nodes = nodes[~_are_edges(nodes, blocks)]
        if block.kind in N_NODES and len(nodes):
            cells.setdefault(block.kind, []).append(nodes)
    return {kind: np.concatenate(rows).astype(np.int32) for kind, rows in cells.items()}


def _are_edges(lines: Int64Array, blocks: Sequence[CellBlock]) -> NDArray[np.bool_]:
    """Return (n,) which lines (n, 2) join neighbouring corners of a shell or of a solid's face."""
    edge_sets = [np.zeros((0, 2), np.int64)]
    for block in blocks:
        if block.kind in SHELLS:
            faces: Sequence[Sequence[int]] = [range(SHELLS[block.kind])]
        elif block.kind in SOLIDS:
            faces = SOLIDS[block.kind].corner_faces
        else:
            continue
        for face in faces:
            corners = np.array(face)
            next_corners = np.roll(corners, -1)
            pairs = np.stack([block.nodes[:, corners], block.nodes[:, next_corners]], axis=-1)
            edge_sets.append(pairs.reshape(-1, 2))
    edges, ends = np.concatenate(edge_sets), np.asarray(lines, np.int64)
    count = 1 + max(int(edges.max(initial=0)), int(ends.max(initial=0)))
    keys = [np.sort(pairs, axis=1) @ np.array([count, 1]) for pairs in (ends, edges)]
    return np.isin(*keys)
