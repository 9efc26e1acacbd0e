"""Kernels that release the GIL, run over ranges of rows on a few threads.

The rows are cut into ranges that the threads take as they come free. Every kernel treats its rows
one by one, so results are the same bits for any number of threads. The count is numba's own
(environment variable NUMBA_NUM_THREADS, all cores by default).

The thread that asks works, too. The others look out for work for a while before they go to sleep:
to wake one up takes as long as to follow hundreds of points, and in a run more work comes soon.
"""

from __future__ import annotations

import atexit
import os
import threading
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from functools import lru_cache
from math import ceil
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

import numba
import numpy as np

from contiga.num.heap import keep_freed
from contiga.num.kernels.watch_nb import watch

RANGES_PER_THREAD = 6
LOOKS = 0 if numba.config.DISABLE_JIT else 8_000
"""How often a thread looks for something before it sleeps: 0.2 ms in all."""
LONGER_FOR_JOBS, LONGER_FOR_ENDS = 400, 150
"""Looks by which helpers, and those who wait for them, look longer: who has put something has to
let go of the GIL first. Who asks for it too soon sleeps until then, and has to be woken up."""

_own = threading.local()
T = TypeVar("T")
R = TypeVar("R")


def thread_count() -> int:
    """Threads the kernels run on; one for what runs on one of them already.

    >>> thread_count() >= 1
    True
    """
    return 1 if getattr(_own, "busy", False) else int(numba.config.NUMBA_NUM_THREADS)


class Mailbox(Generic[T]):
    """What threads put for others, which look out for it before they sleep."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[T] = SimpleQueue()
        self._count = np.zeros(1, np.int64)

    def put(self, item: T) -> None:
        """Have a thread get it."""
        self._queue.put(item)
        self._count[0] += 1

    def get(self, longer: int) -> T:
        """The next one, once there is one and after so many looks longer."""
        seen = int(self._count[0])  # before a look at the queue: what comes after that is another
        if self._queue.empty():
            watch(self._count, seen, LOOKS, longer)
        return self._queue.get()


class Helpers:
    """So many threads beside those that ask."""

    def __init__(self, count: int) -> None:
        self._jobs: Mailbox[Callable[[], object] | None] = Mailbox()
        self._threads = [
            threading.Thread(target=self._help, name=f"contiga_{k}", daemon=True)
            for k in range(count)
        ]
        for thread in self._threads:
            thread.start()

    def put(self, job: Callable[[], object]) -> None:
        """Have one of them do a job, which raises nothing."""
        self._jobs.put(job)

    def end(self) -> None:
        """Have them do what there is to do, and end."""
        for _ in self._threads:
            self._jobs.put(None)
        for thread in self._threads:
            thread.join()

    def _help(self) -> None:
        # A job that waited for others of the same helpers could wait for ever.
        _own.busy = True
        while (job := self._jobs.get(LONGER_FOR_JOBS)) is not None:
            job()
            del job  # and what it holds, while there is no other


@lru_cache(maxsize=1)
def _helpers() -> Helpers:
    watch(np.zeros(1, np.int64), 0, 0, 0)  # compiled, or read, by one thread
    helpers = Helpers(max(thread_count() - 1, 1))
    # None may run what is compiled when the process takes that down.
    atexit.register(helpers.end)
    return helpers


keep_freed()  # what a range makes for itself is made again by the next one
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
    begun: list[None] = []
    ends: Mailbox[BaseException | None] = Mailbox()

    def work() -> None:
        while (start := _taken(starts)) is not None:
            kernel(*args, start, min(start + step, n))

    def help_out() -> None:
        begun.append(None)
        try:
            work()
        except BaseException as error:
            starts.clear()
            ends.put(error)
        else:
            ends.put(None)

    helpers = _helpers()
    try:
        _own.busy = True
        for _ in range(min(threads, len(starts)) - 1):
            helpers.put(help_out)
        work()
    finally:
        _own.busy = False
        starts.clear()  # one who begins from now on finds nothing to do
        errors = [ends.get(LONGER_FOR_ENDS) for _ in begun]
    for error in errors:
        if error is not None:
            raise error


def _taken(starts: deque[int]) -> int | None:
    """The next one, which no other thread takes."""
    try:
        return starts.popleft() if starts else None
    except IndexError:  # another thread took the last one in between
        return None


def map_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """``[function(item) for item in items]`` on the threads; each call must stand by itself."""
    given = list(items)
    found: dict[int, R] = {}

    def some(start: int, stop: int) -> None:
        for k in range(start, stop):
            found[k] = function(given[k])

    run_ranges(some, len(given), 1)
    return [found[k] for k in range(len(given))]


def started(kernel: Callable[..., R], n: int, grain: int, *args: Any) -> Callable[[], R]:
    """Start ``kernel(*args)`` beside what follows; returns what waits for its result.

    With one thread, or where the n rows it goes through are no more than `grain`, it runs at once.
    """
    if n <= grain or thread_count() == 1:
        result = kernel(*args)
        return lambda: result
    future: Future[R] = Future()

    def job() -> None:
        try:
            future.set_result(kernel(*args))
        except BaseException as error:
            future.set_exception(error)

    _helpers().put(job)
    return future.result
