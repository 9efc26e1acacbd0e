"""LS-DYNA keyword files as blocks of cards.

Layout rules as in the LS-DYNA Keyword User's Manual, volume I, "General card format": fields of
fixed width (twice as wide or more in the long format), or separated by commas; ``$`` starts a
comment line; ``*`` a keyword, ended by ``+`` for the long format and ``-`` for the standard one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from contiga.errors import FileError, MeshError
from contiga.io.mesh.deck_text import MAX_WHOLE, find_included, fortran_number
from contiga.io.mesh.lsdyna_parameters import LONG_WIDTH, WIDTH, Parameters, Unread, is_parameters
from contiga.io.mesh.lsdyna_parameters import Block as Block
from contiga.io.mesh.lsdyna_parameters import Card as Card

_CARD_WIDTH, _LONG_CARD_WIDTH = 80, 160
"""Columns of a card; text beyond them is a remark."""
_WIDE_INTEGERS = re.compile(r"I10\s*=\s*Y")


def read_blocks(path: Path) -> Iterator[Block]:
    """Yield the blocks of a deck and of the files it includes, in order, each up to its *END.

    Fields have the values of the parameters that are defined before the field is read. Bytes that
    are not UTF-8 are replaced, lines before the first keyword ignored.

    Raises
    ------
    FileError
        A file cannot be read; an included one is missing or includes itself.
    MeshError
        Another way of including files, or whole numbers in fields of ten characters.
    """
    yield from _blocks_of(path, False, [path.parent], Parameters(), ())


def read_deck(path: Path) -> list[Block]:
    """Return the blocks of a deck as `read_blocks`.

    Raises
    ------
    FileError
        As `read_blocks`, or the file has no keyword besides *KEYWORD, *END and *INCLUDE.
    MeshError
        As `read_blocks`.
    """
    blocks = list(read_blocks(path))
    if not blocks:
        raise FileError("not an LS-DYNA keyword deck", where=str(path), allowed="a file with *NODE")
    return blocks


def _blocks_of(
    path: Path,
    long: bool,
    folders: list[Path],
    parameters: Parameters,
    open_files: tuple[Path, ...],
) -> Iterator[Block]:
    """Yield the blocks of one file, those of its *INCLUDE in its place; see `read_blocks`.

    A block of parameters is read before it is yielded; a folder of an *INCLUDE_PATH is added to
    `folders`, where included files are sought. `open_files` are those that include this one. *END
    ends the file.
    """
    try:
        # An unreadable byte can only be in a title or comment, which has no effect.
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    open_files = (*open_files, path.resolve())
    for block in _split_into_blocks(lines, path, long, parameters):
        if block.keyword == "KEYWORD":
            continue
        if block.keyword == "END":
            return
        if is_parameters(block):
            parameters.read(block)
        if not block.keyword.startswith("INCLUDE"):
            yield block
            continue
        if block.keyword in ("INCLUDE_PATH", "INCLUDE_PATH_RELATIVE"):
            name = block.cards[0].text.rstrip().removesuffix(" +").strip() if block.cards else ""
            folders.append(path.parent / name)
            continue
        if block.keyword != "INCLUDE":
            raise MeshError(
                "a way of including files that is not supported",
                where=block.where(),
                found="*" + block.keyword,
                allowed="*INCLUDE, *INCLUDE_PATH",
                remedy="Write the deck out flat with your preprocessor.",
            )
        for card in block.cards:
            if name := card.text.strip():
                file = find_included(name, folders, open_files, block.where(card))
                inner = Parameters(block.parameters)
                yield from _blocks_of(file, block.long, folders, inner, open_files)


def _split_into_blocks(
    lines: list[str], path: Path, long: bool, parameters: Parameters
) -> Iterator[Block]:
    """Yield the keywords of a file with their cards, without comments.

    `long` is the format at first; a *KEYWORD with LONG=Y sets it, + or − after a keyword overrides
    it there. Fields of ten characters for whole numbers are a `MeshError`.
    """
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
        word, _, options = line[1:].strip().upper().partition(" ")
        if (
            word.endswith("%")
            or options.strip() == "%"
            or (word == "KEYWORD" and _WIDE_INTEGERS.search(options))
        ):
            raise MeshError(
                "fields of ten characters for whole numbers are not read",
                where=f"{path}, line {number}: *{word}",
                found=line.strip(),
                allowed="the standard format, or LONG=Y",
                remedy="Write the deck in one of these with your preprocessor.",
            )
        if word == "KEYWORD":
            long = long or re.search(r"LONG\s*=\s*Y", options) is not None
        is_long = (long or word.endswith("+")) and not word.endswith("-")
        block = Block(word.rstrip("+-"), [], is_long, path, number, parameters, {})
    if block is not None:
        yield block


OnSkip = Callable[[Block, str], None]
"""Callback for a block that is left out, with the reason."""


@contextmanager
def skip_unresolved(block: Block, on_skip: OnSkip | None) -> Iterator[None]:
    """Pass a block with an unresolved parameter (&) in a field to `on_skip` instead of raising.

    The rest of the `with` block is skipped. Other errors, and all without `on_skip`, are raised.
    """
    try:
        yield
    except MeshError as error:
        if on_skip is None or "&" not in str(error.found):
            raise
        on_skip(block, "a parameter without a value")


Definitions = dict[tuple[str, int], tuple[Block, Sequence[Card]]]
"""Cards that define a number, by its kind ("part", "material" …) and value."""


def define_once(
    definitions: Definitions, kind: str, number: int, block: Block, cards: Sequence[Card]
) -> None:
    """Note in `definitions` the cards of a number, unless there are some; they must be equal then.

    Included files may define a number again. Cards are equal if their keyword without _TITLE and
    their text without blanks at the ends of lines are.

    Raises
    ------
    MeshError
        Different cards define the number already.
    """
    first_block, first_cards = definitions.setdefault((kind, number), (block, cards))
    if _content(block, cards) != _content(first_block, first_cards):
        raise MeshError(
            f"{kind} {number} is given twice, otherwise in line {first_cards[0].line} of "
            f"{first_block.path.name}",
            where=block.where(cards[0]),
            allowed=f"each number of a {kind} once",
        )


def _content(block: Block, cards: Sequence[Card]) -> tuple[str, str]:
    """Return the keyword without _TITLE, and the text without blanks and lines at the ends."""
    text = "\n".join(card.text.rstrip() for card in cards)
    return block.keyword.removesuffix("_TITLE"), text.rstrip()


class Field(NamedTuple):
    """A field of a card, as in the manual."""

    name: str
    width: int = WIDTH
    """Columns in the standard format."""
    default: str = ""
    """Meaning of blank and 0; empty if that is 0."""
    idle: bool = False
    """Whether it is a mere label or a print option, without effect on a case."""


class Layout(NamedTuple):
    """The fields of a card, in order."""

    fields: tuple[Field, ...]
    places: Mapping[str, int]
    """Places of the fields, by name."""


def layout(text: str, width: int = WIDTH) -> Layout:
    """Return the layout of words ``NAME``, ``NAME=default``, ``NAME:width`` and ``~NAME``.

    A tilde marks an idle field; `width` is that of fields without their own.

    >>> layout("~EID:8 NID:8 MASS:16").fields[2]
    Field(name='MASS', width=16, default='', idle=False)
    """
    fields = []
    for word in text.split():
        head, _, default = word.partition("=")
        name, _, columns = head.partition(":")
        fields.append(Field(name.lstrip("~"), int(columns or width), default, name.startswith("~")))
    return Layout(tuple(fields), {field.name: k for k, field in enumerate(fields)})


class Row(NamedTuple):
    """A card cut into the fields of a layout; a requested field counts as read."""

    card: Card
    block: Block
    layout: Layout
    texts: list[str]
    """Texts of the fields, stripped, with parameters filled in; empty past the card's end."""

    def text(self, name: str) -> str:
        """Return the text of a field, or its default if it is blank; the field counts as read."""
        k = self.layout.places[name]
        self.block.unread[self.card.line].pop(name, None)
        return self.texts[k] or self.layout.fields[k].default

    def whole(self, name: str) -> int:
        """Return a field as a whole number; blank and 0 are its default, or 0.

        Decimals are cut off. The field counts as read.

        Raises
        ------
        MeshError
            The text is not a finite number, or exceeds `MAX_WHOLE`.
        """
        return self._as_whole(self.text(name) or "0") or int(self._default(name))

    def peek(self, name: str) -> int:
        """Return a field as `whole` does, without counting it as read.

        It is for fields that determine the cards that follow.
        """
        text = self.texts[self.layout.places[name]]
        return self._as_whole(text or "0") or int(self._default(name))

    def _as_whole(self, text: str) -> int:
        """Return a text as a whole number, decimals cut off; `MeshError` beyond `MAX_WHOLE`."""
        try:
            value = int(text)
        except ValueError:
            value = int(self._number(text, "a whole number"))
        if abs(value) > MAX_WHOLE:
            raise MeshError(
                "a field of the card is not a valid count",
                where=self.block.where(self.card),
                found=text,
                allowed=f"a whole number of at most {MAX_WHOLE}",
            )
        return value

    def real(self, name: str) -> float:
        """Return a field as a number, in any of Fortran's notations; blank and 0 are its default.

        Raises
        ------
        MeshError
            The text is not a finite number.
        """
        return self._number(self.text(name) or "0", "a number") or self._default(name)

    def wholes(self, names: str) -> tuple[int, ...]:
        """Return the fields of these names, separated by blanks, as whole numbers."""
        return tuple(map(self.whole, names.split()))

    def reals(self, names: str) -> tuple[float, ...]:
        """Return the fields of these names, separated by blanks, as numbers."""
        return tuple(map(self.real, names.split()))

    def _default(self, name: str) -> float:
        return float(self.layout.fields[self.layout.places[name]].default or 0.0)

    def _number(self, text: str, allowed: str) -> float:
        """Return a text as a finite number; others are a `MeshError`, for a & with a remedy."""
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


def row_of(card: Card, block: Block, layout: Layout) -> Row:
    """Return a card of a block, cut into fields; nonblank ones are noted in `block.unread`.

    Parameters (&) with a value are replaced by it. Idle fields are not noted; columns beyond the
    layout are, as "field 9" and so on. A card that was cut before keeps its notes.
    """
    count = len(layout.fields)
    if "," in card.text:
        cells = [cell.strip() for cell in card.text.split(",")]
        cells, beyond = (cells + [""] * count)[:count], cells[count:]
    else:
        start, cells = 0, []
        for field in layout.fields:
            width = max(field.width, LONG_WIDTH) if block.long else field.width
            cells.append(card.text[start : start + width].strip())
            start += width
        width, end = (LONG_WIDTH, _LONG_CARD_WIDTH) if block.long else (WIDTH, _CARD_WIDTH)
        beyond = [card.text[k : min(k + width, end)].strip() for k in range(start, end, width)]
    if "&" in card.text:
        cells = list(map(block.parameters.filled, cells))
    if card.line not in block.unread:
        block.unread[card.line] = {
            field.name: Unread(cell, field.default)
            for field, cell in zip(layout.fields, cells, strict=True)
            if cell and not field.idle
        } | {f"field {k}": Unread(cell, "") for k, cell in enumerate(beyond, count + 1) if cell}
    return Row(card, block, layout, cells)


def rows_of(block: Block, cards: Sequence[Card], *layouts: Layout) -> list[Row]:
    """Return a row for each layout, of the cards in order; blank ones after the last card.

    Cards beyond the layouts are ignored.
    """
    padded = [*cards[: len(layouts)], *[Card("", 0)] * (len(layouts) - len(cards))]
    return [row_of(card, block, layout) for card, layout in zip(padded, layouts, strict=True)]


def number_of_first_card(block: Block, layout: Layout, name: str) -> int:
    """Return the number in a field of the first nonblank card after the title.

    It is 0 without such a card, or if the field is not made of digits; this raises nothing.
    """
    _, cards = block.title_and_cards()
    text = row_of(cards[0], block, layout).text(name) if cards else ""
    return int(text) if text.isdecimal() else 0


def unread_fields(block: Block) -> Iterator[tuple[str, str]]:
    """Yield names and texts of fields that are neither blank, default nor read.

    A card that no reader has cut is one such field, named "card 2:", unless its words are all 0.
    """
    for k, card in enumerate(block.cards, start=1):
        fields = block.unread.get(card.line)
        if fields is None:
            words = card.text.replace(",", " ").split()
            if not all(_is_default(Unread(word, "")) for word in words):
                yield f"card {k}:", " ".join(words)
            continue
        yield from ((name, field.text) for name, field in fields.items() if not _is_default(field))


def _is_default(field: Unread) -> bool:
    """Return whether a field is 0 or its default, as a number or as a word in any case."""
    try:
        value = fortran_number(field.text)
        return value in (0.0, float(field.default or 0.0))
    except ValueError:  # one of the two is a word
        return field.text.upper() == field.default.upper()
