"""Bare clouds: three columns of numbers in a text file or a NumPy array."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from contiga.errors import FileError
from contiga.io.mesh.raw import RawMesh
from contiga.io.sheet import as_number, read_sheet

SUFFIXES = (".csv", ".xyz", ".txt", ".npy")

_SEPARATORS = (";", ",", " ")
_MAX_LINE_LENGTH = 10_000


def read_cloud(path: Path) -> RawMesh:
    """Return the points of a ``.npy`` array, or of lines with three numbers.

    Semicolons, commas or blanks separate the numbers; one line of names may come first, which may
    state a unit, ``x [mm], y [mm], z [mm]``; ``#`` starts a comment. NaN and infinity are read; the
    check of the points refuses them later, with their row.

    Raises
    ------
    FileError
        A line does not have three numbers, or is too long; the array does not have the shape
        (n, 3) or is not of real numbers; the names have several units.
    """
    if path.suffix.lower() == ".npy":
        try:
            # A mapped array takes no more memory than the file has, whatever its header claims.
            table = np.lib.format.open_memmap(path, mode="r")
        except Exception as error:  # a damaged header raises errors of Python's parser
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
        return RawMesh(np.array(table, dtype=np.float64, order="C"))
    sheet = read_sheet(path, "x, y, z", marks=_SEPARATORS, comment="#", longest=_MAX_LINE_LENGTH)
    if len(sheet.heads) not in (0, 3):
        raise _bad_line(path, sheet.line, ", ".join(head.text for head in sheet.heads))
    rows = array("d")
    for row in sheet.rows:
        try:
            x, y, z = (as_number(cell, sheet.mark) for cell in row.cells)
        except ValueError:
            raise _bad_line(path, row.line, sheet.mark.join(row.cells)) from None
        rows.extend((x, y, z))
    units = {sheet.unit(k) for k in range(len(sheet.heads))} or {None}
    if len(units) > 1:
        raise FileError(
            "the names of the columns say several units",
            where=sheet.where,
            found=", ".join(head.text for head in sheet.heads),
            allowed="one unit of length, or none",
        )
    return RawMesh(np.array(rows, dtype=np.float64).reshape(-1, 3), unit=units.pop())


def _bad_line(path: Path, number: int, text: str) -> FileError:
    return FileError(
        "a cloud has three numbers in a line",
        where=f"{path}, line {number}",
        found=text[:80],
        allowed="x, y, z",
    )
