"""Cell kinds: the nodes of their faces, and the split of a face into linear triangles.

Nodes are numbered as in VTK (corners, then mid-edge nodes, then mid-face nodes), and so by meshio
for any file. Faces are listed with their normal outward for a cell of positive volume. Wedges come
in both senses: here the normal of corners 0, 1, 2 points inward, as in Gmsh and Abaqus; in VTK it
points outward. `skin` turns the faces of inverted cells, which it knows by their volume.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray, IntArray

Face = tuple[int, ...]

_TETRA = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_HEXAHEDRON = (
    (0, 3, 2, 1),
    (4, 5, 6, 7),
    (0, 1, 5, 4),
    (1, 2, 6, 5),
    (2, 3, 7, 6),
    (3, 0, 4, 7),
)
_WEDGE = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_PYRAMID = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))

# Edges in the order of their mid-edge nodes, the first of which follows the last corner.
_TETRA_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_HEXAHEDRON_EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0)),
    *((4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
_WEDGE_EDGES = (
    *((0, 1), (1, 2), (2, 0)),
    *((3, 4), (4, 5), (5, 3)),
    *((0, 3), (1, 4), (2, 5)),
)
_PYRAMID_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4))
CORNER_EDGES: dict[str, tuple[Face, ...]] = {
    "tetra": _TETRA_EDGES,
    "hexahedron": _HEXAHEDRON_EDGES,
    "wedge": _WEDGE_EDGES,
    "pyramid": _PYRAMID_EDGES,
}
"""Edges of linear solids, as pairs of corners."""

# Faces in the order of their mid-face nodes, which follow the mid-edge nodes.
_HEXAHEDRON_CENTRES = (
    (0, 3, 7, 4),
    (1, 2, 6, 5),
    (0, 1, 5, 4),
    (2, 3, 7, 6),
    (0, 1, 2, 3),
    (4, 5, 6, 7),
)
_WEDGE_CENTRES = ((0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_PYRAMID_CENTRES = ((0, 1, 2, 3),)


class SolidKind(NamedTuple):
    """A kind of solid cell."""

    n_nodes: int
    corner_faces: tuple[Face, ...]
    """Corners of each face, outward."""
    faces: tuple[Face, ...]
    """All nodes of each face: corners, mid-edge nodes in the same turn, mid-face node."""


def _solid(
    corner_faces: tuple[Face, ...],
    edges: tuple[Face, ...] = (),
    centres: tuple[Face, ...] = (),
    extra_nodes: int = 0,
) -> SolidKind:
    """Return a kind with the nodes of each face, from the orders of mid-edge and mid-face nodes.

    `extra_nodes` are on no face; `edges` are all edges or none.
    """
    n_corners = 1 + max(max(face) for face in corner_faces)
    mid_edge_node = {frozenset(edge): n_corners + i for i, edge in enumerate(edges)}
    mid_face_node = {frozenset(face): n_corners + len(edges) + i for i, face in enumerate(centres)}
    faces = []
    for face in corner_faces:
        sides = zip(face, face[1:] + face[:1], strict=True)
        mid_nodes = tuple(mid_edge_node[frozenset(side)] for side in sides) if edges else ()
        if frozenset(face) in mid_face_node:
            mid_nodes += (mid_face_node[frozenset(face)],)
        faces.append(face + mid_nodes)
    n_nodes = n_corners + len(edges) + len(centres) + extra_nodes
    return SolidKind(n_nodes, corner_faces, tuple(faces))


SOLIDS: dict[str, SolidKind] = {
    "tetra": _solid(_TETRA),
    "tetra10": _solid(_TETRA, _TETRA_EDGES),
    "hexahedron": _solid(_HEXAHEDRON),
    "hexahedron20": _solid(_HEXAHEDRON, _HEXAHEDRON_EDGES),
    "hexahedron27": _solid(_HEXAHEDRON, _HEXAHEDRON_EDGES, _HEXAHEDRON_CENTRES, extra_nodes=1),
    "wedge": _solid(_WEDGE),
    "wedge15": _solid(_WEDGE, _WEDGE_EDGES),
    "wedge18": _solid(_WEDGE, _WEDGE_EDGES, _WEDGE_CENTRES),
    "pyramid": _solid(_PYRAMID),
    "pyramid13": _solid(_PYRAMID, _PYRAMID_EDGES),
    "pyramid14": _solid(_PYRAMID, _PYRAMID_EDGES, _PYRAMID_CENTRES),
}

SHELLS: dict[str, int] = {
    "triangle": 3,
    "triangle6": 3,
    "triangle7": 3,
    "quad": 4,
    "quad8": 4,
    "quad9": 4,
}
"""Surface cells and their numbers of corners."""

N_NODES: dict[str, int] = {
    "line": 2,
    "triangle": 3,
    "triangle6": 6,
    "triangle7": 7,
    "quad": 4,
    "quad8": 8,
    "quad9": 9,
    **{kind: solid.n_nodes for kind, solid in SOLIDS.items()},
}
"""Nodes of one cell of each kind."""

_FACE_KINDS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}

_SPLITS: dict[str, tuple[Face, ...]] = {
    "triangle": ((0, 1, 2),),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "triangle7": ((0, 3, 6), (3, 1, 6), (1, 4, 6), (4, 2, 6), (2, 5, 6), (5, 0, 6)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (7, 6, 3)),
    "quad9": (
        *((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8)),
        *((2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
    ),
}
# The inner quadrilateral without the fixed triangles, which is split along its shorter diagonal.
_INNER_QUADS = {"quad": (0, 1, 2, 3), "quad8": (4, 5, 6, 7)}
_DIAGONAL_TOL = 1e-3
"""Relative difference of the squares of two diagonals up to which they count as equal, as in
rectangles with the digits of a mesh file. Else rounding, and so the unit and the place of the mesh,
would choose the facets and with them each node's share of the area."""


def face_kind(n_nodes: int) -> str:
    """Return the kind of shell with so many nodes ("quad8" for 8): 3, 4, 6, 8 or 9."""
    return _FACE_KINDS[n_nodes]


def split_quads(points: FloatArray, quads: IntArray) -> tuple[IntArray, IntArray]:
    """Split each quadrilateral along its shorter diagonal, along a-c if both are about equal.

    Diagonals whose squares differ by less than `_DIAGONAL_TOL` of them count as equal.

    Parameters
    ----------
    points : (n, 3), length
    quads : (m, 4) rows of `points`

    Returns
    -------
    triangles : (2m, 3), both of a quadrilateral one after the other, in its sense
    parent : (2m,) row of `quads` of each triangle
    """
    a, b, c, d = (quads[:, i] for i in range(4))
    ac = np.sum((points[a] - points[c]) ** 2, axis=1)
    bd = np.sum((points[b] - points[d]) ** 2, axis=1)
    by_ac = (ac <= bd * (1.0 + _DIAGONAL_TOL))[:, None]
    first = np.where(by_ac, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(by_ac, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    triangles = np.stack([first, second], axis=1).reshape(-1, 3)
    return triangles, np.repeat(np.arange(len(quads), dtype=np.int32), 2)


def split_shells(points: FloatArray, kind: str, nodes: IntArray) -> tuple[IntArray, IntArray]:
    """Return linear triangles on all nodes of surface cells of one `kind`.

    ::

        2                3──6──2
        │╲               │╱  ╲│      the middle of a quad8 is split
        5─4              7     5      along its shorter diagonal
        │╲│╲             │╲  ╱│
        0─3─1            0──4──1

    Triangles with a node twice are left out: a quadrilateral with two equal nodes is a triangle.

    Returns
    -------
    triangles : (k, 3) int32
    parent : (k,) int32, row of `nodes` of each triangle, ascending
    """
    count = len(nodes)
    pieces = [nodes[:, list(split)] for split in _SPLITS.get(kind, ())]
    parents = [np.arange(count, dtype=np.int32)] * len(pieces)
    if kind in _INNER_QUADS:
        triangles, parent = split_quads(points, nodes[:, list(_INNER_QUADS[kind])])
        pieces.append(triangles)
        parents.append(parent)
    stacked = np.concatenate(pieces).astype(np.int32)
    parent = np.concatenate(parents)
    a, b, c = stacked.T
    is_proper = (a != b) & (b != c) & (c != a)
    order = np.argsort(parent[is_proper], kind="stable")
    return stacked[is_proper][order], parent[is_proper][order]
