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
from contiga.io.mesh.deck_text import find_included, parse_real, parse_whole

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
        """Return a field as a whole number.

        Raises
        ------
        MeshError
            It is none, or counts nothing.
        """
        text = self.text(k)
        return parse_whole(text, self.where) if text else default

    def real(self, k: int) -> float:
        """Return a field as a number in any of Nastran's notations; empty is 0.

        Raises
        ------
        MeshError
            It is none, or not finite.
        """
        return parse_real(self.text(k), self.where)

    def place(self, k: int) -> tuple[float, float, float]:
        """Return three numbers from field `k` on."""
        return self.real(k), self.real(k + 1), self.real(k + 2)


class _Line(NamedTuple):
    text: str
    path: Path
    number: int

    @property
    def where(self) -> str:
        return f"{self.path}, line {self.number}"


class _Split(NamedTuple):
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

    Raises
    ------
    FileError
        An included file is missing or includes itself.
    MeshError
        A continuation without its card; superelements.
    """
    card: Card | None = None
    tag = ""
    for line in _bulk(list(_lines(path, ()))):
        split = _split(line.text)
        if split.name:
            if card is not None:
                yield card
            card = Card(split.name, split.fields, f"{line.where}: {split.name}")
        elif card is None or (split.tag and tag and split.tag != tag):
            raise MeshError(
                "a continuation that does not follow its card",
                where=line.where,
                found=line.text[:72].rstrip(),
                remedy="Write each card with its continuations one after the other",
            )
        else:
            card.fields.extend(split.fields)
        tag = split.next_tag
    if card is not None:
        yield card


def _lines(path: Path, open_files: tuple[Path, ...]) -> Iterator[_Line]:
    """Yield lines without comments, tabs expanded, with those of included files in place."""
    open_files = (*open_files, path.resolve())
    including: _Line | None = None
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, raw in watched_lines(stream, path):
            line = _Line(raw.partition("$")[0].expandtabs(8).rstrip(), path, number)
            if not line.text:
                continue
            if including is not None:
                including = including._replace(text=including.text + line.text.strip())
            elif _INCLUDE.match(line.text):
                including = line
            else:
                yield line
                continue
            if including.text.count("'") % 2 == 0 and including.text.count('"') % 2 == 0:
                yield from _included(including, open_files)
                including = None


def _included(line: _Line, open_files: tuple[Path, ...]) -> Iterator[_Line]:
    match = _INCLUDE.match(line.text)
    name = match[1].strip().strip("'\"").strip() if match else ""
    yield from _lines(find_included(name, [line.path.parent], open_files, line.where), open_files)


def _bulk(lines: list[_Line]) -> Iterator[_Line]:
    """Yield the lines between BEGIN BULK and ENDDATA; without the first, from the start."""
    begins = [k for k, line in enumerate(lines) if _BEGIN.fullmatch(line.text)]
    for k in begins:
        match = _BEGIN.fullmatch(lines[k].text)
        if (match and match[1].strip()) or k != begins[0]:
            raise MeshError(
                "superelements and other bulk data sections are not carried out",
                where=lines[k].where,
                found=lines[k].text.strip(),
                allowed="one BEGIN BULK",
            )
    for line in lines[begins[0] + 1 if begins else 0 :]:
        if line.text[:8].strip().upper() == "ENDDATA":
            return
        yield line


def _split(text: str) -> _Split:
    if "," in text:
        return _free(text)
    first = text[:8].strip()
    wide = first.endswith("*") or first.startswith("*")
    width, count = (16, 4) if wide else (8, 8)
    fields = [text[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]
    return _named(first, fields, text[72:80].strip())


def _free(text: str) -> _Split:
    first, *rest = (field.strip() for field in text.split(","))
    count = 4 if first.endswith("*") or first.startswith("*") else 8
    fields = (rest + [""] * count)[:count]
    more = rest[count:]
    if len(more) > 1 or (more and more[0] and more[0][0] not in "+*"):
        # Fields that exceed a line continue without a line of their own.
        return _named(first, rest, "")
    return _named(first, fields, more[0] if more else "")


def _named(first: str, fields: list[str], next_tag: str) -> _Split:
    if not first or first[0] in "+*":
        return _Split("", fields, first.lstrip("+*"), next_tag.lstrip("+*"))
    return _Split(first.rstrip("*").strip().upper(), fields, "", next_tag.lstrip("+*"))
