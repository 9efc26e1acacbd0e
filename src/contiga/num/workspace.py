"""Memory that kernels work in, kept by the thread from one call to the next."""

from __future__ import annotations

import threading

import numpy as np

from contiga.num.prefetch import LINE
from contiga.records import FloatArray

KEPT = 2**19
"""Rows above which memory is given back: of more the pages cost little beside the work."""
SIZE = 8
"""Bytes of a number."""


class Workspace(threading.local):
    """Tables of nothing in particular, one of each number of columns for each thread.

    NumPy asks the system for large pages for those that are large: rows at random of small ones
    would each be looked for by their page first. A table starts with a line of the memory.
    """

    def __init__(self) -> None:
        self._tables: dict[int, FloatArray] = {}

    def rows(self, n: int, columns: int) -> FloatArray:
        """A table (n, columns), the thread's until it asks for the next."""
        table = self._tables.get(columns)
        if table is None or len(table) < n:
            table = _on_a_line(n, columns)
            if n <= KEPT:
                self._tables[columns] = table
        return table[:n]


def _on_a_line(n: int, columns: int) -> FloatArray:
    memory = np.empty(n * columns + LINE // SIZE)
    start = -memory.ctypes.data % LINE // SIZE
    return memory[start : start + n * columns].reshape(n, columns)
