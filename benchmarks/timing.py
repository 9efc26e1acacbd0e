"""Medians of repeated calls."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from statistics import median
from time import perf_counter
from typing import Any


def median_seconds(work: Callable[[Any], Any], inputs: Iterable[Any], warm: int = 1) -> float:
    """Median time of `work` over `inputs`, the first `warm` left out (compiling, caches)."""
    times = []
    for k, item in enumerate(inputs):
        start = perf_counter()
        work(item)
        if k >= warm:
            times.append(perf_counter() - start)
    return median(times)
