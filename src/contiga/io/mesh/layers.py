"""Layers of a mesh of solids: its skin, and the skins below it once cells are removed."""

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
    """Return the cells that remain after removing `layer` − 1 layers; for 1 the blocks as they are.

    A layer is all cells with a node on the skin of the remaining cells; cells that are not solids
    are in the first. `where` is the file, for the message.

    Raises
    ------
    MeshError
        No cell remains; the message says how many layers there are.
    """
    for n_removed in range(1, layer):
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
                allowed=f"1 to {n_removed}",
            )
    return blocks


def with_middles(blocks: list[CellBlock], nodes: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of nodes with the mid-side nodes between two of them, and face centres.

    A centre node is added if all corners of its face are in the mask. Sets in files often contain
    corners alone; the facets of a second-order mesh are split through its mid-side nodes, so that
    without them the surface would have holes.
    """
    extended = nodes.copy()
    for block in blocks:
        faces: list[tuple[tuple[int, ...], int]] = []
        """Nodes of each face of a cell, and its number of corners."""
        if block.kind in SOLIDS:
            solid = SOLIDS[block.kind]
            faces = list(zip(solid.faces, map(len, solid.corner_faces), strict=True))
        elif block.kind in SHELLS:
            faces = [(tuple(range(N_NODES[block.kind])), SHELLS[block.kind])]
        for face, n_corners in faces:
            if len(face) == n_corners:
                continue
            face_nodes = block.nodes[:, list(face)]
            has_corner = nodes[face_nodes[:, :n_corners]]
            for k in range(n_corners):
                has_both = has_corner[:, k] & has_corner[:, (k + 1) % n_corners]
                extended[face_nodes[has_both, n_corners + k]] = True
            extended[face_nodes[has_corner.all(axis=1), 2 * n_corners :]] = True
    return extended
