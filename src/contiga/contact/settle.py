"""Settle nearly all points of a step by kernels, one call for each chunk of points.

The kernels decide by the side of a point, its continued foot and the ball that touches there, or by
its closest point if it lies deeper. The remaining points are left to `nearest` or `followed`, as
are all points on surfaces without tables for kernels.
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
from contiga.search.track.project import rows_per_chunk

DEEP_CHUNK = 256
"""Rows of a chunk whose closest points are searched, which takes a hundred times as long."""
Settle = Callable[[IntArray, Work, IntArray], int]
"""Function that settles rows with work arrays, lists the unsettled ones, returns their number."""


class ThreadMemory(threading.local):
    """Work arrays of each thread, for rows with certified feet or not, and for deep rows."""

    def __init__(self) -> None:
        self._work: dict[bool, Work] = {}
        self.deep = DeepRows.of(DEEP_CHUNK)

    def of(self, n: int, certify: bool) -> Work:
        """Return work arrays for at least n rows, valid until the thread's next call."""
        work = self._work.get(certify)
        if work is None or len(work.rows) < n:
            work = self._work[certify] = Work.of(n, certify)
        return work


_memory = ThreadMemory()


def settle_points(search: StepSearch, rows: Rows) -> Rows:
    """Write results of points that kernels can decide into `search.detected`; return the others.

    These are ascending; they are all of `rows` if the surface has no tables, or balls are not used,
    or feet are tracked on an open body. On an open body free points are not settled.
    """
    surface, step, feet, detected, options, _ = search
    tracked = not options.nearest
    has_kernels = options.balls and (options.closed or not tracked)
    tables = surface.contact_tables if has_kernels else None
    if tables is None:
        return rows
    if tracked:
        tables = tables._replace(body=with_neighbourhoods(tables.body))
    limits = options.limits
    touching, free = rows
    if len(touching):
        kernel = straight(settle_nb.settle_touching)

        def settle(chunk: IntArray, work: Work, unsettled: IntArray) -> int:
            return int(kernel(tables, step, feet, chunk, limits, work, detected, unsettled))

        size = rows_per_chunk(len(touching), surface.n_elements)
        touching = _settle_chunks(settle, touching, size, tracked)
    if len(touching) and not tracked:
        deep_kernel = straight(settle_nb.settle_deep)

        def settle_deep(chunk: IntArray, work: Work, unsettled: IntArray) -> int:
            memory = limits, work, _memory.deep
            return int(deep_kernel(tables, step, feet, chunk, *memory, detected, unsettled))

        touching = _settle_chunks(settle_deep, touching, DEEP_CHUNK, False)
    if len(free) and options.closed:
        free_kernel = straight(settle_nb.settle_free)

        def settle_free(chunk: IntArray, work: Work, unsettled: IntArray) -> int:
            return int(free_kernel(tables, step, chunk, limits, work, detected, unsettled))

        size = rows_per_chunk(len(free), surface.n_elements)
        free = _settle_chunks(settle_free, free, size, False)
    return Rows(touching, free)


def _settle_chunks(settle: Settle, rows: IntArray, size: int, certify: bool) -> IntArray:
    """Settle `rows` in chunks of `size`, over threads; return the unsettled ones, ascending."""
    n = len(rows)
    unsettled = np.empty(n, np.int32)
    if n <= size:
        return unsettled[: settle(rows, _memory.of(n, certify), unsettled)]
    parts: list[Any] = [None] * ceil(n / size)

    def settle_range(first: int, last: int) -> None:
        for c in range(first, last):
            chunk = slice(c * size, (c + 1) * size)
            count = settle(rows[chunk], _memory.of(size, certify), unsettled[chunk])
            parts[c] = unsettled[chunk][:count]

    run_ranges(settle_range, len(parts), 1)
    return np.concatenate(parts)
