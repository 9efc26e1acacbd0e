"""Tables in text files: one reader for rows of cells under heads with names and units.

Columns are parted by semicolons, commas, tabs or blanks, whichever part the first two rows alike.
Quotation marks, a byte order mark and code page 1252 (spreadsheets of Western Europe) are read;
where a comma does not part columns, it may be the decimal mark.
"""

from __future__ import annotations

import codecs
import csv
import re
from array import array
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import FileError, InputError, UnitError
from contiga.io.limits import watched_lines
from contiga.io.units import Quantity, Units, quantity_factor
from contiga.records import FloatArray

MARKS = (";", ",", "\t", " ")
"""Separators of columns, the likeliest first."""
_MAX_LINE = 10_000_000
_AHEAD = 20
"""Lines from which the separator is determined; quoted names may span several."""
_CHUNK = 1 << 20
# The last bracket may hold one pair of its own: acc (m/(s²)).
_HEAD = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>(?:[^()]|\([^()]*\))*)\))"
)
_INDEX = re.compile(r".*\S\[(?!1\])\d+\]")
"""Keys of a case that end in an index, ``velocity[2]``, which is no unit."""
_INSIDE = re.compile(r"\s\[[^\[\]]*\]")
_QUOTED = re.compile("(['\"\u2018\u201c\u201e])(.*)['\"\u2019\u201c\u201d]")
# If blanks separate the columns, those before and within a unit do not.
_BLANK_IN_HEAD = re.compile(r"\s+(?=[\[(]|[^\[\]()]*[\])])")


class Head(NamedTuple):
    """The head of a column."""

    text: str
    name: str
    """Name without the unit."""
    unit: str | None
    """Unit in brackets or parentheses at its end; None without one."""


class Row(NamedTuple):
    """A row of cells."""

    line: int
    cells: list[str]


@dataclass(frozen=True)
class Sheet:
    """A table whose head has been read. Its rows are read once, on request."""

    path: Path
    line: int
    """Line of the heads."""
    heads: list[Head]
    """Heads of the columns; None if the first row has numbers."""
    mark: str
    """Separator of the columns."""
    rows: Iterator[Row]
    """Nonempty rows under the heads."""

    @property
    def where(self) -> str:
        """File and line of the heads."""
        return f"{self.path}:{self.line}"

    def with_row_of_units(self) -> Sheet:
        """Return the table with units from its first row if that is text and no head has a unit."""
        first = next(self.rows, None)
        if first is None:
            return self
        told = not any(head.unit for head in self.heads) and len(first.cells) == len(self.heads)
        if not told or any(map(_is_number, first.cells)):
            return replace(self, rows=chain([first], self.rows))
        pairs = zip(self.heads, first.cells, strict=True)
        return replace(
            self, heads=[one._replace(unit=u.strip("[]() ") or None) for one, u in pairs]
        )

    def check_header(self, header: str) -> None:
        """Refuse a table without heads; the error suggests heads such as `header`."""
        if not self.heads:
            first = next(self.rows, Row(1, []))
            raise FileError(
                "the first line must name the columns",
                where=self.where,
                found=self.mark.join(first.cells),
                allowed=f"a header such as {header}",
            )

    def order(self, columns: Sequence[str] | None, counts: tuple[int, ...], told: str) -> list[int]:
        """Return the selected columns: those named, or all if their number is right.

        Parameters
        ----------
        columns : names, with or without their units
        counts : how many there may be
        told : what they are, in words
        """
        if columns is None:
            if len(self.heads) in counts:
                return list(range(len(self.heads)))
            many = " or ".join({2: "two", 3: "three", 4: "four"}[n] for n in counts)
            raise FileError(
                f"which columns are meant? There are not {many}",
                where=self.where,
                found=self._columns_named(),
                allowed=told,
                remedy="Name them as columns",
            )
        wanted = [columns] if isinstance(columns, str) else list(columns)
        if len(wanted) not in counts:
            raise InputError(
                f"must name {told}",
                where="columns",
                found=wanted,
                allowed=f"{' or '.join(map(str, counts))} names",
            )
        return [self.column(name) for name in wanted]

    def column(self, name: str) -> int:
        """Return the index of a column, named with or without its unit."""
        at = [k for k, head in enumerate(self.heads) if name in (head.text, head.name)]
        if len(at) != 1:
            what = "is missing" if not at else f"is there {len(at)} times"
            raise FileError(
                f"the column {name!r} {what}",
                where=self.where,
                found=self._columns_named(),
                remedy="Name it with its unit, as the header does" if at else None,
            )
        return at[0]

    def unit(self, k: int, given: str | None = None) -> str | None:
        """Return the unit of a column: that in its head, or the given one.

        Raises
        ------
        FileError
            The head says another one than was given, or has one that is not at its end.
        """
        head = self.heads[k]
        if head.unit is None and _INSIDE.search(head.text):
            raise FileError(
                "the unit of a column stands at the end of its head",
                where=self.where,
                found=head.text,
                allowed="such as acc [g]",
            )
        if head.unit is not None and given is not None and head.unit != given.strip():
            raise FileError(
                "the header says another unit than was given",
                where=self.where,
                found=head.unit,
                allowed=f"{given!r}, or none in the header",
                remedy="Leave out the unit: the header's holds",
            )
        return given if head.unit is None else head.unit

    def numbers(
        self,
        order: Sequence[int],
        kinds: Sequence[Quantity],
        units: Units | None,
        given: Sequence[str | None] | None = None,
    ) -> Numbers:
        """Return the columns `order`, all finite, in the units of a case.

        Parameters
        ----------
        order : indices of columns of the file
        kinds : what each of them is
        units : of the case; None where there are none to convert to: heads have no units then
        given : units of columns whose heads have none; those of the case if omitted

        Raises
        ------
        FileError
            A row has more cells than heads, or no finite number in one of the columns; or heads
            have units that nothing can be made of.
        UnitError
            A unit is not one of its quantity.
        """
        factors = [
            self._factor(k, kind, units, unit)
            for k, kind, unit in zip(order, kinds, given or [None] * len(order), strict=True)
        ]
        *first, last = [self.heads[k].text for k in order]
        named = f"{', '.join(first)} and {last}" if first else last
        values, lines = array("d"), array("q")
        points = commas = False
        for row in self.rows:
            cells = [row.cells[k] if k < len(row.cells) else "" for k in order]
            commas = commas or any("," in cell for cell in cells)
            points = points or any("." in cell for cell in cells)
            try:
                found = [
                    as_number(cell, self.mark) * factor
                    for cell, factor in zip(cells, factors, strict=True)
                ]
            except ValueError:
                raise self._row_error(
                    "a row does not have a number for every column", row, f"a number for {named}"
                ) from None
            if not all(map(isfinite, found)):
                raise self._row_error("a number is not finite", row)
            if commas and points:
                raise self._row_error(
                    "decimal commas and decimal points in one table", row, "one of them"
                )
            values.extend(found)
            lines.append(row.line)
        return Numbers(np.array(values).reshape(-1, len(order)), lines.tolist())

    def _factor(self, k: int, kind: Quantity, units: Units | None, given: str | None) -> float:
        unit = self.unit(k, given)
        if unit is None:
            return 1.0
        where = f"{self.where}: {self.heads[k].text}"
        if units is None:
            raise UnitError(
                "the header says a unit, and none is said that it is to be converted to",
                where=where,
                found=unit,
                allowed="no unit in the header, or units = …",
            )
        return quantity_factor(unit, kind, units, where)

    def _row_error(self, what: str, row: Row, allowed: str | None = None) -> FileError:
        where, found = f"{self.path}:{row.line}", self.mark.join(row.cells)
        return FileError(what, where=where, found=found, allowed=allowed)

    def _columns_named(self) -> str:
        return ", ".join(head.text for head in self.heads)


class Numbers(NamedTuple):
    """Columns of a table."""

    table: FloatArray
    """(n, k) values."""
    lines: list[int]
    """(n,) lines of the rows in the file."""


def read_sheet(
    path: Path,
    header: str,
    *,
    marks: Sequence[str] = MARKS,
    comment: str | None = None,
    longest: int = _MAX_LINE,
) -> Sheet:
    """Read the heads of a table; its rows follow on request.

    Parameters
    ----------
    path : the text file
    header : what heads should be like, for errors
    marks : what may part the columns
    comment : what begins a comment, to the end of the line
    longest : characters of a line

    Raises
    ------
    FileError
        The file is missing or no text; a line is too long, or a quotation mark is not closed. That
        of a later line comes when its row is asked for, as does that of a row with more cells than
        there are heads.
    """
    lines = _lines(path, header, comment, longest)
    ahead = list(islice(lines, _AHEAD))
    mark = _mark([text for _, text in ahead], marks)
    rows = _rows(path, chain(ahead, lines), mark)
    first = next(rows, None)
    if first is None:
        return Sheet(path, 1, [], mark, iter(()))
    cells = _without_empty_end(first.cells)
    if all(map(_is_number, cells)):
        bare = (Row(line, _without_empty_end(given)) for line, given in rows)
        return Sheet(path, first.line, [], mark, chain([Row(first.line, cells)], bare))
    heads = [_head(text) for text in cells]
    return Sheet(path, first.line, heads, mark, _fitting(path, rows, len(heads), mark))


def check_times(times: FloatArray, lines: Sequence[int], path: str | Path) -> None:
    """Refuse times (n,) that do not increase; `lines` (n,) are their lines in the file.

    Raises
    ------
    FileError
        Times do not increase from row to row. The message gives the line of the later one.
    """
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if back.size:
        raise FileError(
            "the times must increase from row to row",
            where=f"{path}:{lines[back[0] + 1]}",
            found=times[back[0] : back[0] + 2].tolist(),
        )


def as_number(cell: str, mark: str) -> float:
    """Return the number in a cell; the decimal mark is a point, or a comma if `mark` is none."""
    return float(cell if mark == "," else cell.replace(",", "."))


def _head(text: str) -> Head:
    text = " ".join(text.split())
    if quoted := _QUOTED.fullmatch(text):
        text = quoted[2].strip()
    match = _HEAD.fullmatch(text)
    if match is None or _INDEX.fullmatch(text):
        return Head(text, text, None)
    unit = match["round"] if match["square"] is None else match["square"]
    return Head(text, match["name"], unit.strip())


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _lines(path: Path, header: str, comment: str | None, longest: int) -> Iterator[tuple[int, str]]:
    """Yield the nonempty lines with their numbers."""
    try:
        with path.open(encoding=_encoding(path)) as stream:
            for number, line in watched_lines(stream, path, longest):
                text = line if comment is None else line.partition(comment)[0]
                if "\0" in text:
                    raise FileError("the file is not text", where=f"{path}:{number}")
                if text.strip():
                    yield number, text
    except (OSError, UnicodeError) as error:
        raise FileError(
            f"the file cannot be read ({error})", where=str(path), allowed=f"CSV, header {header}"
        ) from error


def _encoding(path: Path) -> str:
    """Return UTF-8 or UTF-16, or code page 1252 for other bytes."""
    decoder = codecs.getincrementaldecoder("utf-8")()
    with path.open("rb") as stream:
        part = stream.read(_CHUNK)
        if part.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return "utf-16"
        try:
            while part:
                decoder.decode(part)
                part = stream.read(_CHUNK)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return "cp1252"
    return "utf-8-sig"


def _rows(path: Path, lines: Iterable[tuple[int, str]], mark: str) -> Iterator[Row]:
    """Yield the nonempty rows."""
    number = 0

    def texts() -> Iterator[str]:
        nonlocal number
        for k, line in enumerate(lines):
            number, text = line
            if mark == " ":
                text = text.replace("\t", " ").strip()
                text = text if k else _BLANK_IN_HEAD.sub("\u00a0", text)
            yield text + "\n"

    reader = csv.reader(texts(), delimiter=mark, skipinitialspace=True, strict=True)
    try:
        for record in reader:
            cells = [cell.strip() for cell in record]
            if any(cells):
                yield Row(number, cells)
    except csv.Error as error:
        raise FileError(
            f"a row cannot be read ({error})", where=f"{path}:{number}", allowed="CSV"
        ) from error


def _without_empty_end(cells: list[str], least: int = 0) -> list[str]:
    """Return cells up to the last nonempty one, but at least `least` if there are so many."""
    count = len(cells)
    while count > least and not cells[count - 1]:
        count -= 1
    return cells[:count]


def _fitting(path: Path, rows: Iterator[Row], count: int, mark: str) -> Iterator[Row]:
    """Yield rows with no more cells than heads; exactly as many if blanks separate them."""
    for line, given in rows:
        cells = _without_empty_end(given, count)
        if len(cells) > count or (mark == " " and len(cells) < count):
            raise FileError(
                f"a row has {len(cells)} cells under a header of {count}",
                where=f"{path}:{line}",
                found=mark.join(cells),
                allowed=f"{count} cells, parted by {mark!r}",
                remedy="Numbers with a decimal comma are read where semicolons part the columns"
                if mark == ","
                else None,
            )
        yield Row(line, cells)


def _mark(texts: list[str], marks: Sequence[str]) -> str:
    """Find the separator that cuts the first two rows into equally many cells, or the first row."""
    single = ""
    for mark in marks:
        try:
            rows = list(islice(_rows(Path(), enumerate(texts), mark), 2))
        except FileError:  # reported with its place when the rows are read
            continue
        counts = [len(_without_empty_end(row.cells)) for row in rows]
        if counts and counts[0] > 1:
            numbers = all(map(_is_number, rows[0].cells))
            if len(set(counts)) == 1 and (mark != " " or len(counts) == 2 or numbers):
                return mark
            single = single or (mark if mark != " " else "")
    return single or ","
