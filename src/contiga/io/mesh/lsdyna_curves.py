"""``*DEFINE_CURVE`` and ``*DEFINE_TABLE`` of LS-DYNA keyword decks.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *DEFINE_CURVE and *DEFINE_TABLE.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import FileError
from contiga.io.mesh.lsdyna_cards import (
    Block,
    Definitions,
    OnSkip,
    define_once,
    layout,
    number_of_first_card,
    read_blocks,
    row_of,
    skip_unresolved,
)
from contiga.records import FloatArray

_HEAD = layout("LCID SIDR SFA=1 SFO=1 OFFA OFFO DATTYP LCINT")
_POINT = layout("A O", 20)
_TABLE = layout("TBID SFA=1 OFFA")
_ENTRY = layout("VALUE LCID", 20)


class DeckCurve(NamedTuple):
    """One curve of a deck."""

    number: int
    title: str
    table: FloatArray
    """(n, 2) rows x, y, scaled and shifted according to the deck."""
    where: str
    """File and line."""


def read_curves(blocks: Iterable[Block], on_skip: OnSkip | None = None) -> dict[int, DeckCurve]:
    """Return all curves of a deck by number; those with unresolved parameters go to `on_skip`.

    Abscissae are SFA (a + OFFA), ordinates SFO (o + OFFO); a scale of 0 is 1. A negative SFA
    reverses the points, so that abscissae rise as they do in the deck. Without `on_skip` an
    unresolved parameter is an error. Whether abscissae rise is not checked.

    Raises
    ------
    MeshError
        A field that should be a number is not one; a curve is given twice, not alike.
    """
    curves: dict[int, DeckCurve] = {}
    definitions: Definitions = {}
    for block in filter(is_curve, blocks):
        with skip_unresolved(block, on_skip):
            title, cards = block.title_and_cards()
            if not cards:
                continue
            head = row_of(cards[0], block, _HEAD)
            sfa, sfo, offa, offo = head.reals("SFA SFO OFFA OFFO")
            rows = [row_of(card, block, _POINT).reals("A O") for card in cards[1:]]
            table = np.array(rows, np.float64).reshape(-1, 2)
            table = (table + np.array([offa, offo])) * np.array([sfa, sfo])
            if sfa < 0.0:
                table = table[::-1]
            number = head.whole("LCID")
            define_once(definitions, "curve", number, block, block.cards)
            curves[number] = DeckCurve(number, title, table, block.where(cards[0]))
    return curves


def is_curve(block: Block) -> bool:
    """Return whether a keyword defines a curve by its points."""
    return block.keyword in ("DEFINE_CURVE", "DEFINE_CURVE_TITLE")


def is_table(block: Block) -> bool:
    """Return whether a keyword defines a table of curves."""
    return block.keyword.removesuffix("_TITLE") in ("DEFINE_TABLE", "DEFINE_TABLE_2D")


def read_tables(
    blocks: Sequence[Block], on_skip: OnSkip | None = None
) -> dict[int, list[tuple[float, int]]]:
    """Return all tables of a deck by number: pairs of a value and the number of its curve.

    A table that names no curves uses the curves that follow it directly; values without a curve
    are left out. Values are SFA (value + OFFA). Tables with unresolved parameters go to `on_skip`,
    or are an error without it. Of two tables of one number the last one counts.

    Raises
    ------
    MeshError
        A field that should be a number is not one.
    """
    tables: dict[int, list[tuple[float, int]]] = {}
    for k, block in enumerate(blocks):
        _, cards = block.title_and_cards() if is_table(block) else ("", [])
        if not cards:
            continue
        with skip_unresolved(block, on_skip):
            head = row_of(cards[0], block, _TABLE)
            sfa, offa = head.reals("SFA OFFA")
            rows = [row_of(card, block, _ENTRY) for card in cards[1:]]
            numbers = [row.whole("LCID") for row in rows]
            if not any(numbers):
                following = takewhile(is_curve, blocks[k + 1 : k + 1 + len(rows)])
                numbers = list(map(number_of, following))
            values = [sfa * (row.real("VALUE") + offa) for row in rows]
            tables[head.whole("TBID")] = list(zip(values, numbers, strict=False))
    return tables


def number_of(block: Block) -> int:
    """Return the number of a curve; 0 without a readable number."""
    return number_of_first_card(block, _HEAD, "LCID")


def read_curve_of_deck(path: Path, number: int | None) -> DeckCurve:
    """Return one curve of a deck; the only one if no number is given.

    Raises
    ------
    FileError
        The deck cannot be read, has no such curve, or several where none is named.
    MeshError
        A field that should be a number is not one, or a parameter of the curve has no value.
    """
    skipped: dict[int, Block] = {}
    curves = read_curves(
        read_blocks(path), lambda block, _: skipped.update({number_of(block): block})
    )
    if number in skipped or (skipped and not curves):
        # Without `on_skip` the unresolved parameter raises.
        read_curves([skipped.get(number or 0) or next(iter(skipped.values()))])
    if not curves:
        raise FileError("there is no *DEFINE_CURVE", where=str(path))
    if number is None and len(curves) == 1 and not skipped:
        return next(iter(curves.values()))
    if number not in curves:
        raise FileError(
            "which curve is meant?" if number is None else f"there is no *DEFINE_CURVE {number}",
            where=str(path),
            allowed=f"curve = {', '.join(map(str, sorted(curves)))}",
        )
    return curves[number]
