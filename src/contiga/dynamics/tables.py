"""Tables of motions: rows that are checked, and the files they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import FileError, InputError
from contiga.records import FloatArray


def as_table(table: ArrayLike, columns: tuple[str, ...]) -> FloatArray:
    """Rows of finite numbers, one for each of `columns`, the first strictly increasing."""
    allowed = f"rows [{', '.join(columns)}], {columns[0]} strictly increasing"
    try:
        rows = np.asarray(table, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a table must be rows of numbers, all of the same length",
            where="table",
            allowed=allowed,
        ) from error
    if rows.ndim != 2 or rows.shape[1] != len(columns) or len(rows) == 0:
        raise InputError(
            f"a table must have {len(columns)} columns and at least one row",
            where="table",
            found=rows.shape,
            allowed=allowed,
        )
    if not np.isfinite(rows).all():
        row = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
        raise InputError(
            f"row {row} is not finite", where="table", found=rows[row].tolist(), allowed=allowed
        )
    as_times(rows[:, 0], len(rows))
    return rows


def as_times(times: ArrayLike, count: int) -> FloatArray:
    own = np.asarray(times, dtype=np.float64)
    if own.shape != (count,) or count == 0 or not np.isfinite(own).all():
        raise InputError(
            "there must be one finite time for each pose, and at least one",
            where="times",
            found=own.shape,
            allowed=f"({max(count, 1)},)",
        )
    back = np.flatnonzero(np.diff(own) <= 0.0)
    if back.size:
        row = int(back[0])
        raise InputError(
            f"the times go back or repeat at row {row + 1}",
            where="table",
            found=own[row : row + 2].tolist(),
            allowed="strictly increasing times",
        )
    return own


def read_columns(path: Path, columns: tuple[str, ...]) -> FloatArray:
    """The named columns of a CSV file."""
    header = ",".join(columns)
    sheet = read_sheet(path, header)
    missing = [name for name in columns if name not in sheet.names]
    if missing:
        raise FileError(
            f"the column {missing[0]!r} is missing",
            where=f"{path}:{sheet.line}",
            found=",".join(sheet.names),
            allowed=f"a header with {header}",
        )
    return sheet.numbers([sheet.names.index(name) for name in columns], header)


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

    def numbers(self, order: Sequence[int], allowed: str) -> FloatArray:
        """The columns `order` (n, k)."""
        values = []
        for number, line in self.rows:
            cells = line.split(self.mark)
            try:
                values.append([float(cells[i]) for i in order])
            except (ValueError, IndexError) as error:
                raise FileError(
                    "a row does not have a number for every column",
                    where=f"{self.path}:{number}",
                    found=line,
                    allowed=allowed,
                ) from error
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
