"""CSV files whose first line names the columns, with units in brackets where they have some."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contiga.errors import FileError, InputError
from contiga.records import FloatArray

_HEAD = re.compile(r"^(?P<name>.*?)\s*(?:\[(?P<square>.*)\]|\((?P<round>.*)\))$")


@dataclass(frozen=True)
class Sheet:
    """A CSV file that has been read, its cells still text."""

    path: Path
    line: int
    """Line of the header."""
    names: list[str]
    rows: list[tuple[int, str]]
    """Lines behind the header that are not empty, with their numbers."""
    mark: str
    """What parts the columns."""

    def head(self, k: int) -> tuple[str, str | None]:
        """Name and unit of a column from its head, such as ``a [g]``; None where it says none."""
        match = _HEAD.match(self.names[k])
        if match is None:
            return self.names[k], None
        return match["name"], (match["square"] or match["round"] or "").strip()

    def check_header(self, header: str) -> None:
        """Refuse a first line of numbers; errors say that it should be such as `header`."""
        try:
            [float(name) for name in self.names]
        except ValueError:
            return
        raise FileError(
            "the first line must name the columns",
            where=f"{self.path}:{self.line}",
            found=self.mark.join(self.names),
            allowed=f"a header such as {header}",
        )

    def order(self, columns: Sequence[str] | None, counts: tuple[int, ...], told: str) -> list[int]:
        """Which columns of the file are meant: those named, or all where there are so many.

        Parameters
        ----------
        columns : names, with or without their units
        counts : how many there may be
        told : what they are, in words
        """
        where, heads = f"{self.path}:{self.line}", ", ".join(self.names)
        many = " or ".join({2: "two", 4: "four"}[n] for n in counts)
        if columns is None:
            if len(self.names) in counts:
                return list(range(len(self.names)))
            raise FileError(
                f"which columns are meant? There are not {many}",
                where=where,
                found=heads,
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
        return [self._column(name) for name in wanted]

    def _column(self, name: str) -> int:
        heads = [(self.names[k], self.head(k)[0]) for k in range(len(self.names))]
        at = [k for k, both in enumerate(heads) if name in both]
        if len(at) != 1:
            what = "is missing" if not at else f"is there {len(at)} times"
            raise FileError(
                f"the column {name!r} {what}",
                where=f"{self.path}:{self.line}",
                found=", ".join(self.names),
                remedy="Name it with its unit, as the header does" if at else None,
            )
        return at[0]

    def numbers(self, order: Sequence[int], allowed: str) -> FloatArray:
        """The columns `order` (n, k), all finite.

        A row of more cells than the header has is refused: where a comma parts columns, numbers
        with a decimal comma are two.
        """
        values = []
        for number, line in self.rows:
            cells = line.rstrip(f"{self.mark} \t").split(self.mark)
            if len(cells) > len(self.names):
                raise FileError(
                    f"a row has {len(cells)} cells under a header of {len(self.names)}",
                    where=f"{self.path}:{number}",
                    found=line,
                    allowed=f"{len(self.names)} cells, parted by {self.mark!r}",
                    remedy="Write numbers with a decimal point, not a comma",
                )
            try:
                values.append([float(cells[i]) for i in order])
            except (ValueError, IndexError) as error:
                raise FileError(
                    "a row does not have a number for every column",
                    where=f"{self.path}:{number}",
                    found=line,
                    allowed=allowed,
                ) from error
            if not np.isfinite(values[-1]).all():
                raise FileError("a number is not finite", where=f"{self.path}:{number}", found=line)
        return np.array(values).reshape(-1, len(order))


def read_sheet(path: Path, header: str) -> Sheet:
    """The lines of a CSV file, whose columns are parted by commas, semicolons or tabs.

    The header tells by which: a comma if it has one. Errors say that it should be `header`.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(
            f"the file cannot be read ({error})", where=str(path), allowed=f"CSV, header {header}"
        ) from error
    rows = [(i, line) for i, line in enumerate(lines, start=1) if line.strip()]
    line, text = rows[0] if rows else (1, "")
    mark = next((mark for mark in ",;\t" if mark in text), ",")
    names = [name.strip() for name in text.split(mark)] if rows else []
    return Sheet(path, line, names, rows[1:], mark)


def unit_of(said: str | None, given: str | None, where: str) -> str | None:
    """The unit of a column: the header's, or the one given where that says none."""
    if said is not None and given is not None and said != given.strip():
        raise FileError(
            "the header says another unit than was given",
            where=where,
            found=said,
            allowed=f"{given!r}, or none in the header",
            remedy="Leave out the unit: the header's holds",
        )
    return given if said is None else said
