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
from contiga.io.mesh.lsdyna_cards import Block, Layout, Row, layout, read_deck, row_of
from contiga.io.mesh.lsdyna_parts import Parts, read_parts
from contiga.io.mesh.lsdyna_sets import read_sets, set_name
from contiga.io.mesh.lsdyna_ties import tied_nodes
from contiga.io.mesh.numbered import NodeRows
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
# Options that add cards after the one with the nodes; the first added card holds the thickness.
_SHELL_OPTIONS = ("THICKNESS", "BETA", "MCID", "OFFSET")
_SOLIDS = ("ELEMENT_SOLID", "ELEMENT_TSHELL")

_PLAIN_NUMBER = re.compile(r" *[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)? *", re.ASCII)
_PLAIN_COUNT = re.compile(r" *\d+ *", re.ASCII)


class _Table(NamedTuple):
    """Elements of one keyword in the deck."""

    part: Int64Array
    """(m,) number of the part."""
    nodes: Int64Array
    """(m, 8) nodes of shells or (m, 10) of solids, by number; 0 for missing ones."""
    thickness: FloatArray
    """(m, 4) thickness at the corners, 0 if the element's own cards give none."""


def read_lsdyna(path: Path) -> RawMesh:
    """Return the mesh of a keyword deck with its included files; a group for each part.

    Sets of nodes, and nodes that single cards tie, are groups by name alone, as parts use the same
    numbers. A set with an unresolved parameter is left out. The mass is that of *ELEMENT_MASS; the
    mass of a set is shared equally among its nodes.

    Raises
    ------
    FileError
        Not a keyword deck, an included file is missing, or there is a *NODE_TRANSFORM.
    MeshError
        A card that cannot be read, an element, set or mass of a node that does not exist, an
        unknown kind of element, a node at two positions.

    Warns
    -----
    ContigaWarning
        A part or section has an unresolved parameter; its title and thickness are left out.
    """
    blocks = read_deck(path)
    if any(block.keyword == "NODE_TRANSFORM" for block in blocks):
        raise FileError(
            "nodes are moved by *NODE_TRANSFORM, which is not carried out",
            where=str(path),
            remedy="Write the deck with the nodes where they are",
        )
    node_ids, points, shells, solids = _nodes_and_elements(blocks)
    node_ids, points = _without_repeats(node_ids, points, blocks)
    rows = NodeRows(node_ids, str(path), "numbers given under *NODE")
    parts = read_parts(blocks, _warn_of_skipped_parts)
    cells, part_numbers, thickness = _cells(shells, solids, rows, parts)
    groups = [
        Group(
            int(number),
            parts.titles.get(int(number)) or None,
            tuple(np.flatnonzero(numbers == number) for numbers in part_numbers),
        )
        for number in np.unique(np.concatenate([np.empty(0, dtype=np.int64), *part_numbers]))
    ]
    sets = read_sets(blocks, "NODE", lambda *_: None)
    for number, nodes in sets.items():
        groups.append(Group(None, set_name(number), None, rows(np.array(nodes, dtype=np.int64))))
    for name, nodes in tied_nodes(blocks).items():
        ids = np.unique(np.array(nodes, dtype=np.int64))
        groups.append(Group(None, name, None, rows(ids[rows.contains(ids)])))

    mass: FloatArray | None = None
    masses = [each for block in blocks if is_lumped(block) for each in read_lumped(block)]
    if masses:
        loaded = [sorted({*sets.get(m.number, [])}) if m.of_set else [m.number] for m in masses]
        shares = [m.mass / len(ids) for m, ids in zip(masses, loaded, strict=True) for _ in ids]
        mass_rows = rows(np.array([node for ids in loaded for node in ids], dtype=np.int64))
        mass = np.bincount(mass_rows, weights=np.array(shares), minlength=len(points)).astype(
            np.float64
        )
    return RawMesh(
        points,
        tuple(cells),
        tuple(groups),
        node_ids,
        tuple(thickness) if any(values is not None for values in thickness) else None,
        mass,
    )


def _warn_of_skipped_parts(block: Block, reason: str) -> None:
    warnings.warn(
        f"{block.where()}, line {block.line}: {reason}: titles and thickness it gives are left out",
        ContigaWarning,
        stacklevel=2,
    )


def _nodes_and_elements(
    blocks: Iterable[Block],
) -> tuple[Int64Array, FloatArray, list[_Table], list[_Table]]:
    """Return numbers (n,) and positions (n, 3) of nodes as given, tables of shells and of solids.

    Blocks in the plain fixed format are read by columns, all others card by card.
    """
    ids, points = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))]
    shells, solids = [], []
    for block in blocks:
        if block.keyword == "NODE":
            numbers, positions = _node_columns(block) or _node_cards(block)
            ids.append(numbers)
            points.append(positions)
        elif block.keyword.startswith("ELEMENT_SHELL"):
            shells.append(_element_columns(block) or _shell_cards(block))
        elif block.keyword.startswith(_SOLIDS):
            solids.append(_element_columns(block) or _solid_cards(block))
    return np.concatenate(ids), np.concatenate(points), shells, solids


def _node_columns(block: Block) -> tuple[Int64Array, FloatArray] | None:
    """Return numbers and positions of nodes in the plain fixed format; None for other formats.

    Plain are cards without commas and parameters, all with a number and three coordinates.
    """
    if block.long:
        return None
    for card in block.cards:
        coordinates = card.text[8:24], card.text[24:40], card.text[40:56]
        if (
            "," in card.text
            or not _PLAIN_COUNT.fullmatch(card.text[:8])
            or not all(map(_PLAIN_NUMBER.fullmatch, coordinates))
        ):
            return None
    table = _characters(block, _width(_NODE))
    columns = [_column(table, start, 16).astype(np.float64) for start in (8, 24, 40)]
    return _column(table, 0, 8).astype(np.int64), np.stack(columns, axis=1)


def _element_columns(block: Block) -> _Table | None:
    """Return elements in the plain fixed format, 4-node shells and 8-node solids; else None.

    Plain are cards without commas, with one whole number in each field, some of them above 0 among
    the nodes, and no other text but 0.
    """
    n_fields = {"ELEMENT_SHELL": 6, "ELEMENT_SOLID": 10}.get(block.keyword)
    if block.long or not (n_fields and block.cards):
        return None
    if any("," in card.text for card in block.cards):
        return None
    table = _characters(block, _width(_ELEMENT))
    if not np.isin(table[:, 8 * n_fields :], (b" ", b"0")).all():
        return None
    # Every field must be one run of digits among blanks.
    fields = table[:, : 8 * n_fields].reshape(len(table), -1, 8)
    digit = (fields >= b"0") & (fields <= b"9")
    n_runs = digit[..., 0] + np.count_nonzero(digit[..., 1:] & ~digit[..., :-1], axis=2)
    if not (digit | (fields == b" ")).all() or not (n_runs == 1).all():
        return None
    part, *corners = (_column(table, 8 * k, 8).astype(np.int64) for k in range(1, n_fields))
    nodes = np.zeros((len(table), 8 if n_fields == 6 else 10), dtype=np.int64)
    for k, column in enumerate(corners):
        nodes[:, k] = column
    if not nodes.any(axis=1).all():  # the first of two cards has no nodes
        return None
    return _Table(part, nodes, np.zeros((len(nodes), 4)))


def _characters(block: Block, width: int) -> NDArray[np.bytes_]:
    """Return the first `width` characters (n, width) of the cards, padded with blanks.

    Those that are not ASCII become question marks.
    """
    text = "".join(card.text[:width].ljust(width) for card in block.cards)
    return np.frombuffer(text.encode("ascii", "replace"), dtype="S1").reshape(-1, width)


def _column(table: NDArray[np.bytes_], start: int, width: int) -> NDArray[np.bytes_]:
    """Return the texts (n,) in `width` columns from `start` on, with their blanks."""
    column = np.ascontiguousarray(table[:, start : start + width])
    return column.view(f"S{width}")[:, 0]


def _node_cards(block: Block) -> tuple[Int64Array, FloatArray]:
    """Return numbers and positions of nodes in any format; blank cards are skipped."""
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
    """Return part, nodes and corner thickness of the shells of *ELEMENT_SHELL, not their numbers.

    Thickness is zero without a card for it. The first card of a shell has number, part and nodes;
    THICKNESS, BETA and MCID add one card together, with the thickness, and OFFSET adds another.

    Raises
    ------
    MeshError
        An unknown option, cards that are not a multiple of those of a shell, a text that is no
        number.
    """
    options = [word for word in block.keyword.split("_")[2:] if word]
    for word in options:
        if word not in _SHELL_OPTIONS:
            raise _unknown_element(block, [f"ELEMENT_SHELL_{name}" for name in _SHELL_OPTIONS])
    has_thickness = any(word in ("THICKNESS", "BETA", "MCID") for word in options)
    n_extra = int(has_thickness) + options.count("OFFSET")
    part, nodes, thickness = [], [], []
    cards = [card for card in block.cards if card.text.strip()]
    step = 1 + n_extra
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
        if has_thickness:
            corners = row_of(cards[i + 1], block, _THICKNESSES).reals("THIC1 THIC2 THIC3 THIC4")
        if n_extra > has_thickness:
            row_of(cards[i + n_extra], block, _OFFSET)
        thickness.append(corners)
    return _table(part, nodes, thickness, 8)


def _solid_cards(block: Block) -> _Table:
    """Return the elements of *ELEMENT_SOLID or *ELEMENT_TSHELL, without thickness.

    They have one card with eight nodes, or one without nodes and a second one with up to ten.

    Raises
    ------
    MeshError
        A keyword with an option, a missing second card, a text that is no number.
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
    """Return numbers and positions of the nodes, each once, in the order of their first cards.

    Included files may repeat a node in the same place; `blocks` serve to find the cards of one
    that is given in two.

    Raises
    ------
    MeshError
        A number has two positions; the message names both lines.
    """
    _, rows, inverse = np.unique(ids, return_index=True, return_inverse=True)
    if len(rows) == len(ids):
        return ids, points
    moved = np.flatnonzero((points != points[rows[inverse]]).any(axis=1))
    if len(moved):
        number = int(ids[moved[0]])
        node_blocks = (block for block in blocks if block.keyword == "NODE")
        cards = (row_of(card, block, _NODE) for block in node_blocks for card in block.cards)
        first, *repeats = [row for row in cards if row.texts[0] and row.whole("NID") == number]
        again = next(row for row in repeats if row.reals("X Y Z") != first.reals("X Y Z"))
        raise MeshError(
            f"node {number} is given twice, at another place in line {first.card.line} of "
            f"{first.block.path.name}",
            where=again.block.where(again.card),
            allowed="each number of a node once",
        )
    rows.sort()
    return ids[rows], points[rows]


def _cells(
    shells: list[_Table], solids: list[_Table], rows: NodeRows, parts: Parts
) -> tuple[list[CellBlock], list[Int64Array], list[FloatArray | None]]:
    """Return blocks by table and kind, the part number of each cell, the thickness at its nodes.

    A triangle has its third node twice, or no fourth; it and a shell without all four mid-side
    nodes lose these. Of solids, ten nodes or none beyond the fourth are tetrahedra, all others
    hexahedra. Thickness (m, k) is that of the element's card, where above 0, else of its section,
    mid-side values are means; it is None for solids and for shells without any.
    """
    blocks: list[CellBlock] = []
    numbers: list[Int64Array] = []
    thickness: list[FloatArray | None] = []
    for table in shells:
        corners, middles = table.nodes[:, :4], table.nodes[:, 4:8]
        is_triangle = (corners[:, 3] == corners[:, 2]) | (corners[:, 3] == 0)
        is_quad8 = ~is_triangle & (middles > 0).all(axis=1)
        at_corners = np.where(
            table.thickness > 0.0, table.thickness, parts.shell_thickness(table.part)
        )
        for kind, mask, count in (
            ("triangle", is_triangle, 3),
            ("quad", ~is_triangle & ~is_quad8, 4),
            ("quad8", is_quad8, 8),
        ):
            if not mask.any():
                continue
            blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
            numbers.append(table.part[mask])
            values = at_corners[mask][:, :3] if count == 3 else at_corners[mask]
            if count == 8:
                values = np.hstack([values, 0.5 * (values + np.roll(values, -1, axis=1))])
            thickness.append(values if (values > 0.0).any() else None)
    for table in solids:
        is_tetra10 = (table.nodes[:, 8:10] > 0).all(axis=1)
        is_tetra = ~is_tetra10 & (table.nodes[:, 4:8] == 0).all(axis=1)
        for kind, mask, count in (
            ("hexahedron", ~is_tetra10 & ~is_tetra, 8),
            ("tetra", is_tetra, 4),
            ("tetra10", is_tetra10, 10),
        ):
            if mask.any():
                blocks.append(CellBlock(kind, rows(table.nodes[mask, :count])))
                numbers.append(table.part[mask])
                thickness.append(None)
    return blocks, numbers, thickness


class Lumped(NamedTuple):
    """A mass of *ELEMENT_MASS on a node, or distributed over the nodes of a set."""

    number: int
    """Number of the node or set."""
    of_set: bool
    mass: float
    """Mass of the node, or of the set as a whole."""
    block: Block
    line: int
    """Line of its card."""


def is_lumped(block: Block) -> bool:
    """Return whether `read_lumped` reads a keyword."""
    return block.keyword in ("ELEMENT_MASS", "ELEMENT_MASS_NODE_SET")


def read_lumped(block: Block) -> list[Lumped]:
    """Return all masses of a keyword for which `is_lumped` holds.

    Raises
    ------
    MeshError
        A field that should be a number is not one.
    """
    of_set = block.keyword.endswith("_SET")
    rows = [row_of(card, block, _MASS) for card in block.cards if card.text.strip()]
    return [
        Lumped(row.whole("NID"), of_set, row.real("MASS"), block, row.card.line) for row in rows
    ]


def read_part_masses(block: Block) -> dict[int, Row]:
    """Return the cards of *ELEMENT_MASS_PART, by part; the last one of each, its masses unread."""
    rows = [row_of(card, block, _MASS_OF_PART) for card in block.cards if card.text.strip()]
    return {row.whole("PID"): row for row in rows}


def mark_mesh_fields(block: Block) -> None:
    """Mark the fields of a *NODE or *ELEMENT that the reader of the mesh uses as read.

    Marking ends silently at an unreadable card: the reader of the mesh reports it.
    """
    with suppress(MeshError):
        if block.keyword == "NODE":
            # A plain card ends with the last coordinate.
            end = _width(_NODE) - 16
            plain = [c for c in block.cards if "," not in c.text and not c.text[end:].strip(" 0")]
            if not block.long:
                block.mark_read(*plain)
            unread_cards = [card for card in block.cards if card.line not in block.unread]
            _node_cards(block._replace(cards=unread_cards))
        elif _element_columns(block) is not None:
            block.mark_read(*block.cards)
        elif block.keyword.startswith("ELEMENT_SHELL"):
            _shell_cards(block)
        else:
            _solid_cards(block)


def _width(layout: Layout) -> int:
    return sum(field.width for field in layout.fields)
