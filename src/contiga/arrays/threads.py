"""Kernels that release the GIL, run over ranges of rows on a few threads.

The rows are cut into ranges that the threads take as they come free. Every kernel treats its rows
one by one, so results are the same bits for any number of threads. The count is numba's own
(NUMBA_NUM_THREADS, all cores by default; less after `numba.set_num_threads`). The thread that asks
works, too.
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

_own = threading.local()
T = TypeVar("T")
R = TypeVar("R")


def thread_count() -> int:
    """Threads the kernels run on; one for what runs on one of them already.

    >>> thread_count() >= 1
    True
    """
    if getattr(_own, "busy", False):
        return 1
    # To ask numba would start its threads; before they are there nobody has set their number.
    if getattr(parallel, "_is_initialized", True):
        return int(numba.get_num_threads())
    return int(numba.config.NUMBA_NUM_THREADS)


def _begin() -> None:
    # A job that waited for others of the same helpers could wait for ever.
    _own.busy = True


@lru_cache(maxsize=1)
def _helpers() -> ThreadPoolExecutor:
    """Threads beside those that ask; each begins when there is something for it to do."""
    count = max(int(numba.config.NUMBA_NUM_THREADS) - 1, 1)
    return ThreadPoolExecutor(count, thread_name_prefix="contiga", initializer=_begin)


# Threads do not live on in a process that was forked off: it makes its own.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)


def run_ranges(kernel: Callable[..., Any], n: int, grain: int, *args: Any) -> None:
    """Call ``kernel(*args, start, stop)`` until rows 0 … n are done.

    Ranges hold at least `grain` rows, and start at multiples of it: below that a thread costs
    more than it saves.
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
            while (start := _taken(starts)) is not None:
                kernel(*args, start, min(start + step, n))
        finally:
            starts.clear()  # after an error there is nothing to do for the others either

    jobs: list[Future[None]] = []
    try:
        _own.busy = True
        with suppress(RuntimeError):  # Python is ending: this thread does all
            for _ in range(min(threads, len(starts)) - 1):
                jobs.append(_helpers().submit(work))
        work()
    finally:
        _own.busy = False
        starts.clear()
        # Who has not begun by now need not.
        jobs = [job for job in jobs if not job.cancel()]
        wait(jobs)
    for job in jobs:
        job.result()


def _taken(starts: deque[int]) -> int | None:
    """The next one, which no other thread takes."""
    try:
        return starts.popleft()
    except IndexError:
        return None


def map_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """``[function(item) for item in items]`` on the threads; each call must stand by itself."""
    given = list(items)
    results: dict[int, R] = {}

    def some(start: int, stop: int) -> None:
        for k in range(start, stop):
            results[k] = function(given[k])

    run_ranges(some, len(given), 1)
    return [results[k] for k in range(len(given))]


def started(kernel: Callable[..., R], n: int, grain: int, *args: Any) -> Callable[[], R]:
    """Start ``kernel(*args)`` beside what follows; returns what waits for its result.

    With one thread, or where the n rows it goes through are no more than `grain`, it runs at once.
    """
    if n > grain and thread_count() > 1:
        with suppress(RuntimeError):  # Python is ending: this thread does it
            return _helpers().submit(kernel, *args).result
    result = kernel(*args)
    return lambda: result
