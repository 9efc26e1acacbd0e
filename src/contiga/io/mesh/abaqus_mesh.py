"""The instances of an Abaqus deck in one mesh, its sets as groups."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping

import numpy as np

from contiga.errors import ContigaWarning, MeshError
from contiga.io.mesh.abaqus_scope import Element, Label, Scope
from contiga.io.mesh.raw import Group, RawMesh
from contiga.slaves.skin import CellBlock

SHOWN = 3
"""Largest number of missing members of a set that a warning names."""

Cells = dict[tuple[str, int], tuple[int, int]]
"""Block and row of each element with a surface, by instance and number."""


def assembled(instances: Mapping[str, Scope], names: Mapping[str, str], where: str) -> RawMesh:
    """Return nodes and cells of all instances, in the file's order.

    Parameters
    ----------
    instances : by name in lower case; "" is the deck itself
    names : of the instances as they are written
    where : for messages

    Raises
    ------
    MeshError
        An element names a node that is not there.

    Warns
    -----
    ContigaWarning
        A set names nodes or elements that are not there.
    """
    row_of: dict[tuple[str, int], int] = {}
    points: list[tuple[float, float, float]] = []
    for name, scope in instances.items():
        for number, place in scope.nodes.items():
            row_of[name, number] = len(points)
            points.append(place)
    blocks, cells = _blocks(instances, row_of)
    groups = [*_parts(instances, names, blocks, cells)]
    missing: list[str] = []
    for set_name, labels in _sets(instances, names, nodes=False).items():
        known = [cells[label] for label in labels if label in cells]
        groups.append(Group(None, set_name, _rows(known, len(blocks))))
        unknown = [n for i, n in labels if n not in instances[i].elements]
        missing += count_message(f"*ELSET {set_name}", unknown)
    for set_name, labels in _sets(instances, names, nodes=True).items():
        rows = sorted({row_of[label] for label in labels if label in row_of})
        groups.append(Group(None, set_name, None, np.array(rows, dtype=np.int64)))
        missing += count_message(
            f"*NSET {set_name}", [n for i, n in labels if (i, n) not in row_of]
        )
    if missing:
        text = "; ".join(missing)
        warnings.warn(f"{where}: members of sets are not there: {text}", ContigaWarning, 2)
    ids = np.array([number for _, number in row_of], dtype=np.int64)
    return RawMesh(np.array(points, dtype=np.float64).reshape(-1, 3), blocks, tuple(groups), ids)


def _blocks(
    instances: Mapping[str, Scope], row_of: Mapping[tuple[str, int], int]
) -> tuple[tuple[CellBlock, ...], Cells]:
    """Collect consecutive cells of one kind into blocks."""
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
            run.append(_nodes(name, number, element, row_of))
    return tuple(CellBlock(kind, np.array(run, dtype=np.int64)) for kind, run in runs), cells


def _nodes(
    instance: str, number: int, element: Element, row_of: Mapping[tuple[str, int], int]
) -> list[int]:
    try:
        return [row_of[instance, node] for node in element.nodes]
    except KeyError as error:
        raise MeshError(
            f"element {number} names a node that is not there",
            where=element.where,
            found=error.args[0][1],
            allowed="numbers given under *NODE",
        ) from error


def _parts(
    instances: Mapping[str, Scope],
    names: Mapping[str, str],
    blocks: tuple[CellBlock, ...],
    cells: Cells,
) -> Iterator[Group]:
    """Yield a group for each instance, if there are several."""
    if len(names) < 2:
        return
    for name, written in names.items():
        known = [cells[name, n] for n in instances[name].elements if (name, n) in cells]
        yield Group(None, written, _rows(known, len(blocks)))


def _rows(known: list[tuple[int, int]], n_blocks: int) -> tuple[np.ndarray, ...]:
    """Return the rows of some cells in each block, ascending."""
    rows: list[list[int]] = [[] for _ in range(n_blocks)]
    for block, row in known:
        rows[block].append(row)
    return tuple(np.array(sorted(set(cells)), dtype=np.int64) for cells in rows)


def _sets(
    instances: Mapping[str, Scope], names: Mapping[str, str], *, nodes: bool
) -> dict[str, list[Label]]:
    """Return the members of all sets by their names in the mesh.

    With that of their instance where there are several, or another scope has a set so named.
    """
    sets: dict[str, list[Label]] = {}
    taken: set[str] = set()
    for name, scope in instances.items():
        for one in (scope.node_sets if nodes else scope.element_sets).values():
            shared = len(names) > 1 or one.name.casefold() in taken
            full = f"{names[name]}.{one.name}" if name and shared else one.name
            taken.add(full.casefold())
            labels = [Label(label.instance or name, label.number) for label in one.labels]
            sets.setdefault(full, []).extend(labels)
    return sets


def count_message(what: str, numbers: list[int]) -> list[str]:
    """Return the number of missing things, and some of them."""
    if not numbers:
        return []
    some = ", ".join(map(str, numbers[:SHOWN])) + (", …" if len(numbers) > SHOWN else "")
    return [f"{what}: {len(numbers)} ({some})"]
