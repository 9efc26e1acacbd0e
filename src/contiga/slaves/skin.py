"""Surface facets of a mesh: the skin of its solids, its shells, and each node's share of the area.

A face of a solid belongs to the skin if no other solid has it. Faces are compared by their corners
alone, so that linear and quadratic cells match where they meet.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IntArray
from contiga.slaves.cells import SHELLS, SOLIDS, face_kind, split_shells
from contiga.slaves.quads import at_corners, corner_areas, corners_of

Int64Array = NDArray[np.int64]


class CellBlock(NamedTuple):
    """Cells of one kind."""

    kind: str
    """Name of the kind in meshio: "tetra10", "quad" …"""
    nodes: Int64Array
    """(m, k) rows of the mesh's points."""


class _Faces(NamedTuple):
    """Faces (or shells) of one layout, as candidates for the skin."""

    kind: str
    """Kind of shell with these nodes."""
    nodes: Int64Array
    """(m, k) rows of the mesh's points, corners first."""
    n_corners: int
    is_solid: bool
    """Whether they are faces of solids."""
    block: int
    """Number of their block of cells."""
    cell: Int64Array
    """(m,) row of the cell of each in its block."""


def facet_width(points: FloatArray, facets: IntArray) -> float:
    """Return the median of the shortest sides of facets (f, 3) of points (n, 3), a length.

    It is infinite without facets.
    """
    if len(facets) == 0:
        return np.inf
    corners = points[facets]
    squares = np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2)
    return float(np.sqrt(np.median(squares.min(axis=1))))


def tributary_area(
    points: FloatArray, facets: IntArray, quads: IntArray | None = None
) -> FloatArray:
    """Return each node's share of the surface: ∫ N dA of its shape function over the faces.

    It is a third of each triangle and a quarter of each parallelogram at the node.

    Parameters
    ----------
    points : (n, 3), length
    facets : (m, 3) rows of `points`
    quads : (q, 2) rows of `facets` that are halves of a quadrilateral; none if omitted

    Returns
    -------
    (n,) area, zero for nodes on no facet; the sum is the area of the faces
    """
    skin = corners_of(facets, np.zeros((0, 2), np.int32) if quads is None else quads)
    return at_corners(skin, corner_areas(points, skin), len(points))


def skin(points: FloatArray, blocks: list[CellBlock] | tuple[CellBlock, ...]) -> IntArray:
    """Return the surface of a mesh as linear triangles.

    Normals of solids point outward, and shells keep their sense in the file. Quadratic faces are
    split through their mid-side nodes. A shell that lies on a face of a solid, or on an earlier
    shell, adds no second layer: mesh generators write the boundary of a volume beside the volume. A
    shell between two solids is inside, and left out. Faces of fewer than three different corners
    have no area.

    Parameters
    ----------
    points : (n, 3), length
    blocks : the cells; lines and vertices are ignored

    Returns
    -------
    (m, 3) int32, rows of `points`, in the order of blocks, their faces, and cells
    """
    faces: list[_Faces] = []
    for k, block in enumerate(blocks):
        cells = np.arange(len(block.nodes), dtype=np.int64)
        if block.kind in SHELLS:
            faces.append(_Faces(block.kind, block.nodes, SHELLS[block.kind], False, k, cells))
        elif block.kind in SOLIDS:
            solid = SOLIDS[block.kind]
            for corners, side in zip(solid.corner_faces, solid.faces, strict=True):
                kind, side_nodes = face_kind(len(side)), block.nodes[:, list(side)]
                faces.append(_Faces(kind, side_nodes, len(corners), True, k, cells))
    if not faces:
        return np.empty((0, 3), dtype=np.int32)
    pieces = []
    for face, is_on_surface in zip(faces, _surface_masks(faces), strict=True):
        nodes = face.nodes[is_on_surface]
        triangles, parent = split_shells(points, face.kind, nodes.astype(np.int32))
        if face.is_solid:
            block = blocks[face.block]
            cell_nodes = block.nodes[face.cell[is_on_surface]]
            is_inverted = (_volumes(points, block.kind, cell_nodes) < 0.0)[parent]
            triangles[is_inverted] = triangles[is_inverted][:, ::-1]
        pieces.append(triangles)
    return np.ascontiguousarray(np.concatenate(pieces), dtype=np.int32)


def mend_degenerate(block: CellBlock) -> list[CellBlock]:
    """Return the block, or its hexahedra and the tetrahedra written as hexahedra in two blocks.

    LS-DYNA writes a tetrahedron as ``n1 n2 n3 n4 n4 n4 n4 n4``; read as a hexahedron, its four
    different nodes would make up a folded base. Other collapsed cells need no change. Of
    hexahedra an empty part is left out, so that the list may have one block or none.
    """
    if block.kind != "hexahedron":
        return [block]
    nodes = block.nodes
    is_tetra = np.all(nodes[:, 4:] == nodes[:, 3:4], axis=1)
    parts = [CellBlock("hexahedron", nodes[~is_tetra]), CellBlock("tetra", nodes[is_tetra][:, :4])]
    return [part for part in parts if len(part.nodes)]


def _surface_masks(faces: list[_Faces]) -> list[NDArray[np.bool_]]:
    """Return for each set of faces a mask of its rows: whether they are on the surface.

    Faces are the same if they have the same corners. On the surface is a face of just one solid, or
    the first of shells that no solid has; not faces of fewer than three different corners.
    """
    key_sets = []
    for face in faces:
        # different corner ids (m, 4) of each face, ascending, after −1 if there are fewer
        corners = np.sort(face.nodes[:, : face.n_corners], axis=1)
        corners[:, 1:][corners[:, 1:] == corners[:, :-1]] = -1
        padded = np.full((len(corners), 4), -1, dtype=np.int64)
        padded[:, 4 - face.n_corners :] = np.sort(corners, axis=1)
        key_sets.append(padded)
    keys = np.concatenate(key_sets)
    is_solid = np.concatenate([np.full(len(face.nodes), face.is_solid) for face in faces])
    # The upper two and the lower two ids share a word each: two sorting passes instead of four.
    upper = (keys[:, 0] << 32) | (keys[:, 1] & 0xFFFFFFFF)
    lower = (keys[:, 2] << 32) | (keys[:, 3] & 0xFFFFFFFF)
    # lexsort is stable and solids sort before shells, so the first of a group represents it.
    order = np.lexsort((~is_solid, lower, upper))
    upper, lower, solid = upper[order], lower[order], is_solid[order]
    is_first = np.ones(len(order), dtype=bool)
    is_first[1:] = (upper[1:] != upper[:-1]) | (lower[1:] != lower[:-1])
    group = np.cumsum(is_first) - 1
    n_solids = np.bincount(group, weights=solid)[group]
    on_surface = is_first & (~solid | (n_solids == 1))
    on_surface &= keys[order, 1] >= 0  # fewer than three different corners: no area
    masks = np.empty(len(order), dtype=bool)
    masks[order] = on_surface
    return np.split(masks, np.cumsum([len(face.nodes) for face in faces])[:-1])


def _volumes(points: FloatArray, kind: str, nodes: Int64Array) -> FloatArray:
    """Return volumes (m,) of solids, negative if inverted, from their corners alone.

    By the divergence theorem over faces split into fans, about the first node to reduce round-off.
    """
    volume = np.zeros(len(nodes))
    origin = points[nodes[:, 0]]
    for face in SOLIDS[kind].corner_faces:
        a = points[nodes[:, face[0]]] - origin
        for second, third in pairwise(face[1:]):
            b = points[nodes[:, second]] - origin
            c = points[nodes[:, third]] - origin
            volume += np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return volume
