"""LS-DYNA keyword files as blocks of cards.

Layout rules as in the LS-DYNA Keyword User's Manual, volume I, "General card format": fields of
fixed width (twice as wide or more in the long format), or parted by commas; ``$`` starts a
comment line; ``*`` a keyword, ended by ``+`` for the long format and ``-`` for the standard one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from contiga.errors import MeshError
from contiga.io.mesh.deck_text import LARGEST, fortran_number, included
from contiga.io.mesh.lsdyna_parameters import Block as Block
from contiga.io.mesh.lsdyna_parameters import Card as Card
from contiga.io.mesh.lsdyna_parameters import Parameters, is_parameters

_LONG_WIDTH = 20
_USUAL = (10,) * 8
"""Widths of the fields of most cards."""
_TEN = re.compile(r"I10\s*=\s*Y")


def read_blocks(path: Path) -> Iterator[Block]:
    """Blocks of a deck and of the files it includes, in their order.

    Their fields have the values of parameters, as far as these stand before they are asked for.

    Raises
    ------
    FileError
        An included file is missing or includes itself, or the deck is not text.
    """
    yield from _blocks_of(path, False, [path.parent], Parameters(), ())


def _blocks_of(
    path: Path,
    long: bool,
    folders: list[Path],
    parameters: Parameters,
    open_files: tuple[Path, ...],
) -> Iterator[Block]:
    # An unreadable byte can only be in a title or comment that matters to nobody.
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for block in _split(lines, path, long, parameters):
        if block.keyword == "KEYWORD":
            continue
        if block.keyword == "END":
            return
        if is_parameters(block):
            parameters.read(block)
        if block.keyword.startswith("INCLUDE"):
            yield from _included(block, folders, (*open_files, path.resolve()))
        else:
            yield block


def _split(lines: list[str], path: Path, long: bool, parameters: Parameters) -> Iterator[Block]:
    block: Block | None = None
    for number, line in enumerate(lines, start=1):
        if line.startswith("$"):
            continue
        if not line.startswith("*"):
            if block is not None:
                block.cards.append(Card(line, number))
            continue
        if block is not None:
            yield block
        word, _, rest = line[1:].strip().upper().partition(" ")
        if word.endswith("%") or rest.strip() == "%" or (word == "KEYWORD" and _TEN.search(rest)):
            raise MeshError(
                "fields of ten characters for whole numbers are not read",
                where=f"{path}, line {number}: *{word}",
                found=line.strip(),
                allowed="the standard format, or LONG=Y",
                remedy="Write the deck in one of these with your preprocessor.",
            )
        if word == "KEYWORD":
            long = long or re.search(r"LONG\s*=\s*Y", rest) is not None
        this_long = (long or word.endswith("+")) and not word.endswith("-")
        block = Block(word.rstrip("+-"), [], this_long, path, number, parameters)
    if block is not None:
        yield block


def _included(block: Block, folders: list[Path], open_files: tuple[Path, ...]) -> Iterator[Block]:
    name = "".join(card.text.rstrip().removesuffix(" +") for card in block.cards[:1]).strip()
    if block.keyword in ("INCLUDE_PATH", "INCLUDE_PATH_RELATIVE"):
        folders.append(block.path.parent / name)
        return
    if block.keyword != "INCLUDE":
        raise MeshError(
            "a way of including files that is not supported",
            where=block.where(),
            found="*" + block.keyword,
            allowed="*INCLUDE, *INCLUDE_PATH",
            remedy="Write the deck out flat with your preprocessor.",
        )
    for card in block.cards:
        name = card.text.strip()
        if not name:
            continue
        file = included(name, folders, open_files, block.where(card))
        inner = Parameters(block.parameters)
        yield from _blocks_of(file, block.long, folders, inner, open_files)


Leave = Callable[[Block, str], None]
"""Takes a block that is left out, and why."""


@contextmanager
def leaving_parameters(block: Block, leave: Leave | None) -> Iterator[None]:
    """A field that is no number is no error where `leave` takes blocks with parameters (&).

    These are such as have no value: see `Parameters`.
    """
    try:
        yield
    except MeshError:
        if leave is None or not any("&" in card.text for card in block.cards):
            raise
        leave(block, "a parameter without a value")


class Row(NamedTuple):
    """A card cut into its fields."""

    card: Card
    block: Block
    texts: list[str]
    """Of the fields, stripped, with parameters filled in; those past the card's end are empty."""

    def whole(self, k: int) -> int:
        """Field `k` as a whole number; empty is 0."""
        text = self.texts[k]
        try:
            value = int(text or "0")
        except ValueError:
            value = int(self._number(text, "a whole number"))
        if abs(value) > LARGEST:
            raise MeshError(
                "a field of the card is not a valid count",
                where=self.block.where(self.card),
                found=text,
                allowed=f"a whole number of at most {LARGEST}",
            )
        return value

    def real(self, k: int) -> float:
        """Field `k` as a number, in any way Fortran writes it; empty is 0."""
        return self._number(self.texts[k] or "0", "a number")

    def wholes(self, start: int, stop: int) -> tuple[int, ...]:
        """Fields `start` to `stop`, without that, as whole numbers."""
        return tuple(self.whole(k) for k in range(start, stop))

    def reals(self, start: int, stop: int) -> tuple[float, ...]:
        """Fields `start` to `stop`, without that, as numbers."""
        return tuple(self.real(k) for k in range(start, stop))

    def _number(self, text: str, allowed: str) -> float:
        try:
            value = fortran_number(text)
            if not math.isfinite(value):
                raise ValueError
            return value
        except ValueError:
            remedy = "No *PARAMETER that is understood gives it a value: write the deck out flat."
            raise MeshError(
                "a field of the card is not a number",
                where=self.block.where(self.card),
                found=text,
                allowed=allowed,
                remedy=remedy if "&" in text else None,
            ) from None


def row_of(card: Card, block: Block, widths: Sequence[int] = _USUAL) -> Row:
    """The card of a block cut into fields of these widths."""
    cells = _cells(card.text, block.long, widths)
    if "&" in card.text:
        cells = list(map(block.parameters.filled, cells))
    return Row(card, block, cells)


def _cells(text: str, long: bool, widths: Sequence[int]) -> list[str]:
    if "," in text:
        cells = [cell.strip() for cell in text.split(",")]
        return (cells + [""] * len(widths))[: len(widths)]
    if long:
        widths = [max(width, _LONG_WIDTH) for width in widths]
    start, texts = 0, []
    for width in widths:
        texts.append(text[start : start + width].strip())
        start += width
    return texts
