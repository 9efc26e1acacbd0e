"""The instances of an Abaqus deck in one mesh, its sets as groups."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np

from contiga.errors import ContigaWarning, MeshError
from contiga.io.mesh.abaqus_scope import Label, Scope
from contiga.io.mesh.raw import Group, RawMesh
from contiga.slaves.skin import CellBlock

MAX_LISTED = 3
"""Largest number of missing members of a set that a warning names."""

Cells = dict[tuple[str, int], tuple[int, int]]
"""Block and row of each element with a surface, by instance and number."""


def assemble_mesh(instances: Mapping[str, Scope], names: Mapping[str, str], where: str) -> RawMesh:
    """Return nodes and cells of all instances, in the file's order, with groups.

    Groups are the instances, if there are several, then the sets of elements, then those of nodes;
    members that do not exist, and elements without a surface, are left out of them. Node numbers
    of several instances may repeat.

    Parameters
    ----------
    instances : by name in lower case; "" is the deck itself
    names : of the instances as they are written
    where : for messages

    Raises
    ------
    MeshError
        An element names a node that does not exist.

    Warns
    -----
    ContigaWarning
        A set names nodes or elements that do not exist.
    """
    row_of: dict[tuple[str, int], int] = {}
    points: list[tuple[float, float, float]] = []
    for name, scope in instances.items():
        for number, position in scope.nodes.items():
            row_of[name, number] = len(points)
            points.append(position)
    blocks, cells = _blocks(instances, row_of)
    groups: list[Group] = []
    if len(names) > 1:
        for name, title in names.items():
            members = [cells[name, n] for n in instances[name].elements if (name, n) in cells]
            groups.append(Group(None, title, _rows(members, len(blocks))))
    missing: list[str] = []
    for set_name, labels in _sets(instances, names, of_nodes=False).items():
        members = [cells[label] for label in labels if label in cells]
        groups.append(Group(None, set_name, _rows(members, len(blocks))))
        unknown = [n for i, n in labels if n not in instances[i].elements]
        missing += count_message(f"*ELSET {set_name}", unknown)
    for set_name, labels in _sets(instances, names, of_nodes=True).items():
        rows = sorted({row_of[label] for label in labels if label in row_of})
        groups.append(Group(None, set_name, None, np.array(rows, dtype=np.int64)))
        unknown = [n for i, n in labels if (i, n) not in row_of]
        missing += count_message(f"*NSET {set_name}", unknown)
    if missing:
        text = "; ".join(missing)
        warnings.warn(f"{where}: members of sets are not there: {text}", ContigaWarning, 2)
    ids = np.array([number for _, number in row_of], dtype=np.int64)
    return RawMesh(np.array(points, dtype=np.float64).reshape(-1, 3), blocks, tuple(groups), ids)


def _blocks(
    instances: Mapping[str, Scope], row_of: Mapping[tuple[str, int], int]
) -> tuple[tuple[CellBlock, ...], Cells]:
    """Return blocks of consecutive cells of one kind, and the place (block, row) of each cell.

    Elements without a surface are skipped, also between cells of one kind. Places and `row_of`,
    the rows of the nodes, are by instance and number; a missing node raises a `MeshError`.
    """
    runs: list[tuple[str, list[list[int]]]] = []
    cells: Cells = {}
    for name, scope in instances.items():
        for number, element in scope.elements.items():
            if not element.kind:
                continue
            if not runs or runs[-1][0] != element.kind:
                runs.append((element.kind, []))
            run = runs[-1][1]
            cells[name, number] = len(runs) - 1, len(run)
            try:
                run.append([row_of[name, node] for node in element.nodes])
            except KeyError as error:
                raise MeshError(
                    f"element {number} names a node that is not there",
                    where=element.where,
                    found=error.args[0][1],
                    allowed="numbers given under *NODE",
                ) from error
    return tuple(CellBlock(kind, np.array(run, dtype=np.int64)) for kind, run in runs), cells


def _rows(members: list[tuple[int, int]], n_blocks: int) -> tuple[np.ndarray, ...]:
    """Return the rows of some cells in each block, ascending."""
    rows: list[list[int]] = [[] for _ in range(n_blocks)]
    for block, row in members:
        rows[block].append(row)
    return tuple(np.array(sorted(set(cells)), dtype=np.int64) for cells in rows)


def _sets(
    instances: Mapping[str, Scope], names: Mapping[str, str], *, of_nodes: bool
) -> dict[str, list[Label]]:
    """Return the members of all sets, with their instances, by their names in the mesh.

    They are sets of nodes if `of_nodes`, else of elements.
    The name of a set of an instance begins with that instance if there are several, or if an
    earlier set has the same name in any case. Sets of one name add up.
    """
    sets: dict[str, list[Label]] = {}
    used_names: set[str] = set()
    for name, scope in instances.items():
        for each in (scope.node_sets if of_nodes else scope.element_sets).values():
            is_ambiguous = len(names) > 1 or each.name.casefold() in used_names
            full_name = f"{names[name]}.{each.name}" if name and is_ambiguous else each.name
            used_names.add(full_name.casefold())
            labels = [Label(label.instance or name, label.number) for label in each.labels]
            sets.setdefault(full_name, []).extend(labels)
    return sets


def count_message(label: str, numbers: list[int]) -> list[str]:
    """Return a list of one message: label, count and the first `MAX_LISTED` of `numbers`.

    Without numbers the list is empty.
    """
    if not numbers:
        return []
    sample = ", ".join(map(str, numbers[:MAX_LISTED])) + ", …" * (len(numbers) > MAX_LISTED)
    return [f"{label}: {len(numbers)} ({sample})"]
