"""``*DEFINE_CURVE`` of LS-DYNA keyword decks.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *DEFINE_CURVE.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import FileError
from contiga.io.mesh.lsdyna_cards import Block, fields, read_blocks, real, whole
from contiga.records import FloatArray

_TEN = (10,) * 8
_POINT = (20, 20)


class DeckCurve(NamedTuple):
    """One curve of a deck."""

    number: int
    title: str
    table: FloatArray
    """(n, 2) rows x, y, scaled and shifted as the deck says."""
    where: str
    """File and line."""


def read_curves(blocks: Iterable[Block]) -> dict[int, DeckCurve]:
    """All curves of a deck by their numbers.

    Abscissae are SFA (a + OFFA), ordinates SFO (o + OFFO); a scale of 0 is 1.

    Raises
    ------
    MeshError
        A field that should be a number is none.
    """
    found = (_curve(block) for block in blocks if is_curve(block))
    return {curve.number: curve for curve in found if curve is not None}


def is_curve(block: Block) -> bool:
    """Whether a keyword defines a curve by its points."""
    return block.keyword in ("DEFINE_CURVE", "DEFINE_CURVE_TITLE")


def _curve(block: Block) -> DeckCurve | None:
    cards = [card for card in block.cards if card.text.strip()]
    title = cards.pop(0).text.strip() if block.keyword.endswith("_TITLE") and cards else ""
    if not cards:
        return None
    head, *points = cards
    number, _, *scales = fields(head, block, _TEN)
    sfa, sfo, offa, offo = (real(text, block, head) for text in scales[:4])
    rows = [[real(text, block, card) for text in fields(card, block, _POINT)] for card in points]
    table = np.array(rows, np.float64).reshape(-1, 2)
    table = (table + np.array([offa, offo])) * np.array([sfa or 1.0, sfo or 1.0])
    return DeckCurve(whole(number, block, head), title, table, block.where(head))


def read_curve_of_deck(path: Path, number: int | None) -> DeckCurve:
    """One curve of a deck; the only one if no number is said.

    Raises
    ------
    FileError
        The deck cannot be read, has no such curve, or several where none is named.
    """
    try:
        curves = read_curves(read_blocks(path))
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    if not curves:
        raise FileError("there is no *DEFINE_CURVE", where=str(path))
    if number is None and len(curves) == 1:
        return next(iter(curves.values()))
    if number not in curves:
        raise FileError(
            "which curve is meant?" if number is None else f"there is no *DEFINE_CURVE {number}",
            where=str(path),
            allowed=f"curve = {', '.join(map(str, sorted(curves)))}",
        )
    return curves[number]
