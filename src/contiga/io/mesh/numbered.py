"""Nodes and elements by the numbers a deck gives them, as rows of a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.io.mesh.raw import Group, RawMesh
from contiga.records import FloatArray
from contiga.slaves.skin import CellBlock

Int64Array = NDArray[np.int64]


class Rows:
    """Turns node numbers of a deck into rows of its points."""

    def __init__(self, ids: Int64Array, where: str, allowed: str) -> None:
        self.order = np.argsort(ids, kind="stable")
        self.sorted = ids[self.order]
        self.where = where
        self.allowed = allowed

    def known(self, ids: Int64Array) -> NDArray[np.bool_]:
        """Which of the numbers are there."""
        if len(self.sorted) == 0:
            return np.zeros(len(ids), dtype=bool)
        place = np.minimum(np.searchsorted(self.sorted, ids), len(self.sorted) - 1)
        return np.asarray(self.sorted[place] == ids)

    def __call__(self, ids: Int64Array, where: str | None = None) -> Int64Array:
        """Rows of numbers of any shape.

        Raises
        ------
        MeshError
            A number that is not there.
        """
        if len(self.sorted) == 0 and ids.size == 0:
            return np.zeros_like(ids)
        flat = ids.ravel()
        unknown = ~self.known(flat)
        if unknown.any():
            raise MeshError(
                "an element or mass stands on a node that is not in the deck",
                where=where or self.where,
                found=f"node {flat[unknown][0]}",
                allowed=self.allowed,
            )
        rows: Int64Array = self.order[np.searchsorted(self.sorted, ids)]
        return rows


class Elements(NamedTuple):
    """Elements of one kind that stand together in a deck."""

    kind: str
    """As VTK and meshio name it: "tetra10", "quad" …"""
    ids: list[int]
    nodes: list[list[int]]
    """Numbers of their nodes, in VTK's order."""
    where: str
    """File and line, for messages."""


class Numbered(NamedTuple):
    """A mesh by numbers."""

    ids: list[int]
    """Of the nodes, each once."""
    points: list[tuple[float, float, float]]
    elements: list[Elements]


def raw_mesh(
    mesh: Numbered,
    cell_groups: Sequence[tuple[int | None, str | None, set[int]]],
    node_groups: Mapping[str, list[int]],
    where: str,
    allowed: str,
) -> RawMesh:
    """A mesh with groups of elements (number, name, their numbers) and of nodes (by name).

    Raises
    ------
    MeshError
        An element names a node that is not there.
    """
    ids = np.array(mesh.ids, dtype=np.int64)
    rows = Rows(ids, where, allowed)
    blocks = tuple(
        CellBlock(each.kind, rows(np.array(each.nodes, dtype=np.int64), each.where))
        for each in mesh.elements
    )
    numbers = [np.array(each.ids, dtype=np.int64) for each in mesh.elements]
    groups = [
        Group(number, name, tuple(np.flatnonzero(np.isin(own, list(held))) for own in numbers))
        for number, name, held in cell_groups
    ]
    groups += [
        Group(None, name, None, rows(np.array(sorted(set(held)), dtype=np.int64)))
        for name, held in node_groups.items()
    ]
    points: FloatArray = np.array(mesh.points, dtype=np.float64).reshape(-1, 3)
    return RawMesh(points, blocks, tuple(groups), ids)
