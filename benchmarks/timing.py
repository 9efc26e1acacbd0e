"""Medians of repeated calls, one after the other or in turns, and on so many threads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from statistics import median
from time import perf_counter
from typing import Any

import numba


def median_seconds(work: Callable[[Any], Any], inputs: Iterable[Any], warm: int = 1) -> float:
    """Median time of `work` over `inputs`, the first `warm` left out (compiling, caches)."""
    times = []
    for k, item in enumerate(inputs):
        start = perf_counter()
        work(item)
        if k >= warm:
            times.append(perf_counter() - start)
    return median(times)


def in_turns(
    works: Mapping[str, Callable[[int], Any]],
    rounds: int,
    clock: Callable[[], float] = perf_counter,
) -> dict[str, float]:
    """Median seconds of each work, called with 1, 2, … `rounds`; the first round is left out.

    They take turns: what else the machine does falls on all of them alike. With `process_time` for
    a clock it does not count at all, nor do waits. What a work's own `ready` does, called with the
    same number before the clock starts, does not count either.
    """
    times: dict[str, list[float]] = {name: [] for name in works}
    for k in range(1, rounds + 1):
        for name, work in works.items():
            getattr(work, "ready", _nothing)(k)
            start = clock()
            work(k)
            times[name].append(clock() - start)
    return {name: median(found[1:] or found) for name, found in times.items()}


def means_in_turns(
    works: Sequence[Callable[[int], Any]], rounds: int, clock: Callable[[], float]
) -> list[float]:
    """Mean seconds of each work, called in turns: what is done in some rounds alone counts."""
    times = [0.0] * len(works)
    for k in range(rounds):
        for i, work in enumerate(works):
            start = clock()
            work(k)
            times[i] += clock() - start
    return [time / rounds for time in times]


class Given:
    """A work on what `make` makes of the number of its turn, before the clock starts."""

    def __init__(self, work: Callable[[Any], Any], make: Callable[[int], Any]) -> None:
        self.work, self.make = work, make

    def ready(self, k: int) -> None:
        """Make what turn k is given."""
        self.given = self.make(k)

    def __call__(self, _: int) -> None:
        self.work(self.given)


def _nothing(_: int) -> None:
    """To be done before a work."""


@contextmanager
def on_threads(count: int) -> Iterator[None]:
    """Ranges of rows are run on `count` threads inside, of those there are."""
    before = numba.config.NUMBA_NUM_THREADS
    assert count <= before
    numba.config.NUMBA_NUM_THREADS = count
    try:
        yield
    finally:
        numba.config.NUMBA_NUM_THREADS = before
