"""Tables of motions: rows that are checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.records import FloatArray


def as_table(table: ArrayLike, columns: tuple[str, ...]) -> FloatArray:
    """Rows of finite numbers, one for each of `columns`, the first strictly increasing."""
    allowed = f"rows [{', '.join(columns)}], {columns[0]} strictly increasing"
    real(table, "table")
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
    as_times(rows[:, 0], len(rows), "times" if columns[0] == "t" else f"values of {columns[0]}")
    return rows


def as_times(times: ArrayLike, count: int, called: str = "times") -> FloatArray:
    """Finite numbers (count,), strictly increasing; errors call them so."""
    instants = np.asarray(real(times, "times"), dtype=np.float64)
    if instants.shape != (count,) or count == 0 or not np.isfinite(instants).all():
        raise InputError(
            "expected one finite time for each row, and at least one row",
            where="times",
            found=instants.shape,
            allowed=f"({max(count, 1)},)",
        )
    back = np.flatnonzero(np.diff(instants) <= 0.0)
    if back.size:
        row = int(back[0])
        raise InputError(
            f"the {called} go back or repeat at row {row + 1}",
            where="table",
            found=instants[row : row + 2].tolist(),
            allowed=f"strictly increasing {called}",
        )
    return instants
