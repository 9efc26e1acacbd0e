"""Find meshes that share no nodes where they meet, and elements that are given twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.groups import groups_of
from contiga.dynamics.deforming_nodes import DeformingNodes
from contiga.matter.parts import DIMENSION
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

# Distance of nodes at the same place, as a share of the shortest edge of an element.
_PLACE_TOL = 1e-4


def check_meshes(scene: Scene) -> Iterator[Finding]:
    """Report elements that are not joined where they meet, and elements given twice.

    Elements with the same nodes are given twice; triangles only if they are turned the same way.
    """
    for name, nodes in scene.model.mechanism.nodes.items():
        if isinstance(nodes, DeformingNodes) and nodes.parts:
            points = scene.model.slaves[name].slave.points
            where = f"slave {name}"
            yield from _unjoined_pieces(where, points, nodes)
            # Elements with the same corners; for membranes only with the same orientation, as two
            # sheets that are sewn together may share the three corners of an end.
            for part in nodes.parts:
                corners = np.sort(part.elements, axis=1)
                if part.kind == "tri3":
                    turn = part.elements.argmin(axis=1)[:, None]
                    corners = np.take_along_axis(part.elements, (turn + np.arange(3)) % 3, axis=1)
                _, first_rows, count = np.unique(
                    corners, axis=0, return_index=True, return_counts=True
                )
                n_repeated = int((count - 1).sum())
                if n_repeated:
                    first = part.elements[first_rows[np.argmax(count > 1)]]
                    yield Finding(
                        "twice",
                        where,
                        f"{n_repeated} of its elements ({part.kind}) are given again, the first at "
                        f"{_point_text(points[first].mean(axis=0))}: they weigh and resist twice",
                        "Take them out of the mesh",
                    )


def _unjoined_pieces(where: str, points: FloatArray, nodes: DeformingNodes) -> Iterator[Finding]:
    """Report pieces of a mesh that lie face to face, edge to edge or end to end, but not joined.

    They have as many nodes at the same places as a face, an edge or an end. Pairs of nodes whose
    motions are prescribed do not count. Only the first two pieces are reported.
    """
    # The connected piece of each node, and the smallest dimension of the elements of each piece.
    node_pairs = [
        np.stack(
            [np.repeat(part.elements[:, 0], part.elements.shape[1]), part.elements.ravel()], axis=1
        )
        for part in nodes.parts
    ]
    first, second = np.concatenate(node_pairs).T.astype(np.int64)
    piece = np.asarray(groups_of(first, second, len(points)))
    dimension = np.full(piece.max() + 1, 3)
    for part in nodes.parts:
        np.minimum.at(dimension, piece[part.elements[:, 0]], DIMENSION[part.kind])
    if piece.max() == 0:
        return
    from scipy.spatial import cKDTree  # its import takes as long as that of numba

    # Pairs of nodes at the same place.
    rows = np.unique(np.concatenate([part.elements.ravel() for part in nodes.parts]))
    edges = [
        points[part.elements] - points[np.roll(part.elements, 1, axis=1)] for part in nodes.parts
    ]
    shortest = min(float(np.sqrt(np.square(edge).sum(axis=2)).min()) for edge in edges)
    pairs = cKDTree(points[rows]).query_pairs(_PLACE_TOL * shortest, output_type="ndarray")
    first, second = rows[pairs[:, 0]], rows[pairs[:, 1]]
    is_prescribed = np.asarray(nodes.held.all(axis=1))
    is_apart = (piece[first] != piece[second]) & ~(is_prescribed[first] & is_prescribed[second])
    first, second = first[is_apart], second[is_apart]
    both = np.sort(np.stack([piece[first], piece[second]], axis=1), axis=1)
    for first_piece, second_piece in np.unique(both, axis=0).tolist():
        rows = first[(both == [first_piece, second_piece]).all(axis=1)]
        if len(rows) >= min(dimension[first_piece], dimension[second_piece]):
            yield Finding(
                "torn",
                where,
                f"it is in pieces that share no node: {len(rows)} nodes of one lie where nodes of "
                f"another are, the first at {_point_text(points[rows[0]])}, and nothing holds them "
                "together",
                "Merge these nodes, or make a slave of each piece",
            )
            return


def _point_text(point: FloatArray) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"
