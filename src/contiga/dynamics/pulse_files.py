"""Pulses from CSV files, whose columns say their units, in the units of a case."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from contiga.errors import FileError
from contiga.io.sheet import Sheet, read_sheet, unit_of
from contiga.io.units import acceleration_factor, time_factor, velocity_factor
from contiga.records import FloatArray

_HEADER = "t [ms], a [g]"


def read_pulse(
    path: str | Path,
    *,
    units: tuple[str, str],
    columns: Sequence[str] | None = None,
    time_unit: str | None = None,
    unit: str | None = None,
    quantity: Literal["velocity", "acceleration"] = "acceleration",
) -> FloatArray:
    """The table of a pulse from a CSV file: rows t, a or t, ax, ay, az (or velocities).

    The first line names the columns, with their units in brackets where they have some:
    ``t [ms], a [g]`` or ``time (s), acc (m/s^2)``. Commas, semicolons or tabs part them. A column
    without a unit is in `time_unit` or `unit`; without these it is in the units of the case.

    Parameters
    ----------
    units : length and time unit of the case, such as ("mm", "ms")
    columns : names of the time's column and of one or three others, with or without their
        units; needed where the file has not two or four
    time_unit, unit : of the times and of the values, where the header does not say them
    quantity : what the values are, which says what units they may have

    Returns
    -------
    (n, 2) or (n, 4) float64, in the units of the case

    Raises
    ------
    FileError
        The file is missing or unreadable, has no header, lacks a column, or says another unit than
        the caller; a cell is not a finite number, times do not increase. With file and line.
    UnitError
        A unit is none of time, or of the quantity.
    InputError
        `columns` are not two or four.
    """
    sheet = read_sheet(Path(path), _HEADER)
    sheet.check_header(_HEADER)
    order = sheet.order(columns, (2, 4), "a time and one or three values")
    where = f"{path}:{sheet.line}"
    length, time = units
    factors = [1.0] * len(order)
    for i, k in enumerate(order):
        said = unit_of(sheet.head(k)[1], time_unit if i == 0 else unit, where)
        if said is None:
            continue
        if i == 0:
            factors[0] = time_factor(said, time, where)
        elif quantity == "velocity":
            factors[i] = velocity_factor(said, length, time, where)
        else:
            factors[i] = acceleration_factor(said, length, time, where)
    table = sheet.numbers(order, "a number in each of " + ", ".join(sheet.names[k] for k in order))
    _check_rows(table, sheet)
    return np.asarray(table * factors)


def _check_rows(table: FloatArray, sheet: Sheet) -> None:
    """Refuse the first row that is not finite or does not go on in time, with its line."""
    if len(table) == 0:
        raise FileError("there are no rows under the header", where=str(sheet.path))
    finite = np.asarray(np.isfinite(table).all(axis=1))
    later = np.append(True, np.diff(table[:, 0]) > 0.0)
    wrong = np.flatnonzero(~(finite & later))
    if wrong.size:
        k = int(wrong[0])
        number, line = sheet.rows[k]
        raise FileError(
            "the times must increase from row to row" if finite[k] else "a number is not finite",
            where=f"{sheet.path}:{number}",
            found=line,
        )
