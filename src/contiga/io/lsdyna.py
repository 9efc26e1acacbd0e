"""LS-DYNA keyword decks: nodes, shells, solids, thickness and nodal mass by part.

Nodes and elements in the plain fixed format are read by lsdyna-mesh-reader. It does not end on
decks in the free or long format, and misreads elements with extra cards, so such decks are found
out first and read from their cards here; so are *PART, *SECTION_SHELL and *ELEMENT_MASS, which it
does not offer. Card layouts: LS-DYNA Keyword User's Manual, volume I.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError, MeshError
from contiga.io.lsdyna_cards import Block, Card, fields, read_blocks, real, whole
from contiga.io.lsdyna_parts import Parts, read_parts
from contiga.io.raw import Group, RawMesh
from contiga.io.skin import CellBlock
from contiga.records import FloatArray

SUFFIXES = (".k", ".key", ".dyn", ".dyna")

_NODE = (8, 16, 16, 16)
_ELEMENT = (8,) * 10
_ELEMENT_MASS = (8, 8, 16, 8)
_THICKNESSES = (16,) * 4
# More cards for each shell than the one with its nodes; the first holds thickness at its corners.
_SHELL_OPTIONS = {"THICKNESS": 1, "BETA": 1, "MCID": 1, "OFFSET": 1}
_SOLIDS = ("ELEMENT_SOLID", "ELEMENT_TSHELL")

_PLAIN_NUMBER = re.compile(r" *[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)? *")

Int64Array = NDArray[np.int64]


class _Table(NamedTuple):
    """Elements of one sort as they stand in the deck, up to ten nodes each, 0 where fewer."""

    part: Int64Array
    nodes: Int64Array
    thickness: FloatArray
    """(m, 4) at the corners, 0 where the element's own cards give none."""


def warm_up() -> None:
    """Load what the reader needs, before its time counts."""
    import lsdyna_mesh_reader  # noqa: F401


def read_lsdyna(path: Path) -> RawMesh:
    """Mesh of a keyword deck, with the files it includes; one group for each part with elements.

    Raises
    ------
    FileError
        Not a keyword deck, or an included file is missing.
    MeshError
        A card that cannot be read, an element of a node that is not there, or a kind of element
        that is not known here.
    """
    blocks = list(read_blocks(path))
    if not blocks:
        raise FileError("not an LS-DYNA keyword deck", where=str(path), allowed="a file with *NODE")
    _refuse_moved_nodes(blocks, path)
    read = _from_library(path) if _is_plain(blocks, path) else None
    if read is None or not _is_whole(read, blocks):
        read = _from_cards(blocks)
    node_ids, points, shells, solids = read
    node_ids, points = _without_repeats(node_ids, points, path)
    rows = _Rows(node_ids, str(path))
    parts = read_parts(blocks)
    cells, part_numbers, thickness = _cells(shells, solids, rows, parts)
    return RawMesh(
        points,
        tuple(cells),
        tuple(_groups(part_numbers, parts)),
        node_ids,
        tuple(thickness) if any(values is not None for values in thickness) else None,
        _mass(blocks, rows, len(points)),
    )


def _refuse_moved_nodes(blocks: Iterable[Block], path: Path) -> None:
    for block in blocks:
        if block.keyword == "NODE_TRANSFORM":
            raise FileError(
                "nodes are moved by *NODE_TRANSFORM, which is not carried out",
                where=str(path),
                remedy="Write the deck with the nodes where they are",
            )


def _is_whole(
    read: tuple[Int64Array, FloatArray, list[_Table], list[_Table]], blocks: Iterable[Block]
) -> bool:
    """Whether the library has seen every card: it passes by keywords in small letters."""
    ids, _, shells, solids = read
    found = {
        "NODE": len(ids),
        "ELEMENT_SHELL": sum(len(table.part) for table in shells),
        "ELEMENT_SOLID": sum(len(table.part) for table in solids),
    }
    cards = dict.fromkeys(found, 0)
    for block in blocks:
        if block.keyword in cards:
            cards[block.keyword] += len(block.cards)
    return cards == found


def _is_plain(blocks: Iterable[Block], path: Path) -> bool:
    """Whether lsdyna-mesh-reader can be trusted with the deck."""
    for block in blocks:
        if not block.keyword.startswith(("NODE", "ELEMENT_SHELL", "ELEMENT_SOLID")):
            continue
        if block.long or block.path != path or not block.cards:
            return False
        if block.keyword not in ("NODE", "ELEMENT_SHELL", "ELEMENT_SOLID"):
            return False
        plain = _is_plain_node if block.keyword == "NODE" else _is_plain_element
        if not all(plain(card.text, block.keyword) for card in block.cards):
            return False
    return True


def _is_plain_node(text: str, keyword: str) -> bool:
    numbers = (text[8:24], text[24:40], text[40:56])
    return text[:8].strip().isdecimal() and all(map(_PLAIN_NUMBER.fullmatch, numbers))


def _is_plain_element(text: str, keyword: str) -> bool:
    """Number, part and nodes there; of a shell no mid-side nodes, which the library leaves out."""
    found = [text[i : i + 8].strip() for i in range(0, 80, 8)]
    needed = 6 if keyword == "ELEMENT_SHELL" else 10
    return all(map(str.isdecimal, found[:needed])) and not any(f.strip("0") for f in found[needed:])


def _from_library(path: Path) -> tuple[Int64Array, FloatArray, list[_Table], list[_Table]]:
    from lsdyna_mesh_reader import Deck

    try:
        deck = Deck(path)
    except RuntimeError as error:
        raise FileError(f"cannot be read as an LS-DYNA deck: {error}", where=str(path)) from error

    def table(section: object, least: int) -> _Table:
        ids = np.asarray(section.node_ids, dtype=np.int64)  # type: ignore[attr-defined]
        starts = np.asarray(section.node_id_offsets, dtype=np.int64)  # type: ignore[attr-defined]
        sizes = np.diff(starts)
        nodes = np.zeros((len(sizes), max(least, int(sizes.max(initial=0)))), dtype=np.int64)
        nodes[np.arange(nodes.shape[1]) < sizes[:, None]] = ids
        part = np.asarray(section.pid, dtype=np.int64)  # type: ignore[attr-defined]
        return _Table(part, nodes, np.zeros((len(nodes), 4)))

    sections = deck.node_sections
    ids = [np.asarray(section.nid, dtype=np.int64) for section in sections]
    points = [np.asarray(section.coordinates, dtype=np.float64) for section in sections]
    return (
        np.concatenate([np.empty(0, dtype=np.int64), *ids]),
        np.concatenate([np.empty((0, 3)), *points]),
        [table(section, 8) for section in deck.element_shell_sections],
        [table(section, 10) for section in deck.element_solid_sections],
    )


def _from_cards(
    blocks: Iterable[Block],
) -> tuple[Int64Array, FloatArray, list[_Table], list[_Table]]:
    ids: list[int] = []
    points: list[list[float]] = []
    shells, solids = [], []
    for block in blocks:
        if block.keyword == "NODE":
            for card in block.cards:
                node, *xyz = fields(card, block, _NODE)
                if not node and not any(xyz):
                    continue
                ids.append(whole(node, block, card))
                points.append([real(value, block, card) for value in xyz])
        elif block.keyword.startswith("ELEMENT_SHELL"):
            shells.append(_shell_cards(block))
        elif block.keyword.startswith(_SOLIDS):
            solids.append(_solid_cards(block))
    array = np.array(points, dtype=np.float64).reshape(-1, 3)
    return np.array(ids, dtype=np.int64), array, shells, solids


def _shell_cards(block: Block) -> _Table:
    """*ELEMENT_SHELL with its options: eid, pid, n1 … n8, then cards the options add."""
    options = [word for word in block.keyword.split("_")[2:] if word]
    for word in options:
        if word not in _SHELL_OPTIONS:
            raise _unknown_element(block, [f"ELEMENT_SHELL_{name}" for name in _SHELL_OPTIONS])
    with_thickness = any(word in ("THICKNESS", "BETA", "MCID") for word in options)
    extra = int(with_thickness) + options.count("OFFSET")
    part, nodes, thickness = [], [], []
    cards = [card for card in block.cards if card.text.strip()]
    step = 1 + extra
    if len(cards) % step:
        raise MeshError(
            f"each shell takes {step} cards",
            where=block.where(cards[-1]),
            found=f"{len(cards)} cards",
        )
    for i in range(0, len(cards), step):
        numbers = [whole(field, block, cards[i]) for field in fields(cards[i], block, _ELEMENT)]
        part.append(numbers[1])
        nodes.append(numbers[2:])
        corners = [0.0] * 4
        if with_thickness:
            values = fields(cards[i + 1], block, _THICKNESSES)
            corners = [real(value, block, cards[i + 1]) for value in values]
        thickness.append(corners)
    return _table(part, nodes, thickness, 8)


def _solid_cards(block: Block) -> _Table:
    """*ELEMENT_SOLID: all on one card, or element and part on one and up to ten nodes on the next.

    The two-card form is told by its first card, which has no nodes.
    """
    if block.keyword not in _SOLIDS:
        raise _unknown_element(block, _SOLIDS)
    part, nodes = [], []
    cards = iter([card for card in block.cards if card.text.strip()])
    for card in cards:
        numbers = [whole(field, block, card) for field in fields(card, block, _ELEMENT)]
        part.append(numbers[1])
        if any(numbers[2:]):
            nodes.append([*numbers[2:], 0, 0])
            continue
        second = next(cards, None)
        if second is None:
            raise MeshError("the card with the element's nodes is missing", where=block.where(card))
        nodes.append([whole(field, block, second) for field in fields(second, block, _ELEMENT)])
    return _table(part, nodes, [[0.0] * 4] * len(part), 10)


def _table(
    part: list[int], nodes: list[list[int]], thickness: list[list[float]], width: int
) -> _Table:
    return _Table(
        np.array(part, dtype=np.int64),
        np.array(nodes, dtype=np.int64).reshape(-1, width),
        np.array(thickness, dtype=np.float64).reshape(-1, 4),
    )


def _unknown_element(block: Block, allowed: Iterable[str]) -> MeshError:
    return MeshError(
        "a kind of element that is not known here",
        where=block.where(block.cards[0] if block.cards else None),
        found="*" + block.keyword,
        allowed=", ".join("*" + name for name in allowed),
    )


def _without_repeats(
    ids: Int64Array, points: FloatArray, path: Path
) -> tuple[Int64Array, FloatArray]:
    """Nodes once each. A node given twice in the same place (included files) is no error."""
    _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
    if len(first) == len(ids):
        return ids, points
    moved = np.flatnonzero((points != points[first[inverse]]).any(axis=1))
    if len(moved):
        raise MeshError(
            "a node is given twice, in different places",
            where=str(path),
            found=f"node {ids[moved[0]]}",
            allowed="each node number once",
        )
    first.sort()
    return ids[first], points[first]


class _Rows:
    """Turns node numbers of the deck into rows of its points."""

    def __init__(self, ids: Int64Array, where: str) -> None:
        self.order = np.argsort(ids, kind="stable")
        self.sorted = ids[self.order]
        self.where = where

    def __call__(self, ids: Int64Array) -> Int64Array:
        if len(self.sorted) == 0:
            return np.zeros_like(ids)
        place = np.minimum(np.searchsorted(self.sorted, ids), len(self.sorted) - 1)
        unknown = self.sorted[place] != ids
        if unknown.any():
            raise MeshError(
                "an element or mass stands on a node that is not in the deck",
                where=self.where,
                found=f"node {ids[unknown][0]}",
                allowed="numbers given under *NODE",
            )
        rows: Int64Array = self.order[place]
        return rows


def _cells(
    shells: list[_Table], solids: list[_Table], rows: _Rows, parts: Parts
) -> tuple[list[CellBlock], list[Int64Array], list[FloatArray | None]]:
    """Blocks by kind, with the part number of each cell and the thickness at its nodes."""
    blocks: list[CellBlock] = []
    numbers: list[Int64Array] = []
    thickness: list[FloatArray | None] = []
    for table in shells:
        corners, middles = table.nodes[:, :4], table.nodes[:, 4:8]
        triangle = (corners[:, 3] == corners[:, 2]) | (corners[:, 3] == 0)
        quad8 = ~triangle & (middles > 0).all(axis=1)
        quad = ~triangle & ~quad8
        own = parts.shell_thickness(table.part)
        given = np.where(table.thickness > 0.0, table.thickness, own)
        for kind, mask, count in (
            ("triangle", triangle, 3),
            ("quad", quad, 4),
            ("quad8", quad8, 8),
        ):
            if not mask.any():
                continue
            blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
            numbers.append(table.part[mask])
            values = given[mask][:, :3] if count == 3 else given[mask]
            if count == 8:
                values = np.hstack([values, 0.5 * (values + np.roll(values, -1, axis=1))])
            thickness.append(values if (values > 0.0).any() else None)
    for table in solids:
        ten = (table.nodes[:, 8:10] > 0).all(axis=1)
        four = ~ten & (table.nodes[:, 4:8] == 0).all(axis=1)
        for kind, mask, count in (
            ("hexahedron", ~ten & ~four, 8),
            ("tetra", four, 4),
            ("tetra10", ten, 10),
        ):
            if mask.any():
                blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
                numbers.append(table.part[mask])
                thickness.append(None)
    return blocks, numbers, thickness


def _groups(part_numbers: list[Int64Array], parts: Parts) -> list[Group]:
    present = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *part_numbers]))
    return [
        Group(
            int(number),
            parts.titles.get(int(number)) or None,
            tuple(np.flatnonzero(numbers == number) for numbers in part_numbers),
        )
        for number in present
    ]


def _mass(blocks: Iterable[Block], rows: _Rows, count: int) -> FloatArray | None:
    """(n,) from *ELEMENT_MASS: eid, node, mass; None if the deck has none."""
    ids: list[int] = []
    values: list[float] = []
    last: tuple[Block, Card] | None = None
    for block in blocks:
        if block.keyword != "ELEMENT_MASS":
            continue
        for card in block.cards:
            if not card.text.strip():
                continue
            _, node, mass, _ = fields(card, block, _ELEMENT_MASS)
            ids.append(whole(node, block, card))
            values.append(real(mass, block, card))
            last = (block, card)
    if last is None:
        return None
    at = rows(np.array(ids, dtype=np.int64))
    return np.bincount(at, weights=np.array(values), minlength=count).astype(np.float64)
