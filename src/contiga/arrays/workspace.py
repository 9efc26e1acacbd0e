"""Memory that kernels work in, kept by the thread from one call to the next."""

from __future__ import annotations

import threading
from math import ceil

import numpy as np

from contiga.records import FloatArray

KEPT = 2**19
"""Rows above which memory is given back: of more the pages cost little beside the work."""
SIZE = 8
"""Bytes of a number."""
PAGE = 2**21
"""Bytes of a large page, where there are such; lines of the memory begin there anyway."""


class Workspace(threading.local):
    """Tables of nothing in particular, one of each number of columns for each thread.

    Each begins with a large page of the memory and takes up one at least, for which NumPy asks the
    system (it does from 4 MiB on): rows at random of small ones would each be looked for by their
    page first, and small pages lie anywhere, so that some of them drive others out of a cache that
    has room for all. In one process of three that was a tenth of a tracked point.
    """

    def __init__(self) -> None:
        self._tables: dict[int, FloatArray] = {}

    def rows(self, n: int, columns: int) -> FloatArray:
        """A table (n, columns), the thread's until it asks for the next."""
        table = self._tables.get(columns)
        if table is None or len(table) < n:
            table = _on_a_page(max(n, ceil(PAGE / (SIZE * columns))), columns)
            if n <= KEPT:
                self._tables[columns] = table
        return table[:n]


def _on_a_page(n: int, columns: int) -> FloatArray:
    memory = np.empty(n * columns + PAGE // SIZE)
    start = -memory.ctypes.data % PAGE // SIZE
    return memory[start : start + n * columns].reshape(n, columns)
