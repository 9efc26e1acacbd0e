"""Pulses from CSV files whose columns name their units, converted to the units of a case."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from contiga.errors import FileError
from contiga.io.sheet import check_times, read_sheet
from contiga.io.units import Quantity
from contiga.records import FloatArray

_HEADER = "t [ms], a [g]"
_ANY_MASS = "kg"
"""Mass unit: any will do, since velocities and accelerations have none."""


def read_pulse(
    path: str | Path,
    *,
    units: tuple[str, str],
    columns: Sequence[str] | None = None,
    time_unit: str | None = None,
    unit: str | None = None,
    quantity: Literal["velocity", "acceleration"] = "acceleration",
) -> FloatArray:
    """Read the table of a pulse from a CSV file: rows t, a or t, ax, ay, az (or velocities).

    The first line names the columns, with their units in brackets if they have some:
    ``t [ms], a [g]`` or ``time (s), acc (m/s^2)``, quoted or not. Semicolons, commas, tabs or
    blanks separate columns; numbers may have decimal commas if commas do not separate columns. A
    column without a unit is in `time_unit` or `unit`, or else in the units of the case.

    Parameters
    ----------
    path : the CSV file
    units : length and time unit of the case, such as ("mm", "ms")
    columns : names of the column of times and of one or three others, with or without their
        units; needed unless the file has two or four columns
    time_unit, unit : units of the times and of the values, if the header does not name them
    quantity : quantity of the values, which decides their possible units

    Returns
    -------
    (n, 2) or (n, 4) float64, in the units of the case

    Raises
    ------
    FileError
        The file is missing or unreadable, has no header or no rows, lacks a column, or names
        another unit than the caller; a cell is not a finite number, times do not increase. With
        file and line.
    UnitError
        A unit is not one of time, or of the quantity.
    InputError
        `columns` are not two or four.
    """
    sheet = read_sheet(Path(path), _HEADER)
    sheet.check_header(_HEADER)
    order = sheet.order(columns, (2, 4), "a time and one or three values")
    length, time = units
    kinds: list[Quantity] = ["time", *[quantity] * (len(order) - 1)]
    default_units = [time_unit, *[unit] * (len(order) - 1)]
    table, lines = sheet.numbers(order, kinds, (length, _ANY_MASS, time), default_units)
    if len(table) == 0:
        raise FileError("there are no rows under the header", where=str(path))
    check_times(table[:, 0], lines, path)
    return table
