"""Work memory of kernels, kept by the thread from one call to the next."""

from __future__ import annotations

import threading
from math import ceil

import numpy as np

from contiga.records import FloatArray

MAX_KEPT_ROWS = 2**19
"""Number of rows above which memory is released: new pages are cheap compared with the work."""
FLOAT_SIZE = 8
"""Bytes of a float64."""
PAGE_SIZE = 2**21
"""Bytes of a huge page, if the system has them; a multiple of a cache line in any case."""


class Workspace(threading.local):
    """Uninitialised tables, one for each number of columns and each thread.

    Each is aligned to a huge page and takes at least one, for which NumPy asks the system (from
    4 MiB on): random rows on small pages would miss the TLB, and scattered pages evict each other
    from a cache that has room for all. In one process of three that was a tenth of a tracked point.
    """

    def __init__(self) -> None:
        self._tables: dict[int, FloatArray] = {}

    def rows(self, n: int, columns: int) -> FloatArray:
        """Return a table (n, columns) with any contents; the thread may use it until the next call.

        It is a view of the last table of as many columns if that has n rows, else new memory, which
        is kept if n is at most `MAX_KEPT_ROWS`.
        """
        table = self._tables.get(columns)
        if table is None or len(table) < n:
            size = max(n, ceil(PAGE_SIZE / (FLOAT_SIZE * columns))) * columns
            memory = np.empty(size + PAGE_SIZE // FLOAT_SIZE)
            start = -memory.ctypes.data % PAGE_SIZE // FLOAT_SIZE
            table = memory[start : start + size].reshape(-1, columns)
            if n <= MAX_KEPT_ROWS:
                self._tables[columns] = table
        return table[:n]
