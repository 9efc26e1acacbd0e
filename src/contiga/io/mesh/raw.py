"""A mesh in the form of its file, before it becomes a slave; selection of parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.io.naming import PartKeys, as_keys, closest, listed
from contiga.records import FloatArray
from contiga.slaves.skin import CellBlock
from contiga.slaves.slave import MeshPart


class Group(NamedTuple):
    """Cells or nodes under one name or number of the file."""

    id: int | None
    name: str | None
    cells: tuple[NDArray[Any], ...] | None
    """Rows of the cells in each block of the mesh; None for a set of nodes."""
    nodes: NDArray[Any] | None = None
    """Rows of the points; None for a set of cells."""


class RawMesh(NamedTuple):
    """The result of a reader."""

    points: FloatArray
    blocks: tuple[CellBlock, ...] = ()
    groups: tuple[Group, ...] = ()
    node_ids: NDArray[Any] | None = None
    """(n,) node numbers of the file, if it has any."""
    thickness: tuple[FloatArray | None, ...] | None = None
    """Shell thickness (m, k) at the cells' nodes for each block, None if it has none."""
    mass: FloatArray | None = None
    """(n,) nodal mass."""
    unit: str | None = None
    """Unit of the lengths, if the file gives one."""


class Selection(NamedTuple):
    """Selected cells and nodes."""

    cells: tuple[NDArray[np.bool_], ...]
    """Masks of the cells of each block."""
    nodes: NDArray[np.bool_] | None
    """Mask (n,) of the points, if sets of nodes were selected; with nodes of selected cells."""


def part_of(group: Group, blocks: Sequence[CellBlock]) -> MeshPart:
    """Return number and name of a group with its counts of cells and of different nodes.

    A set of nodes has 0 cells.
    """
    if group.cells is None:
        assert group.nodes is not None
        return MeshPart(group.id, group.name, 0, len(np.unique(group.nodes)))
    nodes = [block.nodes[rows].ravel() for block, rows in zip(blocks, group.cells, strict=True)]
    n_nodes = len(np.unique(np.concatenate(nodes))) if nodes else 0
    return MeshPart(group.id, group.name, sum(len(rows) for rows in group.cells), n_nodes)


def select(mesh: RawMesh, keys: PartKeys | None, where: str) -> Selection:
    """Return cells and nodes of all parts `keys` together (of the whole mesh if it is None).

    A key is the name of a group as the file writes it (in any case if none matches exactly), or
    else its number; it selects all groups that match. If only sets of nodes are named, all cells
    stay and the nodes are restricted; with cells too, the nodes of these are added.

    Raises
    ------
    MeshError
        A key matches no group; the message lists the groups.
    """
    if keys is None:
        return Selection(tuple(np.ones(len(b.nodes), dtype=bool) for b in mesh.blocks), None)
    groups = [group for key in as_keys(keys) for group in _matching_groups(mesh.groups, key, where)]
    cell_sets = [group.cells for group in groups if group.cells is not None]
    node_sets = [group.nodes for group in groups if group.nodes is not None]
    masks = []
    for i, block in enumerate(mesh.blocks):
        mask = np.full(len(block.nodes), not cell_sets)
        for cells in cell_sets:
            mask[cells[i]] = True
        masks.append(mask)
    if not node_sets:
        return Selection(tuple(masks), None)
    nodes = np.zeros(len(mesh.points), dtype=bool)
    nodes[np.concatenate(node_sets)] = True
    for block, mask in zip(mesh.blocks, masks, strict=True):
        if cell_sets:
            nodes[block.nodes[mask]] = True
    return Selection(tuple(masks), nodes)


def nodes_of(mesh: RawMesh, key: str | int, where: str) -> NDArray[np.bool_]:
    """Return a mask (n,) of the nodes of a set, part or group, with those of its cells.

    Raises
    ------
    MeshError
        As `select`.
    """
    nodes = np.zeros(len(mesh.points), dtype=bool)
    for group in _matching_groups(mesh.groups, key, where):
        if group.nodes is not None:
            nodes[group.nodes] = True
        for block, rows in zip(mesh.blocks, group.cells or (), strict=False):
            nodes[block.nodes[rows]] = True
    return nodes


def cells_of(mesh: RawMesh, key: str | int, where: str) -> dict[str, NDArray[Any]]:
    """Return the cells of a part, set or group: rows (m, k) of the points, by kind of cell.

    A set of nodes has the cells with all nodes in it. A kind that the mesh has is there with m = 0
    if the group has none of it.

    Raises
    ------
    MeshError
        As `select`.
    """
    cells: dict[str, list[NDArray[Any]]] = {}
    for group in _matching_groups(mesh.groups, key, where):
        for i, block in enumerate(mesh.blocks):
            if group.cells is not None:
                rows = block.nodes[group.cells[i]]
            else:
                assert group.nodes is not None
                rows = block.nodes[np.isin(block.nodes, group.nodes).all(axis=1)]
            cells.setdefault(block.kind, []).append(rows)
    return {kind: np.concatenate(rows) for kind, rows in cells.items()}


def _matching_groups(groups: Sequence[Group], key: str | int, where: str) -> list[Group]:
    """Return the groups named `key`; if none, those in any case, and if none, by their number.

    If there are none either, a `MeshError` lists the groups.
    """
    text = str(key).strip()
    matching = [group for group in groups if group.name == text]
    if not matching:
        folded = text.casefold()
        matching = [g for g in groups if g.name is not None and g.name.casefold() == folded]
    if not matching:
        matching = [group for group in groups if group.id is not None and str(group.id) == text]
    if matching:
        return matching
    labels = [MeshPart(group.id, group.name, 0, 0).label for group in groups]
    raise MeshError(
        "no part, set or group of that name or number",
        where=where,
        found=key,
        allowed=listed(labels) or "nothing: the file names no parts",
        remedy=closest(key, [group.name for group in groups if group.name is not None]),
    )
