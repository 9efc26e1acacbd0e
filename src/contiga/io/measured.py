"""Measured curves: columns of csv files, and channels of ISO-MME tests."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contiga.errors import FileError, InputError, UnitError
from contiga.io.out.iso_mme import read_mme
from contiga.io.sheet import check_times, read_sheet
from contiga.io.units import Quantity, Units, quantity_factor
from contiga.records import FloatArray

_HEADER = "t [ms], force [kN]"
_MME = re.compile(r"\.(mme|\d{3})", re.IGNORECASE)

_COLUMN_MEANINGS = {2: "an abscissa and a value", 3: "an abscissa, a lower and an upper value"}


def read_measured(
    path: str | Path,
    kinds: Sequence[Quantity],
    case: Units,
    *,
    columns: Sequence[str] | None = None,
    code: str | None = None,
    units: tuple[str | None, str | None] = (None, None),
) -> FloatArray:
    """Return a measured curve in the units of a case.

    Parameters
    ----------
    path : csv file whose first line names the columns, with units there or in a second line; or
        the file of an ISO-MME channel (``T1.001``), or of an ISO-MME test (``T1.mme``)
    kinds : quantity of the abscissa and of each value
    case : length, mass and time unit of the case
    columns : names of the abscissa and of the values, for a csv file with more columns
    code : code of the channel of a test, or its first characters
    units : units of the abscissa and of the values, where the file does not give them

    Returns
    -------
    (n, 1 + k) float64
        Abscissa and values, n >= 2; an abscissa that is time increases, any other need not.

    Raises
    ------
    FileError
        The file cannot be read, lacks a column or the channel, has an entry that is not a finite
        number, or times that do not increase, with file and line; a channel for a curve that is
        not one value over time.
    UnitError
        A unit is missing, or is not one of its quantity.
    InputError
        `columns` for an ISO-MME test, or `code` for a csv file.
    """
    path = Path(path)
    if _MME.fullmatch(path.suffix):
        if columns is not None:
            raise InputError(
                "only a csv file has columns", where="columns", found=columns, allowed="code = …"
            )
        if len(kinds) != 2 or kinds[0] != "time":
            raise FileError(
                "a channel of ISO-MME is a curve of one value over time", where=str(path)
            )
        channel = read_mme(path, code)
        unit = channel.unit or units[1]
        if not unit:
            raise UnitError("the channel has no unit", where=str(path), allowed="unit = …")
        times = channel.start + channel.interval * np.arange(len(channel.values))
        times = times * quantity_factor("s", "time", case)
        factor = quantity_factor(unit, kinds[1], case, str(path))
        return np.column_stack([times, channel.values * factor])
    if code is not None:
        raise InputError("only an ISO-MME test has codes", where="code", found=code)
    sheet = read_sheet(path, _HEADER)
    sheet.check_header(_HEADER)
    sheet = sheet.with_unit_row()
    order = sheet.order(columns, (len(kinds),), _COLUMN_MEANINGS[len(kinds)])
    column_units = [units[0], *[units[1]] * (len(kinds) - 1)]
    for k, unit in zip(order, column_units, strict=True):
        if sheet.unit(k, unit) is None:
            raise UnitError(
                "the column has no unit",
                where=sheet.where,
                found=sheet.heads[k].text,
                allowed=f"a header such as {_HEADER}, or "
                + ("x_unit" if k == order[0] else "unit")
                + " = …",
            )
    table, lines = sheet.numbers(order, list(kinds), case, column_units)
    if len(table) < 2:
        raise FileError("a curve needs two rows or more", where=str(path), found=len(table))
    if kinds[0] == "time":
        check_times(table[:, 0], lines, path)
    return table
