"""Curves of materials: tables of straight pieces that begin at zero and do not fall."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.records import FloatArray

CurveLike: TypeAlias = float | ArrayLike
ROWS = "a modulus > 0, or rows [strain, stress] from [0, 0], strain rising, stress not falling"


def as_table(curve: CurveLike, name: str) -> FloatArray:
    """(n, 2) strain and stress of a table, or of a modulus.

    Raises
    ------
    InputError
        Not a table of numbers, not from zero, strains that do not rise, stresses that fall.
    """
    real(curve, name)
    try:
        table = np.array(curve, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("must be numbers", where=name, allowed=ROWS) from error
    if table.ndim == 0:
        table = np.array([[0.0, 0.0], [1.0, float(table)]])
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        raise InputError("is no table", where=name, found=table.shape, allowed=ROWS)
    if not np.isfinite(table).all():
        raise InputError("must be finite", where=name, allowed=ROWS)
    if table[0].any():
        raise InputError("must begin at zero", where=name, found=table[0].tolist(), allowed=ROWS)
    for column, what, wrong in (
        (0, "strain does not rise", np.diff(table[:, 0]) <= 0.0),
        (1, "stress falls", np.diff(table[:, 1]) < 0.0),
    ):
        if wrong.any():
            row = int(np.argmax(wrong))
            pair = table[row : row + 2, column].tolist()
            raise InputError(f"{what} at row {row + 1}", where=name, found=pair, allowed=ROWS)
    if table[-1, 1] <= 0.0:
        raise InputError("carries nothing", where=name, found=table.tolist(), allowed=ROWS)
    return table


def packed(table: FloatArray) -> FloatArray:
    """A table as `curve_nb` has it: x, y and ∫y dx."""
    x, y = table.T
    steps = 0.5 * (y[1:] + y[:-1]) * np.diff(x)
    return np.concatenate([x, y, [0.0], np.cumsum(steps)])


def at(table: FloatArray, x: FloatArray) -> FloatArray:
    """Ordinates of a table at x ≥ 0; its last piece goes straight on."""
    slope = (table[-1, 1] - table[-2, 1]) / (table[-1, 0] - table[-2, 0])
    beyond = np.maximum(x - table[-1, 0], 0.0)
    return np.asarray(np.interp(x, table[:, 0], table[:, 1]) + slope * beyond)


def max_slope(table: FloatArray) -> float:
    """The largest slope of a table."""
    return float(np.max(np.diff(table[:, 1]) / np.diff(table[:, 0])))
