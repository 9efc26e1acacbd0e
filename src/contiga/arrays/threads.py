"""Run kernels that release the GIL over ranges of rows on a few threads.

The rows are split into ranges, which the threads take when they are free. Every kernel treats its
rows one by one, so that results have the same bits for any number of threads. The number of threads
is numba's (NUMBA_NUM_THREADS, all cores by default; less after `numba.set_num_threads`). The
calling thread works, too.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import lru_cache
from math import ceil
from typing import Any, TypeVar

import numba
from numba.np.ufunc import parallel

RANGES_PER_THREAD = 6

_local = threading.local()
T = TypeVar("T")
R = TypeVar("R")


def thread_count() -> int:
    """Return the number of threads that kernels run on; 1 inside one of these threads.

    >>> thread_count() >= 1
    True
    """
    if getattr(_local, "busy", False):
        return 1
    # Asking numba would start its threads; before they exist nobody has set their number.
    if getattr(parallel, "_is_initialized", True):
        return int(numba.get_num_threads())
    return int(numba.config.NUMBA_NUM_THREADS)


@lru_cache(maxsize=1)
def _helpers() -> ThreadPoolExecutor:
    """Return the helper threads beside the calling ones; each starts when there is work for it."""
    count = max(int(numba.config.NUMBA_NUM_THREADS) - 1, 1)
    # All are busy always: a job that waits for others of the same helpers could wait for ever.
    is_busy = (_local, "busy", True)
    return ThreadPoolExecutor(count, "contiga", initializer=setattr, initargs=is_busy)


# Threads do not survive in a forked process: it starts its own.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)


def run_ranges(kernel: Callable[..., Any], n: int, grain: int, *args: Any) -> None:
    """Call ``kernel(*args, start, stop)`` for ranges of rows that make up 0 … n − 1; wait for all.

    Ranges have at least `grain` rows, and start at multiples of it: with fewer a thread costs more
    than it saves. Up to `grain` rows, or with one thread, are one call. An error of a call drops
    the ranges that no thread has begun, and is raised.
    """
    if n <= grain or (threads := thread_count()) == 1:
        if n:
            kernel(*args, 0, n)
        return
    grains = ceil(n / grain)
    step = ceil(grains / min(threads * RANGES_PER_THREAD, grains)) * grain
    starts = deque(range(0, n, step))

    def work() -> None:
        try:
            while (start := _next_start(starts)) is not None:
                kernel(*args, start, min(start + step, n))
        finally:
            starts.clear()  # an error ends the other threads, too

    jobs: list[Future[None]] = []
    try:
        _local.busy = True
        with suppress(RuntimeError):  # Python is ending: this thread does all
            for _ in range(min(threads, len(starts)) - 1):
                jobs.append(_helpers().submit(work))
        work()
    finally:
        _local.busy = False
        starts.clear()
        # Cancel the jobs that have not begun.
        jobs = [job for job in jobs if not job.cancel()]
        wait(jobs)
    for job in jobs:
        job.result()


def _next_start(starts: deque[int]) -> int | None:
    """Remove and return the next start, which no other thread takes; None if there is none."""
    try:
        return starts.popleft()
    except IndexError:
        return None


def map_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Return ``[function(item) for item in items]``, computed on the threads in any order.

    Calls must be independent; an error of one is raised.
    """
    inputs = list(items)
    results: dict[int, R] = {}

    def call_range(start: int, stop: int) -> None:
        for k in range(start, stop):
            results[k] = function(inputs[k])

    run_ranges(call_range, len(inputs), 1)
    return [results[k] for k in range(len(inputs))]


def started(kernel: Callable[..., R], n: int, grain: int, *args: Any) -> Callable[[], R]:
    """Start ``kernel(*args)`` in a helper thread; return a function that waits for its result.

    With one thread, or if its n rows are no more than `grain`, it runs here before this returns.
    """
    if n > grain and thread_count() > 1:
        with suppress(RuntimeError):  # Python is ending: this thread does it
            return _helpers().submit(kernel, *args).result
    result = kernel(*args)
    return lambda: result
