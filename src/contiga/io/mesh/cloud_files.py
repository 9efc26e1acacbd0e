"""Bare clouds: three columns of numbers in a text file or a NumPy array."""

from __future__ import annotations

import re
from array import array
from pathlib import Path

import numpy as np

from contiga.errors import FileError
from contiga.io.limits import watched_lines
from contiga.records import FloatArray

SUFFIXES = (".csv", ".xyz", ".txt", ".npy")

_SEPARATOR = re.compile(r"[,;\s]+")


def read_cloud(path: Path) -> FloatArray:
    """Points (n, 3) of a ``.npy`` array, or of lines with three numbers.

    Numbers are parted by commas, semicolons or blanks; one line of column names may come first;
    ``#`` starts a comment. Words for not-a-number are read as such, to be refused by name later.

    Raises
    ------
    FileError
        A line has not three numbers, or the array not three columns.
    """
    if path.suffix.lower() == ".npy":
        return _read_array(path)
    rows = array("d")
    header_allowed = True
    try:
        with path.open(encoding="utf-8-sig") as stream:
            for number, line in watched_lines(stream, path):
                text = line.partition("#")[0].strip()
                if not text:
                    continue
                row = _row(text)
                if row is not None:
                    rows.extend(row)
                elif not (header_allowed and _is_header(text)):
                    raise _bad_line(path, number, text)
                header_allowed = False
    except UnicodeDecodeError as error:
        raise FileError("the file is not text", where=str(path)) from error
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _row(text: str) -> list[float] | None:
    """The three numbers of a line; None if it has others."""
    try:
        row = [float(field) for field in _SEPARATOR.split(text)]
    except ValueError:
        return None
    return row if len(row) == 3 else None


def _is_header(text: str) -> bool:
    """Whether a line that is not three numbers has three words."""
    return len(_SEPARATOR.split(text)) == 3


def _bad_line(path: Path, number: int, text: str) -> FileError:
    return FileError(
        "a cloud has three numbers in a line",
        where=f"{path}, line {number}",
        found=text[:80],
        allowed="x, y, z",
    )


def _read_array(path: Path) -> FloatArray:
    try:
        # Mapped, an array takes no more memory than the file has, whatever its head claims.
        table = np.lib.format.open_memmap(path, mode="r")
    except Exception as error:  # a damaged head fails in ways of Python's own parser
        raise FileError(
            "not a plain NumPy array", where=str(path), allowed="an .npy file of shape (n, 3)"
        ) from error
    if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind not in "iuf":
        raise FileError(
            "a cloud has three columns of numbers",
            where=str(path),
            found=f"shape {table.shape} of {table.dtype}",
            allowed="shape (n, 3)",
        )
    return np.array(table, dtype=np.float64, order="C")
