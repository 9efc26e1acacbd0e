"""LS-DYNA keyword decks: nodes, shells, solids, thickness and nodal mass by part.

Nodes and elements in the plain fixed format are read column by column, others card by card. Card
layouts: LS-DYNA Keyword User's Manual, volume I.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import ContigaWarning, FileError, MeshError
from contiga.io.mesh.lsdyna_cards import Block, Layout, Row, layout, read_blocks, row_of
from contiga.io.mesh.lsdyna_parts import Parts, read_parts
from contiga.io.mesh.lsdyna_sets import read_sets, set_name
from contiga.io.mesh.lsdyna_ties import tied_nodes
from contiga.io.mesh.numbered import Rows
from contiga.io.mesh.raw import Group, RawMesh
from contiga.records import FloatArray
from contiga.slaves.skin import CellBlock, Int64Array

SUFFIXES = (".k", ".key", ".dyn", ".dyna")

_NODE = layout("NID:8 X:16 Y:16 Z:16 TC:8 RC:8")
_ELEMENT = layout("~EID PID N1 N2 N3 N4 N5 N6 N7 N8", 8)
_NODES = "N1 N2 N3 N4 N5 N6 N7 N8"
_TEN_NODES = layout(f"{_NODES} N9 N10", 8)
_MASS = layout("~EID NID MASS:16 ~PID", 8)
_MASS_OF_PART = layout("PID ADDMASS:16 FINMASS:16 LCID MWD", 8)
_THICKNESSES = layout("THIC1 THIC2 THIC3 THIC4 BETA", 16)
_OFFSET = layout("OFFSET", 16)
# More cards for each shell than the one with its nodes; the first holds thickness at its corners.
_SHELL_OPTIONS = ("THICKNESS", "BETA", "MCID", "OFFSET")
_SOLIDS = ("ELEMENT_SOLID", "ELEMENT_TSHELL")

_PLAIN_NUMBER = re.compile(r" *[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)? *", re.ASCII)
_PLAIN_COUNT = re.compile(r" *\d+ *", re.ASCII)


class _Table(NamedTuple):
    """Elements of one kind in the deck, up to ten nodes each, 0 for missing ones."""

    part: Int64Array
    nodes: Int64Array
    thickness: FloatArray
    """(m, 4) thickness at the corners, 0 if the element's own cards give none."""


def read_lsdyna(path: Path) -> RawMesh:
    """Return the mesh of a keyword deck with its included files; a group for each part.

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
    node_ids, points, shells, solids = _nodes_and_elements(blocks)
    node_ids, points = _without_repeats(node_ids, points, blocks)
    rows = Rows(node_ids, str(path), "numbers given under *NODE")
    parts = read_parts(blocks, _warn_of_parts)
    cells, part_numbers, thickness = _cells(shells, solids, rows, parts)
    return RawMesh(
        points,
        tuple(cells),
        (*_groups(part_numbers, parts), *_sets(blocks, rows)),
        node_ids,
        tuple(thickness) if any(values is not None for values in thickness) else None,
        _mass(blocks, rows, len(points)),
    )


def _warn_of_parts(block: Block, why: str) -> None:
    warnings.warn(
        f"{block.where()}, line {block.line}: {why}: titles and thickness it gives are left out",
        ContigaWarning,
        stacklevel=2,
    )


def _refuse_moved_nodes(blocks: Iterable[Block], path: Path) -> None:
    for block in blocks:
        if block.keyword == "NODE_TRANSFORM":
            raise FileError(
                "nodes are moved by *NODE_TRANSFORM, which is not carried out",
                where=str(path),
                remedy="Write the deck with the nodes where they are",
            )


def _nodes_and_elements(
    blocks: Iterable[Block],
) -> tuple[Int64Array, FloatArray, list[_Table], list[_Table]]:
    ids, points = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))]
    shells, solids = [], []
    for block in blocks:
        if block.keyword == "NODE":
            numbers, places = _node_columns(block) or _node_cards(block)
            ids.append(numbers)
            points.append(places)
        elif block.keyword.startswith("ELEMENT_SHELL"):
            shells.append(_element_columns(block) or _shell_cards(block))
        elif block.keyword.startswith(_SOLIDS):
            solids.append(_element_columns(block) or _solid_cards(block))
    return np.concatenate(ids), np.concatenate(points), shells, solids


def _node_columns(block: Block) -> tuple[Int64Array, FloatArray] | None:
    """Return numbers and places of nodes in the plain fixed format; None for other formats."""
    if block.long or not all(_is_plain_node(card.text) for card in block.cards):
        return None
    table = _characters(block, _width(_NODE))
    places = [_column(table, start, 16).astype(np.float64) for start in (8, 24, 40)]
    return _column(table, 0, 8).astype(np.int64), np.stack(places, axis=1)


def _is_plain_node(text: str) -> bool:
    return (
        "," not in text
        and _PLAIN_COUNT.fullmatch(text[:8]) is not None
        and all(map(_PLAIN_NUMBER.fullmatch, (text[8:24], text[24:40], text[40:56])))
    )


def _element_columns(block: Block) -> _Table | None:
    """Return elements in the plain fixed format, 4-node shells and 8-node solids; else None."""
    needed = {"ELEMENT_SHELL": 6, "ELEMENT_SOLID": 10}.get(block.keyword)
    if block.long or not (needed and block.cards):
        return None
    if any("," in card.text for card in block.cards):
        return None
    table = _characters(block, _width(_ELEMENT))
    if (
        not _are_counts(table[:, : 8 * needed])
        or not np.isin(table[:, 8 * needed :], (b" ", b"0")).all()
    ):
        return None
    numbers = [_column(table, 8 * k, 8).astype(np.int64) for k in range(1, needed)]
    nodes = np.zeros((len(table), 8 if needed == 6 else 10), dtype=np.int64)
    for k, column in enumerate(numbers[1:]):
        nodes[:, k] = column
    if not nodes.any(axis=1).all():  # the first of two cards has no nodes
        return None
    return _Table(numbers[0], nodes, np.zeros((len(nodes), 4)))


def _are_counts(table: NDArray[np.bytes_]) -> bool:
    """Return whether all fields of eight characters contain one run of digits and nothing else."""
    fields = table.reshape(len(table), -1, 8)
    digit = (fields >= b"0") & (fields <= b"9")
    begins = digit[..., 0] + np.count_nonzero(digit[..., 1:] & ~digit[..., :-1], axis=2)
    return bool((digit | (fields == b" ")).all() and (begins == 1).all())


def _characters(block: Block, width: int) -> NDArray[np.bytes_]:
    """Return the characters (n, width) of the cards; non-ASCII ones as question marks."""
    text = "".join(card.text[:width].ljust(width) for card in block.cards)
    return np.frombuffer(text.encode("ascii", "replace"), dtype="S1").reshape(-1, width)


def _column(table: NDArray[np.bytes_], start: int, width: int) -> NDArray[np.bytes_]:
    """Return the texts (n,) of a field."""
    column = np.ascontiguousarray(table[:, start : start + width])
    return column.view(f"S{width}")[:, 0]


def _node_cards(block: Block) -> tuple[Int64Array, FloatArray]:
    ids: list[int] = []
    points: list[tuple[float, ...]] = []
    for card in block.cards:
        row = row_of(card, block, _NODE)
        if not any(row.texts):
            continue
        ids.append(row.whole("NID"))
        points.append(row.reals("X Y Z"))
    array = np.array(points, dtype=np.float64).reshape(-1, 3)
    return np.array(ids, dtype=np.int64), array


def _shell_cards(block: Block) -> _Table:
    """Read *ELEMENT_SHELL with its options: eid, pid, n1 … n8, then cards the options add."""
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
        row = row_of(cards[i], block, _ELEMENT)
        part.append(row.whole("PID"))
        nodes.append(row.wholes(_NODES))
        corners: tuple[float, ...] = (0.0,) * 4
        if with_thickness:
            corners = row_of(cards[i + 1], block, _THICKNESSES).reals("THIC1 THIC2 THIC3 THIC4")
        if extra > with_thickness:
            row_of(cards[i + extra], block, _OFFSET)
        thickness.append(corners)
    return _table(part, nodes, thickness, 8)


def _solid_cards(block: Block) -> _Table:
    """Read *ELEMENT_SOLID: one card, or element and part on one and up to ten nodes on the next.

    The two-card form is told by its first card, which has no nodes.
    """
    if block.keyword not in _SOLIDS:
        raise _unknown_element(block, _SOLIDS)
    part: list[int] = []
    nodes: list[tuple[int, ...]] = []
    cards = iter([card for card in block.cards if card.text.strip()])
    for card in cards:
        row = row_of(card, block, _ELEMENT)
        part.append(row.whole("PID"))
        numbers = row.wholes(_NODES)
        if any(numbers):
            nodes.append((*numbers, 0, 0))
            continue
        second = next(cards, None)
        if second is None:
            raise MeshError("the card with the element's nodes is missing", where=block.where(card))
        nodes.append(row_of(second, block, _TEN_NODES).wholes(f"{_NODES} N9 N10"))
    return _table(part, nodes, [(0.0,) * 4] * len(part), 10)


def _table(
    part: list[int], nodes: list[tuple[int, ...]], thickness: list[tuple[float, ...]], width: int
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
    ids: Int64Array, points: FloatArray, blocks: Iterable[Block]
) -> tuple[Int64Array, FloatArray]:
    """Return nodes once each; a node given twice in the same place (included files) is allowed."""
    _, rows, inverse = np.unique(ids, return_index=True, return_inverse=True)
    if len(rows) == len(ids):
        return ids, points
    moved = np.flatnonzero((points != points[rows[inverse]]).any(axis=1))
    if len(moved):
        number = int(ids[moved[0]])
        first, *others = _cards_of_node(number, blocks)
        again = next(row for row in others if row.reals("X Y Z") != first.reals("X Y Z"))
        raise MeshError(
            f"node {number} is given twice, at another place in line {first.card.line} of "
            f"{first.block.path.name}",
            where=again.block.where(again.card),
            allowed="each number of a node once",
        )
    rows.sort()
    return ids[rows], points[rows]


def _cards_of_node(number: int, blocks: Iterable[Block]) -> list[Row]:
    """Return all cards that give a node."""
    of_nodes = (block for block in blocks if block.keyword == "NODE")
    rows = (row_of(card, block, _NODE) for block in of_nodes for card in block.cards)
    return [row for row in rows if row.texts[0] and row.whole("NID") == number]


def _cells(
    shells: list[_Table], solids: list[_Table], rows: Rows, parts: Parts
) -> tuple[list[CellBlock], list[Int64Array], list[FloatArray | None]]:
    """Return blocks by kind, the part number of each cell and the thickness at its nodes."""
    blocks: list[CellBlock] = []
    numbers: list[Int64Array] = []
    thickness: list[FloatArray | None] = []
    for table in shells:
        of_part = parts.shell_thickness(table.part)
        given = np.where(table.thickness > 0.0, table.thickness, of_part)
        for kind, mask, count in _shell_kinds(table.nodes):
            if not mask.any():
                continue
            blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
            numbers.append(table.part[mask])
            values = given[mask][:, :3] if count == 3 else given[mask]
            if count == 8:
                values = np.hstack([values, 0.5 * (values + np.roll(values, -1, axis=1))])
            thickness.append(values if (values > 0.0).any() else None)
    for table in solids:
        for kind, mask, count in _solid_kinds(table.nodes):
            if mask.any():
                blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
                numbers.append(table.part[mask])
                thickness.append(None)
    return blocks, numbers, thickness


Kind = tuple[str, NDArray[np.bool_], int]
"""Name of a kind of cell, its rows, and its number of nodes."""


def _shell_kinds(nodes: Int64Array) -> tuple[Kind, ...]:
    """Classify shells by their nodes: a triangle has its third node twice, or no fourth."""
    corners, middles = nodes[:, :4], nodes[:, 4:8]
    triangle = (corners[:, 3] == corners[:, 2]) | (corners[:, 3] == 0)
    quad8 = ~triangle & (middles > 0).all(axis=1)
    return ("triangle", triangle, 3), ("quad", ~triangle & ~quad8, 4), ("quad8", quad8, 8)


def _solid_kinds(nodes: Int64Array) -> tuple[Kind, ...]:
    """Classify solids by their nodes: tetrahedra have ten nodes, or four."""
    ten = np.asarray((nodes[:, 8:10] > 0).all(axis=1))
    four = ~ten & (nodes[:, 4:8] == 0).all(axis=1)
    return ("hexahedron", ~ten & ~four, 8), ("tetra", four, 4), ("tetra10", ten, 10)


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


def _sets(blocks: Iterable[Block], rows: Rows) -> Iterable[Group]:
    """Yield sets of nodes, and nodes that single cards hold, by name alone.

    Their numbers are used for parts too.

    One with parameters without a value is not there: who asks for it is told.
    """
    for number, nodes in read_sets(blocks, "NODE", lambda *_: None).items():
        kept = rows(np.array(nodes, dtype=np.int64))
        yield Group(None, set_name(number), None, kept)
    for name, nodes in tied_nodes(blocks).items():
        ids = np.unique(np.array(nodes, dtype=np.int64))
        yield Group(None, name, None, rows(ids[rows.known(ids)]))


class Lumped(NamedTuple):
    """A mass of *ELEMENT_MASS on a node, or distributed over the nodes of a set."""

    number: int
    """Number of the node or set."""
    of_set: bool
    mass: float
    block: Block
    line: int


def is_lumped(block: Block) -> bool:
    """Return whether `lumped` reads a keyword."""
    return block.keyword in ("ELEMENT_MASS", "ELEMENT_MASS_NODE_SET")


def lumped(block: Block) -> list[Lumped]:
    """Return all masses of a keyword for which `is_lumped` holds.

    Raises
    ------
    MeshError
        A field that should be a number is none.
    """
    of_set = block.keyword.endswith("_SET")
    rows = [row_of(card, block, _MASS) for card in block.cards if card.text.strip()]
    return [
        Lumped(row.whole("NID"), of_set, row.real("MASS"), block, row.card.line) for row in rows
    ]


def masses_of_parts(block: Block) -> dict[int, Row]:
    """Return the cards of *ELEMENT_MASS_PART, by part; their user reads ADDMASS and FINMASS."""
    rows = [row_of(card, block, _MASS_OF_PART) for card in block.cards if card.text.strip()]
    return {row.whole("PID"): row for row in rows}


def cut_for_what_is_left(block: Block) -> None:
    """Read a mesh keyword so that only fields without effect on the mesh stay unread.

    Unreadable cards are ignored here: the reader of the mesh reports them.
    """
    with suppress(MeshError):
        if block.keyword == "NODE":
            # A plain card ends with the last coordinate.
            end = _width(_NODE) - 16
            plain = [c for c in block.cards if "," not in c.text and not c.text[end:].strip(" 0")]
            if not block.long:
                block.mark_read(*plain)
            others = [card for card in block.cards if card.line not in block.unread]
            _node_cards(block._replace(cards=others))
        elif _element_columns(block) is not None:
            block.mark_read(*block.cards)
        elif block.keyword.startswith("ELEMENT_SHELL"):
            _shell_cards(block)
        else:
            _solid_cards(block)


def _width(fields: Layout) -> int:
    return sum(field.width for field in fields.fields)


def _mass(blocks: Iterable[Block], rows: Rows, count: int) -> FloatArray | None:
    """Return the masses (n,) of *ELEMENT_MASS; None if the deck has none."""
    masses = [one for block in blocks if is_lumped(block) for one in lumped(block)]
    if not masses:
        return None
    sets = read_sets(blocks, "NODE", lambda *_: None) if any(m.of_set for m in masses) else {}
    nodes = [sorted({*sets.get(m.number, [])}) if m.of_set else [m.number] for m in masses]
    at = rows(np.array([node for some in nodes for node in some], dtype=np.int64))
    shares = [m.mass / len(some) for m, some in zip(masses, nodes, strict=True) for _ in some]
    return np.bincount(at, weights=np.array(shares), minlength=count).astype(np.float64)
