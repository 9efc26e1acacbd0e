"""Nastran bulk data as cards: fixed, long and free fields, continuations, included files.

Rules of layout: MSC Nastran Quick Reference Guide, "Bulk Data Entries", format of bulk data.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from contiga.errors import MeshError
from contiga.io.limits import watched_lines
from contiga.io.mesh.deck_text import Position, find_included, parse_real, parse_whole

_INCLUDE = re.compile(r"\s*INCLUDE\s+(.*)", re.IGNORECASE)
_BEGIN = re.compile(r"\s*BEGIN\s+(?:BULK\b)?(.*)", re.IGNORECASE)


class Card(NamedTuple):
    """A bulk data entry."""

    name: str
    """Name in upper case."""
    fields: list[str]
    """Fields after the name, with continuations: eight per line (four of a long one)."""
    where: str
    """File, line and name, for messages."""

    def text(self, k: int) -> str:
        """Return field `k`, counted from 0 after the name; "" past the end."""
        return self.fields[k] if k < len(self.fields) else ""

    def whole(self, k: int, default: int = 0) -> int:
        """Return field `k` as a whole number; an empty one, or one past the end, is `default`.

        Raises
        ------
        MeshError
            As `parse_whole`.
        """
        text = self.text(k)
        return parse_whole(text, self.where) if text else default

    def real(self, k: int) -> float:
        """Return field `k` as a number in any of Nastran's notations; an empty one is 0.

        Raises
        ------
        MeshError
            As `parse_real`.
        """
        return parse_real(self.text(k), self.where)

    def position(self, k: int) -> Position:
        """Return the numbers in the three fields from `k` on, as `real`."""
        return self.real(k), self.real(k + 1), self.real(k + 2)


class _Line(NamedTuple):
    text: str
    path: Path
    number: int

    @property
    def where(self) -> str:
        return f"{self.path}, line {self.number}"


class _Entry(NamedTuple):
    """The fields of a line."""

    name: str
    """Name in upper case without the star of long fields; "" for a continuation."""
    fields: list[str]
    tag: str
    """Tag by which a continuation names the card before."""
    next_tag: str
    """Tag by which the next line names this one."""


def read_cards(path: Path) -> Iterator[Card]:
    """Yield the bulk data of a deck and of the files it includes, in order.

    They begin after BEGIN BULK, or with the first line if there is none, and end at ENDDATA. Bytes
    that are not UTF-8 are replaced.

    Raises
    ------
    FileError
        An included file is missing or includes itself.
    MeshError
        A continuation that does not follow its card, or has another tag; a second BEGIN, or one of
        a superelement; an INCLUDE with open quotes.
    """
    lines = list(_lines(path, ()))
    begins = [(k, match) for k, line in enumerate(lines) if (match := _BEGIN.fullmatch(line.text))]
    for k, match in begins:
        if match[1].strip() or k != begins[0][0]:
            raise MeshError(
                "superelements and other bulk data sections are not carried out",
                where=lines[k].where,
                found=lines[k].text.strip(),
                allowed="one BEGIN BULK",
            )
    card: Card | None = None
    tag = ""
    for line in lines[begins[0][0] + 1 if begins else 0 :]:
        if line.text[:8].strip().upper() == "ENDDATA":
            break
        entry = _split_line(line.text)
        if entry.name:
            if card is not None:
                yield card
            card = Card(entry.name, entry.fields, f"{line.where}: {entry.name}")
        elif card is None or (entry.tag and tag and entry.tag != tag):
            raise MeshError(
                "a continuation that does not follow its card",
                where=line.where,
                found=line.text[:72].rstrip(),
                remedy="Write each card with its continuations one after the other",
            )
        else:
            card.fields.extend(entry.fields)
        tag = entry.next_tag
    if card is not None:
        yield card


def _lines(path: Path, open_files: tuple[Path, ...]) -> Iterator[_Line]:
    """Yield the nonblank lines without comments, tabs expanded; lines of an INCLUDE in its place.

    `open_files` are the files that include this one. An INCLUDE continues over lines until its
    quotes are closed; if they never are, it is a `MeshError`.
    """
    open_files = (*open_files, path.resolve())
    statement: _Line | None = None
    """An INCLUDE, which continues until its quotes are closed."""
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, raw in watched_lines(stream, path):
            line = _Line(raw.partition("$")[0].expandtabs(8).rstrip(), path, number)
            if not line.text:
                continue
            if statement is not None:
                statement = statement._replace(text=statement.text + line.text.strip())
            elif _INCLUDE.match(line.text):
                statement = line
            else:
                yield line
                continue
            if statement.text.count("'") % 2 == 0 and statement.text.count('"') % 2 == 0:
                match = _INCLUDE.match(statement.text)
                name = match[1].strip().strip("'\"").strip() if match else ""
                file = find_included(name, [path.parent], open_files, statement.where)
                yield from _lines(file, open_files)
                statement = None
    if statement is not None:
        raise MeshError(
            "the quotes of an INCLUDE are not closed",
            where=statement.where,
            found=statement.text[:72],
        )


def _split_line(text: str) -> _Entry:
    """Return the fields of a line: 8 of 8 columns, 4 of 16 (starred), or separated by commas.

    Free fields are padded to 8 (starred: 4); a line with more than one field too many keeps all.
    """
    next_tag = ""
    if "," in text:
        first, *cells = (field.strip() for field in text.split(","))
        count = 4 if first.endswith("*") or first.startswith("*") else 8
        beyond = cells[count:]
        if len(beyond) > 1 or (beyond and beyond[0] and beyond[0][0] not in "+*"):
            # Fields that exceed a line continue without a line of their own.
            fields = cells
        else:
            fields = (cells + [""] * count)[:count]
            next_tag = beyond[0] if beyond else ""
    else:
        first = text[:8].strip()
        is_long = first.endswith("*") or first.startswith("*")
        width, count = (16, 4) if is_long else (8, 8)
        fields = [text[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]
        next_tag = text[72:80].strip()
    next_tag = next_tag.lstrip("+*")
    if not first or first[0] in "+*":
        return _Entry("", fields, first.lstrip("+*"), next_tag)
    return _Entry(first.rstrip("*").strip().upper(), fields, "", next_tag)
