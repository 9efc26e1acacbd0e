"""Layers of a mesh of solids: its skin, and the skins below after removing cells."""

from __future__ import annotations

from typing import Literal

import numpy as np

from contiga.errors import MeshError
from contiga.records import FloatArray
from contiga.slaves.cells import N_NODES, SHELLS, SOLIDS
from contiga.slaves.skin import CellBlock, skin

Layer = Literal["skin", "all"] | int


def check_layer(layer: object) -> None:
    """Refuse an invalid layer.

    Raises
    ------
    MeshError
        Neither "skin" nor "all" nor a whole number from 1.
    """
    if layer in ("skin", "all"):
        return
    if not isinstance(layer, int) or isinstance(layer, bool) or layer < 1:
        raise MeshError(
            "is not a layer",
            where="layer",
            found=layer,
            allowed='"skin", "all", or a whole number from 1, which is the skin',
        )


def peeled(points: FloatArray, blocks: list[CellBlock], layer: int, where: str) -> list[CellBlock]:
    """Return the cells that remain after removing `layer` − 1 layers.

    A layer is all cells with a node on the skin of what is there; shells are of the first.

    Raises
    ------
    MeshError
        Nothing is left; the message says how many layers there are.
    """
    for taken in range(1, layer):
        outside = np.zeros(len(points), dtype=bool)
        outside[skin(points, blocks)] = True
        blocks = [
            CellBlock(block.kind, block.nodes[~outside[block.nodes].any(axis=1)])
            for block in blocks
            if block.kind in SOLIDS
        ]
        if not sum(len(block.nodes) for block in blocks):
            raise MeshError(
                "the mesh has no such layer below its skin",
                where=f"{where}, layer",
                found=layer,
                allowed=f"1 to {taken}",
            )
    return blocks


def with_middles(blocks: list[CellBlock], nodes: np.ndarray) -> np.ndarray:
    """Add to a mask of nodes the mid-side nodes between them, and those of whole faces.

    Sets in files often hold corners alone, without which the facets of a second-order mesh, which
    are split through its middles, would have holes.
    """
    full = nodes.copy()
    for block in blocks:
        for face, corners in _faces(block.kind):
            if len(face) == corners:
                continue
            of_face = block.nodes[:, list(face)]
            chosen = nodes[of_face[:, :corners]]
            for k in range(corners):
                both = chosen[:, k] & chosen[:, (k + 1) % corners]
                full[of_face[both, corners + k]] = True
            full[of_face[chosen.all(axis=1), 2 * corners :]] = True
    return full


def _faces(kind: str) -> list[tuple[tuple[int, ...], int]]:
    """Return the nodes of each face of a kind of cell, and its number of corners."""
    if kind in SOLIDS:
        solid = SOLIDS[kind]
        corners = [len(face) for face in solid.corner_faces]
        return list(zip(solid.faces, corners, strict=True))
    return [(tuple(range(N_NODES[kind])), SHELLS[kind])] if kind in SHELLS else []
