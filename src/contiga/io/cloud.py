"""Bare clouds: three columns of numbers in a text file or a NumPy array."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from contiga.errors import FileError
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
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise FileError("the file is not text", where=str(path)) from error
    rows: list[list[float]] = []
    header_allowed = True
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        fields = _SEPARATOR.split(text)
        try:
            row = [float(field) for field in fields]
        except ValueError as error:
            if header_allowed and len(fields) == 3:
                header_allowed = False
                continue
            raise _bad_line(path, number, text) from error
        if len(row) != 3:
            raise _bad_line(path, number, text)
        header_allowed = False
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _bad_line(path: Path, number: int, text: str) -> FileError:
    return FileError(
        "a cloud has three numbers in a line",
        where=f"{path}, line {number}",
        found=text[:80],
        allowed="x, y, z",
    )


def _read_array(path: Path) -> FloatArray:
    try:
        array = np.load(path, allow_pickle=False)
    except (ValueError, EOFError, OSError) as error:
        raise FileError(
            "not a plain NumPy array", where=str(path), allowed="an .npy file of shape (n, 3)"
        ) from error
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iuf":
        raise FileError(
            "a cloud has three columns of numbers",
            where=str(path),
            found=f"shape {array.shape} of {array.dtype}",
            allowed="shape (n, 3)",
        )
    return np.ascontiguousarray(array, dtype=np.float64)
