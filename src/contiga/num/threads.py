"""Kernels that release the GIL, run over ranges of rows on a few threads.

The rows are cut into ranges that the threads take as they come free. Every kernel treats its rows
one by one, so results are the same bits for any number of threads. The count is numba's own
(environment variable NUMBA_NUM_THREADS, all cores by default).
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache
from math import ceil
from typing import Any, TypeVar

import numba

from contiga.num.heap import keep_freed

RANGES_PER_THREAD = 6

_own = threading.local()
T = TypeVar("T")
R = TypeVar("R")


def thread_count() -> int:
    """Threads the kernels run on; one for what runs on one of them already.

    >>> thread_count() >= 1
    True
    """
    return 1 if getattr(_own, "busy", False) else int(numba.config.NUMBA_NUM_THREADS)


def _begin() -> None:
    # A job that waited for others of the same pool could wait for ever.
    _own.busy = True


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(thread_count(), thread_name_prefix="contiga", initializer=_begin)


keep_freed()  # what a range makes for itself is made again by the next one
# Threads do not live on in a process that was forked off: it makes its own.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)


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
        while (start := _taken(starts)) is not None:
            kernel(*args, start, min(start + step, n))

    # The thread that asks works, too: another wakes up in the time of a thousand points.
    helpers = [_pool().submit(work) for _ in range(min(threads, len(starts)) - 1)]
    try:
        _own.busy = True
        work()
    finally:
        _own.busy = False
        starts.clear()
        wait([helper for helper in helpers if not helper.cancel()])
    for helper in helpers:
        if not helper.cancelled():
            helper.result()


def _taken(starts: deque[int]) -> int | None:
    """The next one, which no other thread takes."""
    try:
        return starts.popleft()
    except IndexError:
        return None


def map_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """``[function(item) for item in items]`` on the threads; each call must stand by itself."""
    if thread_count() == 1:
        return [function(item) for item in items]
    return list(_pool().map(function, items))


def started(kernel: Callable[..., Any], n: int, grain: int, *args: Any) -> Callable[[], Any]:
    """Start ``kernel(*args)`` beside what follows; returns what waits for its result.

    With one thread, or where the n rows it goes through are no more than `grain`, it runs at once.
    """
    if n <= grain or thread_count() == 1:
        result = kernel(*args)
        return lambda: result
    return _pool().submit(kernel, *args).result
