"""History tables: CSV with a header, a row for each step, numbers that read back exactly.

Heads have name and unit, ``force [N]``, like pulse files: a history can serve as a pulse.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.errors import FileError, InputError
from contiga.io.out.files import atomic_write
from contiga.io.sheet import read_sheet

_HEAD = re.compile(r"(.+) \[[^\[\]]+\]")
# Without a byte order mark spreadsheets assume their own code page.
_ASCII = str.maketrans({"²": "^2", "³": "^3", "·": "*"})


def write_history(
    path: str | Path,
    columns: Mapping[str, ArrayLike],
    units: Mapping[str, str] | None = None,
) -> None:
    """Write columns of equal length as CSV, whole or not at all; an older file is replaced.

    Floats are written with the fewest digits that read back as the same number, integers and
    truth values as integers. Units are written in ASCII: ``m/s^2`` for m/s².

    Parameters
    ----------
    path : the CSV file
    columns : (n,) numbers by name
    units : units of columns by name, for the header; without a unit, or with "", only the name

    Raises
    ------
    InputError
        No columns, a column that is not one number a row, or columns of different lengths.
    OutputError
        The file cannot be written.
    """
    arrays = {}
    for name, values in columns.items():
        array = np.asarray(values)
        if array.dtype == np.bool_:
            array = array.astype(np.int64)
        if array.ndim != 1 or array.dtype.kind not in "iuf":
            raise InputError(
                f"column {name!r} must hold one number a row",
                found=f"shape {array.shape} of {array.dtype}",
                allowed="shape (n,)",
            )
        # The digits of a single-precision number are those of its exact double.
        arrays[name] = array.astype(np.float64) if array.dtype.kind == "f" else array
    lengths = {name: len(array) for name, array in arrays.items()}
    if not arrays or len(set(lengths.values())) > 1:
        raise InputError("a history needs columns, all of one length", found=lengths)
    # repr of a Python float is the shortest text that reads back exactly.
    texts = [[repr(value) for value in array.tolist()] for array in arrays.values()]
    heads = []
    for name in arrays:
        unit = (units or {}).get(name, "").translate(_ASCII)
        heads.append(f"{name} [{unit}]" if unit else name)
    with (
        atomic_write(path) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(zip(*texts, strict=True))


def read_history(path: str | Path) -> dict[str, NDArray[Any]]:
    """Return columns (n,) by name, without units: int64 if every entry is whole, else float64.

    A column without rows is float64. NaN and infinity are read.

    Raises
    ------
    FileError
        Missing, without a row of names, two columns of one name, a row that is too short or too
        long, or an entry that is no number.
    """
    path = Path(path)
    sheet = read_sheet(path, "time [ms],force [N]", marks=(",",))
    names = [
        match[1] if (match := _HEAD.fullmatch(head.text)) else head.text for head in sheet.heads
    ]
    if not names:
        raise FileError("a history starts with a row of names", where=str(path))
    if len(set(names)) < len(names):
        raise FileError("column names must differ", where=str(path), found=names)
    rows = list(sheet.rows)
    for row in rows:
        if len(row.cells) < len(names):
            raise FileError(
                "a row does not fit the header",
                where=f"{path}, row {row.line}",
                found=f"{len(row.cells)} entries",
                allowed=f"{len(names)}",
            )
    texts = zip(*(row.cells for row in rows), strict=True) if rows else [()] * len(names)
    columns: dict[str, NDArray[Any]] = {}
    for name, column in zip(names, texts, strict=True):
        if column:
            with suppress(ValueError, OverflowError):
                columns[name] = np.array([int(text) for text in column], dtype=np.int64)
                continue
        try:
            columns[name] = np.array([float(text) for text in column], dtype=np.float64)
        except ValueError as error:
            raise FileError(
                f"column {name!r} has an entry that is not a number: {error}", where=str(path)
            ) from error
    return columns
