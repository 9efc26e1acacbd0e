"""Arrays of which only some rows are worth keeping: those of points in contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray, IndexArray


class Sparse(NamedTuple):
    """(n, …) of which `rows` (k,), ascending, have `values` (k, …), and the others are `base`.

    >>> some = Sparse(4, np.array([1, 3]), np.array([5.0, 0.0]))
    >>> some.whole().tolist(), some.at(np.array([0, 1])).tolist()
    ([0.0, 5.0, 0.0, 0.0], [0.0, 5.0])
    """

    n: int
    rows: IndexArray
    values: FloatArray
    base: FloatArray | None = None
    """(n, …), zeros if omitted."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Of all of it."""
        return self.n, *self.values.shape[1:]

    def whole(self) -> FloatArray:
        """(n, …) all of it."""
        whole = np.zeros(self.shape) if self.base is None else self.base.copy()
        whole[self.rows] = self.values
        return whole

    def at(self, rows: IndexArray) -> FloatArray:
        """(len(rows), …) some rows of one without a base."""
        if len(rows) == len(self.rows) and (rows == self.rows).all():
            return np.array(self.values)
        out = np.zeros((len(rows), *self.values.shape[1:]))
        if len(self.rows):
            place = np.minimum(np.searchsorted(self.rows, rows), len(self.rows) - 1)
            there = self.rows[place] == rows
            out[there] = self.values[place[there]]
        return out
