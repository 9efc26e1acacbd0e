"""Checks of a user's tables: rows of numbers whose first column rises."""

from __future__ import annotations

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.records import FloatArray


def is_number(curve: object) -> TypeGuard[float]:
    """Return whether a curve is given by one number, which may be an array without axes."""
    if isinstance(curve, np.ndarray) and curve.ndim == 0:
        curve = curve[()]
    return isinstance(curve, int | float | np.number) and not isinstance(curve, bool)


def table_of(
    rows: object,
    columns: tuple[str, ...],
    *,
    where: str = "table",
    at_least: int = 1,
    allowed: str | None = None,
) -> FloatArray:
    """Return a copy of rows (n, m) of finite numbers whose first column is strictly increasing.

    Parameters
    ----------
    rows : the user's table
    columns : names of the m columns, the first "t" for times
    where : name of the table in errors
    at_least : smallest n
    allowed : description of valid rows in errors; made from `columns` if omitted

    Raises
    ------
    InputError
        Rows that are not numbers or of several lengths, another number of columns, too few rows, a
        number that is not finite, a first column that does not rise.
    """
    allowed = allowed or f"rows [{', '.join(columns)}], {columns[0]} strictly increasing"
    real(rows, where)
    try:
        table = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a table must be rows of numbers, all of the same length",
            where=where,
            found=rows,
            allowed=allowed,
        ) from error
    if table.ndim != 2 or table.shape[1] != len(columns) or len(table) < at_least:
        count = "one row" if at_least == 1 else f"{at_least} rows"
        raise InputError(
            f"a table must have {len(columns)} columns and at least {count}",
            where=where,
            found=table.shape,
            allowed=allowed,
        )
    if not np.isfinite(table).all():
        row = int(np.flatnonzero(~np.isfinite(table).all(axis=1))[0])
        raise InputError(
            f"row {row} is not finite", where=where, found=table[row].tolist(), allowed=allowed
        )
    check_rises(table[:, 0], columns[0], where, allowed)
    return table


def check_rises(values: FloatArray, name: str, where: str, allowed: str | None = None) -> None:
    """Refuse values (n,) that are not strictly increasing; the name "t" stands for times.

    Raises
    ------
    InputError
        A value is not above the previous one.
    """
    falls = np.flatnonzero(np.diff(values) <= 0.0)
    if falls.size:
        row, plural = int(falls[0]), "times" if name == "t" else f"values of {name}"
        raise InputError(
            f"the {plural} go back or repeat at row {row + 1}",
            where=where,
            found=values[row : row + 2].tolist(),
            allowed=allowed or f"strictly increasing {plural}",
        )


def check_never_falls(table: FloatArray, columns: tuple[str, str], where: str) -> None:
    """Refuse rows (n, 2) whose second column falls or begins below zero.

    Raises
    ------
    InputError
        A value is below the previous one, or the first value below zero.
    """
    first, second = columns
    allowed = f"rows [{first}, {second}], the {second} from zero or above and never falling"
    falls = np.flatnonzero(np.diff(table[:, 1]) < 0.0)
    if falls.size:
        row = int(falls[0])
        raise InputError(
            f"the {second} falls at row {row + 1}",
            where=where,
            found=table[row : row + 2, 1].tolist(),
            allowed=allowed,
        )
    if table[0, 1] < 0.0:
        raise InputError(
            "must not be negative", where=where, found=float(table[0, 1]), allowed=allowed
        )


def as_times(times: ArrayLike, count: int) -> FloatArray:
    """Return `count` ≥ 1 finite times (count,), strictly increasing.

    Raises
    ------
    InputError
        Another number of times, a time that is not finite or not above the previous one.
    """
    instants = np.asarray(real(times, "times"), dtype=np.float64)
    if instants.shape != (count,) or count == 0 or not np.isfinite(instants).all():
        raise InputError(
            "expected one finite time for each row, and at least one row",
            where="times",
            found=instants.shape,
            allowed=f"({max(count, 1)},)",
        )
    check_rises(instants, "t", "table")
    return instants
