"""Tables in text files: one reader for rows of cells under heads with names and units.

Semicolons, commas, tabs or blanks separate columns: the first of them that splits the first two
rows into equally many cells. Quotation marks, a byte order mark and code page 1252 (spreadsheets of
Western Europe) are read; a comma that does not separate columns may be the decimal mark.
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
_MAX_LINE_LENGTH = 10_000_000
_N_LINES_AHEAD = 20
"""Number of lines from which the separator is determined; quoted names may span several."""
_CHUNK_SIZE = 1 << 20
# The last bracket may hold one pair of its own: acc (m/(s²)).
_HEAD = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>(?:[^()]|\([^()]*\))*)\))"
)
_INDEX = re.compile(r".*\S\[(?!1\])\d+\]")
"""Keys of a case that end in an index, ``velocity[2]``, which is no unit."""
_UNIT_INSIDE = re.compile(r"\s\[[^\[\]]*\]")
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
    """Heads of the columns; empty if the first row has numbers, or there is no row."""
    mark: str
    """Separator of the columns."""
    rows: Iterator[Row]
    """Nonempty rows under the heads."""

    @property
    def where(self) -> str:
        """File and line of the heads."""
        return f"{self.path}:{self.line}"

    @property
    def _head_texts(self) -> str:
        return ", ".join(head.text for head in self.heads)

    def with_unit_row(self) -> Sheet:
        """Return the table with units from its first row, which is then no row any more.

        That row must have a cell for each head, none of them a number, and no head a unit; else
        the table stays as it is. Brackets around units are removed. This takes the first of `rows`,
        so that only the returned table may be used.
        """
        first = next(self.rows, None)
        if first is None:
            return self
        has_units = any(head.unit for head in self.heads)
        if has_units or len(first.cells) != len(self.heads) or any(map(_is_number, first.cells)):
            return replace(self, rows=chain([first], self.rows))
        pairs = zip(self.heads, first.cells, strict=True)
        heads = [head._replace(unit=unit.strip("[]() ") or None) for head, unit in pairs]
        return replace(self, heads=heads)

    def check_header(self, header: str) -> None:
        """Refuse a table without heads.

        Raises
        ------
        FileError
            There are none; the message suggests heads such as `header`.
        """
        if not self.heads:
            first = next(self.rows, Row(1, []))
            raise FileError(
                "the first line must name the columns",
                where=self.where,
                found=self.mark.join(first.cells),
                allowed=f"a header such as {header}",
            )

    def order(
        self, columns: Sequence[str] | None, counts: tuple[int, ...], meaning: str
    ) -> list[int]:
        """Return the indices of the named columns, or of all if their number is allowed.

        Parameters
        ----------
        columns : names, with or without their units; None for all
        counts : allowed numbers of columns
        meaning : meaning of the columns in words, for errors

        Raises
        ------
        FileError
            No names, and another number of columns; a name that no column has, or several.
        InputError
            Another number of names.
        """
        if columns is None:
            if len(self.heads) in counts:
                return list(range(len(self.heads)))
            numbers = " or ".join({2: "two", 3: "three", 4: "four"}[n] for n in counts)
            raise FileError(
                f"which columns are meant? There are not {numbers}",
                where=self.where,
                found=self._head_texts,
                allowed=meaning,
                remedy="Name them as columns",
            )
        names = [columns] if isinstance(columns, str) else list(columns)
        if len(names) not in counts:
            raise InputError(
                f"must name {meaning}",
                where="columns",
                found=names,
                allowed=f"{' or '.join(map(str, counts))} names",
            )
        return [self.column(name) for name in names]

    def column(self, name: str) -> int:
        """Return the index of a column, named with or without its unit.

        Raises
        ------
        FileError
            No column has the name, or several.
        """
        matches = [k for k, head in enumerate(self.heads) if name in (head.text, head.name)]
        if len(matches) != 1:
            fault = f"is there {len(matches)} times" if matches else "is missing"
            raise FileError(
                f"the column {name!r} {fault}",
                where=self.where,
                found=self._head_texts,
                remedy="Name it with its unit, as the header does" if matches else None,
            )
        return matches[0]

    def unit(self, k: int, given: str | None = None) -> str | None:
        """Return the unit of a column: from its head, or else `given`, which may be None.

        Raises
        ------
        FileError
            The head has another unit than `given`, or one that is not at its end.
        """
        head = self.heads[k]
        if head.unit is None and _UNIT_INSIDE.search(head.text):
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
        """Return the columns `order`, in the units of a case, with lines; this uses up the rows.

        Parameters
        ----------
        order : indices of columns of the file
        kinds : quantity of each of them
        units : units of the case; None without units: heads must have none then
        given : units of columns whose heads have none; of the case if omitted

        Raises
        ------
        FileError
            A row has more cells than heads, or no finite number in one of the columns; rows with
            decimal commas and rows with points; a head with another unit than the given one.
        UnitError
            A unit is not one of its quantity, or there are no units to convert it to.
        """
        factors = []
        for k, kind, given_unit in zip(order, kinds, given or [None] * len(order), strict=True):
            unit, where = self.unit(k, given_unit), f"{self.where}: {self.heads[k].text}"
            if unit is None:
                factors.append(1.0)
                continue
            if units is None:
                raise UnitError(
                    "the header says a unit, and none is said that it is to be converted to",
                    where=where,
                    found=unit,
                    allowed="no unit in the header, or units = …",
                )
            factors.append(quantity_factor(unit, kind, units, where))
        *first, last = [self.heads[k].text for k in order]
        names = f"{', '.join(first)} and {last}" if first else last
        values, lines = array("d"), array("q")
        has_point = has_comma = False
        for row in self.rows:
            cells = [row.cells[k] if k < len(row.cells) else "" for k in order]
            has_comma = has_comma or any("," in cell for cell in cells)
            has_point = has_point or any("." in cell for cell in cells)
            try:
                numbers = [
                    as_number(cell, self.mark) * factor
                    for cell, factor in zip(cells, factors, strict=True)
                ]
            except ValueError:
                raise self._row_error(
                    "a row does not have a number for every column", row, f"a number for {names}"
                ) from None
            if not all(map(isfinite, numbers)):
                raise self._row_error("a number is not finite", row)
            if has_comma and has_point:
                raise self._row_error(
                    "decimal commas and decimal points in one table", row, "one of them"
                )
            values.extend(numbers)
            lines.append(row.line)
        return Numbers(np.array(values).reshape(-1, len(order)), lines.tolist())

    def _row_error(self, what: str, row: Row, allowed: str | None = None) -> FileError:
        where, found = f"{self.path}:{row.line}", self.mark.join(row.cells)
        return FileError(what, where=where, found=found, allowed=allowed)


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
    longest: int = _MAX_LINE_LENGTH,
) -> Sheet:
    """Return a table whose heads are read; its rows follow on request.

    The first row has the heads, unless all its cells are numbers. An empty file has neither.

    Parameters
    ----------
    path : the text file
    header : example of heads, for errors
    marks : possible separators of columns
    comment : beginning of a comment, which ends with the line
    longest : largest number of characters of a line

    Raises
    ------
    FileError
        The file is missing or no text; a line is too long, or a quotation mark is not closed. The
        error of a later line comes when its row is read, and so does the error of a row with more
        cells than there are heads.
    """
    lines = _lines(path, header, comment, longest)
    lines_ahead = list(islice(lines, _N_LINES_AHEAD))
    mark = _separator([text for _, text in lines_ahead], marks)
    rows = _rows(path, chain(lines_ahead, lines), mark)
    first = next(rows, None)
    if first is None:
        return Sheet(path, 1, [], mark, iter(()))
    cells = _trimmed(first.cells)
    if all(map(_is_number, cells)):
        rows = (Row(line, _trimmed(row)) for line, row in rows)
        return Sheet(path, first.line, [], mark, chain([Row(first.line, cells)], rows))
    heads = []
    for cell in cells:
        text = " ".join(cell.split())
        if quoted := _QUOTED.fullmatch(text):
            text = quoted[2].strip()
        match = _HEAD.fullmatch(text)
        if match is None or _INDEX.fullmatch(text):
            heads.append(Head(text, text, None))
        else:
            unit = match["round"] if match["square"] is None else match["square"]
            heads.append(Head(text, match["name"], unit.strip()))
    return Sheet(path, first.line, heads, mark, _checked_rows(path, rows, len(heads), mark))


def _trimmed(cells: list[str], min_count: int = 0) -> list[str]:
    """Return cells without empty ones at the end, but `min_count` if there are so many."""
    count = len(cells)
    while count > min_count and not cells[count - 1]:
        count -= 1
    return cells[:count]


def _checked_rows(path: Path, rows: Iterator[Row], count: int, mark: str) -> Iterator[Row]:
    """Yield rows with no more cells than heads, without empty ones beyond `count`.

    More cells, and if blanks separate them also fewer, are a `FileError` with the line.
    """
    for line, row in rows:
        cells = _trimmed(row, count)
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
    """Return the number in a cell; its decimal mark is a point, or a comma unless `mark` is one.

    Words for not-a-number and infinity are read; any other text is a ValueError.
    """
    return float(cell if mark == "," else cell.replace(",", "."))


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _lines(path: Path, header: str, comment: str | None, longest: int) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that are not blank, without comments.

    A file that cannot be read, or has a zero character, is a `FileError`.
    """
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
    """Return the encoding of a file: UTF-16 by its mark, UTF-8 if all bytes fit, else 1252."""
    decoder = codecs.getincrementaldecoder("utf-8")()
    with path.open("rb") as stream:
        part = stream.read(_CHUNK_SIZE)
        if part.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return "utf-16"
        try:
            while part:
                decoder.decode(part)
                part = stream.read(_CHUNK_SIZE)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return "cp1252"
    return "utf-8-sig"


def _rows(path: Path, lines: Iterable[tuple[int, str]], mark: str) -> Iterator[Row]:
    """Yield the rows with a cell that is not empty, cells stripped, with the line of their end.

    Quotation marks that do not close are a `FileError`.
    """
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


def _separator(texts: list[str], marks: Sequence[str]) -> str:
    """Return the first mark that cuts the first two rows, or the only one, into equally many cells.

    There must be two cells or more; a blank counts for an only row if it has numbers. Without such
    a mark it is the first that cuts the first row, no blank, and else a comma.
    """
    of_first_row = ""
    for mark in marks:
        try:
            rows = list(islice(_rows(Path(), enumerate(texts), mark), 2))
        except FileError:  # reported with its place when the rows are read
            continue
        counts = [len(_trimmed(row.cells)) for row in rows]
        if counts and counts[0] > 1:
            has_numbers = all(map(_is_number, rows[0].cells))
            if len(set(counts)) == 1 and (mark != " " or len(counts) == 2 or has_numbers):
                return mark
            of_first_row = of_first_row or (mark if mark != " " else "")
    return of_first_row or ","
