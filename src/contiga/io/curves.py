"""Curves in files: columns of CSV files, and ``*DEFINE_CURVE`` of LS-DYNA keyword decks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contiga.errors import FileError, InputError
from contiga.io.mesh.lsdyna import SUFFIXES
from contiga.io.mesh.lsdyna_curves import read_curve_of_deck
from contiga.io.sheet import read_sheet
from contiga.io.units import Quantity, Units, quantity_factor
from contiga.records import FloatArray

_HEADER = "strain [1], stress [MPa]"


def read_curve(
    path: str | Path,
    kinds: tuple[Quantity, Quantity],
    case: Units,
    *,
    columns: Sequence[str] | None = None,
    curve: int | None = None,
    units: Sequence[str] | None = None,
) -> FloatArray:
    """Return a curve of a file, in the units of a case.

    Parameters
    ----------
    path : a CSV file, whose first line names the columns, or a keyword deck (.k, .key, .dyn)
    kinds : quantities of abscissa and ordinate
    case : length, mass and time unit of the case
    columns : names of abscissa and ordinate, for a CSV file with other than two columns
    curve : number of the ``*DEFINE_CURVE``, for a deck with several
    units : units of abscissa and ordinate; of the case if omitted. A header may have its own

    Returns
    -------
    (n, 2) float64
        Finite points in the order of the file, n >= 2; whether abscissae rise is not checked.

    Raises
    ------
    FileError
        The file cannot be read, has no such columns or curve, a header with other units than
        `units`, or fewer than two finite points.
    MeshError
        A field of a deck that should be a number is not one.
    UnitError
        A unit is not one of its quantity.
    InputError
        `columns` for a deck, `curve` for a CSV file, or not two units.
    """
    path = Path(path)
    curve_units: Sequence[str | None] = (None, None) if units is None else units
    if len(curve_units) != 2:
        raise InputError(
            "must name two units", where="units", found=units, allowed='such as ["1", "MPa"]'
        )
    if path.suffix.lower() in SUFFIXES:
        if columns is not None:
            raise InputError(
                "only a CSV file has columns", where="columns", found=columns, allowed="curve = …"
            )
        table = read_curve_of_deck(path, curve)
        factors = [
            1.0 if unit is None else quantity_factor(unit, kind, case, "units")
            for unit, kind in zip(curve_units, kinds, strict=True)
        ]
        return np.asarray(_checked(table.table, table.where) * factors)
    if curve is not None:
        raise InputError(
            "only a keyword deck has numbered curves",
            where="curve",
            found=curve,
            allowed="a file that ends in " + ", ".join(SUFFIXES),
        )
    sheet = read_sheet(path, _HEADER)
    sheet.check_header(_HEADER)
    order = sheet.order(columns, (2,), "abscissa and ordinate")
    return _checked(sheet.numbers(order, kinds, case, curve_units).table, str(path))


def _checked(table: FloatArray, where: str) -> FloatArray:
    if len(table) < 2 or not np.isfinite(table).all():
        raise FileError(
            "a curve needs two finite points or more", where=where, found=f"{len(table)} rows"
        )
    return table
