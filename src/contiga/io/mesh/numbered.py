"""Nodes and elements by their numbers in a deck, as rows of a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.io.mesh.raw import Group, RawMesh
from contiga.records import FloatArray
from contiga.slaves.skin import CellBlock, Int64Array


class NodeRows:
    """Map from node numbers of a deck to rows of its points.

    Parameters
    ----------
    ids : (n,) number of each point
    where : the deck, for messages
    allowed : place where the deck has its node numbers, for messages
    """

    def __init__(self, ids: Int64Array, where: str, allowed: str) -> None:
        self.order = np.argsort(ids, kind="stable")
        self.sorted_ids = ids[self.order]
        self.where = where
        self.allowed = allowed

    def contains(self, ids: Int64Array) -> NDArray[np.bool_]:
        """Return a mask (n,) of the numbers `ids` that exist."""
        if len(self.sorted_ids) == 0:
            return np.zeros(len(ids), dtype=bool)
        places = np.minimum(np.searchsorted(self.sorted_ids, ids), len(self.sorted_ids) - 1)
        return np.asarray(self.sorted_ids[places] == ids)

    def __call__(self, ids: Int64Array, where: Sequence[str] = ()) -> Int64Array:
        """Return the rows of numbers `ids` of any shape, in that shape.

        `where` has file and line of each entry along the first axis, for the message; if empty,
        the deck as a whole is named. Of a number that several points have, the first row counts.

        Raises
        ------
        MeshError
            A number does not exist.
        """
        if len(self.sorted_ids) == 0 and ids.size == 0:
            return np.zeros_like(ids)
        flat = ids.ravel()
        unknown = np.flatnonzero(~self.contains(flat))
        if len(unknown):
            raise MeshError(
                "an element or mass stands on a node that is not in the deck",
                where=where[unknown[0] * len(where) // len(flat)] if where else self.where,
                found=f"node {flat[unknown[0]]}",
                allowed=self.allowed,
            )
        rows: Int64Array = self.order[np.searchsorted(self.sorted_ids, ids)]
        return rows


def rows_of(mesh: RawMesh, numbers: Sequence[int], where: str) -> Int64Array:
    """Return the rows (k,) of the points of a mesh with these numbers in its file.

    Of a number that several nodes have, the first row counts.

    Raises
    ------
    MeshError
        No node has one of the numbers, or the file does not number its nodes.
    """
    if mesh.node_ids is None:
        raise MeshError(
            "does not number its nodes",
            where=where,
            found=f"node {numbers[0]}",
            allowed="nodes of an LS-DYNA, Abaqus or Nastran deck",
            remedy="Say where the nodes are, by a box or plane",
        )
    ids = np.array(numbers, dtype=np.int64)
    rows = NodeRows(mesh.node_ids, where, "")
    unknown = ids[~rows.contains(ids)]
    if len(unknown):
        raise MeshError("no node has this number", where=where, found=int(unknown[0]))
    return rows(ids)


class Elements(NamedTuple):
    """All elements of one kind of a deck."""

    kind: str
    """Name of the kind in VTK and meshio: "tetra10", "quad" …"""
    nodes: list[list[int]]
    """Numbers of their nodes, in VTK's order."""
    properties: list[int]
    """Number of the property or part of each element; each number becomes a group."""
    where: list[str]
    """File and line of each, for messages."""


def raw_mesh(
    positions: Mapping[int, tuple[float, float, float]],
    elements: Sequence[Elements],
    where: str,
    allowed: str,
) -> RawMesh:
    """Return a mesh of nodes by number, with a group for each property of its elements.

    Groups are in the order of their numbers, without names; blocks in the order of `elements`.

    Parameters
    ----------
    positions : coordinates by the number of the node; their order is that of the points
    elements : the elements of the deck, one item for each kind
    where : the deck, for messages about elements without a place of their own
    allowed : where the deck has its node numbers, such as "numbers given by GRID"; for messages

    Raises
    ------
    MeshError
        An element names a node that does not exist.
    """
    ids = np.array(list(positions), dtype=np.int64)
    rows = NodeRows(ids, where, allowed)
    blocks = tuple(
        CellBlock(each.kind, rows(np.array(each.nodes, dtype=np.int64), each.where))
        for each in elements
    )
    points: FloatArray = np.array(list(positions.values()), dtype=np.float64).reshape(-1, 3)

    # Each block is sorted once by property; its groups are then consecutive pieces.
    owners = [np.array(each.properties, dtype=np.int64) for each in elements]
    numbers = np.unique(np.concatenate(owners)) if owners else np.zeros(0, dtype=np.int64)
    pieces = []
    for properties in owners:
        order = np.argsort(properties, kind="stable")
        starts = np.searchsorted(properties[order], numbers)
        pieces.append(np.split(order, starts)[1:])
    groups = [
        Group(number, None, tuple(cells[k] for cells in pieces))
        for k, number in enumerate(numbers.tolist())
    ]
    return RawMesh(points, blocks, tuple(groups), ids)
