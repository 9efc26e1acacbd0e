"""Points that are settled by one call of a kernel for a chunk of them: nearly all of a step.

Their sides and feet, and balls that touch there, tell what becomes of them, or their closest
points, where they lie deeper. Those that are left are looked at one by one (`nearest`, `followed`),
as all are of surfaces whose tables kernels do not have.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import ceil
from typing import Any

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.contact.kernels import settle_nb
from contiga.contact.search_records import Rows, StepSearch
from contiga.contact.settle_records import DeepRows, Work
from contiga.jit import straight
from contiga.records import IntArray
from contiga.search.certify.neighbourhoods import with_neighbourhoods
from contiga.search.track.project import rows_of_a_chunk

DEEP = 256
"""Rows of a chunk whose closest points are asked for, which take a hundred times as long."""
Settle = Callable[[IntArray, Work, IntArray], int]
"""Settles rows, working in memory, and lists those left; how many."""


class ThreadMemory(threading.local):
    """Memory for rows whose feet are certified or not, and for deep ones, kept by the thread."""

    def __init__(self) -> None:
        self._work: dict[bool, Work] = {}
        self.deep = DeepRows.of(DEEP)

    def of(self, n: int, certify: bool) -> Work:
        """Memory for n rows at least, the thread's until it asks for the next."""
        work = self._work.get(certify)
        if work is None or len(work.rows) < n:
            work = self._work[certify] = Work.of(n, certify)
        return work


_memory = ThreadMemory()


def left(search: StepSearch, rows: Rows) -> Rows:
    """Settle the usual ones of `rows`; returns the others."""
    surface, step, feet, detected, options, _ = search
    followed = not options.nearest
    tells = options.balls and (options.closed or not followed)
    tables = surface.contact_tables if tells else None
    if tables is None:
        return rows
    if followed:
        tables = tables._replace(body=with_neighbourhoods(tables.body))
    limits = options.limits
    touching, free = rows
    if len(touching):
        kernel = straight(settle_nb.settle_touching)

        def settle(some: IntArray, work: Work, left: IntArray) -> int:
            return int(kernel(tables, step, feet, some, limits, work, detected, left))

        size = rows_of_a_chunk(len(touching), surface.n_elements)
        touching = _left(settle, touching, size, followed)
    if len(touching) and not followed:
        deep_kernel = straight(settle_nb.settle_deep)

        def settle_deep(some: IntArray, work: Work, left: IntArray) -> int:
            deep = _memory.deep
            return int(deep_kernel(tables, step, feet, some, limits, work, deep, detected, left))

        touching = _left(settle_deep, touching, DEEP, False)
    if len(free) and options.closed:
        free_kernel = straight(settle_nb.settle_free)

        def settle_free(some: IntArray, work: Work, left: IntArray) -> int:
            return int(free_kernel(tables, step, some, limits, work, detected, left))

        size = rows_of_a_chunk(len(free), surface.n_elements)
        free = _left(settle_free, free, size, False)
    return Rows(touching, free)


def _left(settle: Settle, rows: IntArray, size: int, certify: bool) -> IntArray:
    """The rows that are left, ascending, of chunks of `size` rows."""
    n = len(rows)
    left = np.empty(n, np.int32)
    if n <= size:
        return left[: settle(rows, _memory.of(n, certify), left)]
    parts: list[Any] = [None] * ceil(n / size)

    def chunks(first: int, last: int) -> None:
        for c in range(first, last):
            chunk = slice(c * size, (c + 1) * size)
            count = settle(rows[chunk], _memory.of(size, certify), left[chunk])
            parts[c] = left[chunk][:count]

    run_ranges(chunks, len(parts), 1)
    return np.concatenate(parts)
