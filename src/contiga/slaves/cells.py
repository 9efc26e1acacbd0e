"""Cell kinds: which nodes make up their faces, and how a face splits into linear triangles.

Nodes are numbered as VTK does (corners, then mid-edge nodes, then mid-face nodes), which is also
what meshio hands over whatever the file. Faces are listed with their normal outward for a cell of
positive volume; wedges, whose sense differs between codes, are mended by `skin` from their volume.
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
    n_corners = 1 + max(max(face) for face in corner_faces)
    middle = {frozenset(edge): n_corners + i for i, edge in enumerate(edges)}
    centre = {frozenset(face): n_corners + len(edges) + i for i, face in enumerate(centres)}
    faces = []
    for face in corner_faces:
        turn = zip(face, face[1:] + face[:1], strict=True)
        middles = tuple(middle[frozenset(edge)] for edge in turn) if edges else ()
        centred = (centre[frozenset(face)],) if frozenset(face) in centre else ()
        faces.append(face + middles + centred)
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
# What is left of a quadrilateral once its fixed triangles are cut off: split by its diagonals.
_REST = {"quad": (0, 1, 2, 3), "quad8": (4, 5, 6, 7)}


def face_kind(n_nodes: int) -> str:
    """Kind of shell a face of `n_nodes` nodes looks like ("quad8" for 8)."""
    return _FACE_KINDS[n_nodes]


# Difference of the squares of two diagonals, relative, up to which they are as long: rectangles
# with the digits of a mesh file. Rounding would choose by the unit and the place of the mesh, and
# with the facets each node's share of the area.
_AS_LONG = 1e-3


def split_quads(points: FloatArray, quads: IntArray) -> tuple[IntArray, IntArray]:
    """Split each quadrilateral along its shorter diagonal, along a-c where both are as long.

    Parameters
    ----------
    points : (n, 3), length
    quads : (m, 4) rows of `points`

    Returns
    -------
    triangles : (2m, 3), the two of a quadrilateral one after the other, same sense as it
    parent : (2m,) the row of `quads` each came from
    """
    a, b, c, d = (quads[:, i] for i in range(4))
    ac = np.sum((points[a] - points[c]) ** 2, axis=1)
    bd = np.sum((points[b] - points[d]) ** 2, axis=1)
    along_ac = (ac <= bd * (1.0 + _AS_LONG))[:, None]
    first = np.where(along_ac, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(along_ac, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    triangles = np.stack([first, second], axis=1).reshape(-1, 3)
    return triangles, np.repeat(np.arange(len(quads), dtype=np.int32), 2)


def split_shells(points: FloatArray, kind: str, nodes: IntArray) -> tuple[IntArray, IntArray]:
    """Linear triangles on all the nodes of surface cells of one `kind`.

    ::

        2                3──6──2
        │╲               │╱  ╲│      the middle of a quad8 is split
        5─4              7     5      along its shorter diagonal
        │╲│╲             │╲  ╱│
        0─3─1            0──4──1

    Triangles that name a node twice (a quadrilateral with two equal nodes is a triangle) are left
    out.

    Returns
    -------
    triangles : (k, 3) int32
    parent : (k,) int32, the row of `nodes` each came from, ascending
    """
    count = len(nodes)
    pieces = [nodes[:, list(split)] for split in _SPLITS.get(kind, ())]
    parents = [np.arange(count, dtype=np.int32)] * len(pieces)
    if kind in _REST:
        triangles, parent = split_quads(points, nodes[:, list(_REST[kind])])
        pieces.append(triangles)
        parents.append(parent)
    stacked = np.concatenate(pieces).astype(np.int32)
    parent = np.concatenate(parents)
    a, b, c = stacked.T
    proper = (a != b) & (b != c) & (c != a)
    order = np.argsort(parent[proper], kind="stable")
    return stacked[proper][order], parent[proper][order]
