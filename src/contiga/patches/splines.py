"""Spline patches as the surface of a slave: the patches, their joints and its nodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.patches.basis import Patch
from contiga.patches.net import Net, edge_name, join
from contiga.patches.nodes import SurfaceNodes, side_of, surface_nodes
from contiga.patches.pieces import EDGES
from contiga.records import FloatArray, IntArray


class Splines(NamedTuple):
    """Patches that are one surface."""

    patches: tuple[Patch, ...]
    net: Net
    nodes: SurfaceNodes
    """Points of the surface at which contact acts."""

    @classmethod
    def of(cls, patches: Patch | Iterable[Patch]) -> Splines:
        """Join one patch or several, with the default tolerance and nodes.

        Raises the errors of `contiga.patches.net.join`.
        """
        sequence: Any = (patches,) if hasattr(patches, "knots") else patches
        surfaces = tuple(sequence)
        net = join(surfaces)
        return cls(surfaces, net, surface_nodes(net))

    @property
    def points(self) -> FloatArray:
        """Nodes (n, 3) at rest."""
        return self.nodes.points(self.net.points)

    def transformed(self, matrix: FloatArray) -> Splines:
        """Return the patches moved by a (4, 4) matrix, joined anew.

        Parameters, the order of nodes and the names of edges stay, so that a reflection has the
        normals on the other side.
        """
        patches: Sequence[Any] = self.patches
        moved = [patch.transformed(matrix) for patch in patches]
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            moved = [patch.flipped() for patch in moved]  # `transformed` has reversed u
        return Splines.of(moved)

    def edge(self, name: str, patch: int = 0) -> IntArray:
        """Return the nodes on an edge of a patch, ascending.

        Raises
        ------
        InputError
            There is no such edge or patch.
        """
        self.net.edge(edge_name(name), patch)  # checks both
        sides = [
            side_of(grid, name)
            for piece, grid in zip(self.net.pieces, self.nodes.grids, strict=True)
            if piece.patch == patch and name in piece.ends
        ]
        return np.unique(np.concatenate(sides)).astype(np.int32)

    def edges_within(self, chosen: NDArray[np.bool_]) -> list[tuple[int, str]]:
        """Return (patch, name) of the edges all of whose nodes are in the mask `chosen` (n,)."""
        return [
            (patch, name)
            for patch in range(len(self.patches))
            for name in EDGES
            if chosen[self.edge(name, patch)].all()
        ]
