"""Curves of materials: tables that begin at zero and do not fall."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from contiga.curves.tables import check_never_falls, is_number, table_of
from contiga.errors import InputError
from contiga.records import FloatArray

CurveLike: TypeAlias = float | ArrayLike
COLUMNS = ("strain", "stress")
ROWS = "a modulus > 0, or rows [strain, stress] from [0, 0], strain rising, stress not falling"


def as_table(curve: CurveLike, name: str) -> FloatArray:
    """Return rows (n, 2) of strain and stress of a table; of a modulus [0, 0] and [1, modulus].

    Raises
    ------
    InputError
        Not a table of numbers, not from zero, strains that do not rise, stresses that fall or are
        zero throughout.
    """
    rows = [[0.0, 0.0], [1.0, curve]] if is_number(curve) else curve
    table = table_of(rows, COLUMNS, where=name, at_least=2, allowed=ROWS)
    if table[0].any():
        raise InputError("must begin at zero", where=name, found=table[0].tolist(), allowed=ROWS)
    check_never_falls(table, COLUMNS, name)
    if table[-1, 1] <= 0.0:
        raise InputError("carries nothing", where=name, found=table.tolist(), allowed=ROWS)
    return table


def max_slope(table: FloatArray) -> float:
    """Return the largest slope of a table (n, 2)."""
    return float(np.max(np.diff(table[:, 1]) / np.diff(table[:, 0])))
