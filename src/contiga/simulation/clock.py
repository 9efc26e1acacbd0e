"""Where the time of a run goes: seconds by stage."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class Clock:
    """Wall-clock seconds by stage, and those that numba spends compiling.

    >>> clock = Clock()
    >>> with clock("reading"):
    ...     text = "some"
    >>> list(clock.seconds)
    ['reading']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.compiled = 0.0

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Count the seconds of compiling inside; kernels found in numba's cache cost none."""
        from numba.core import event

        def add(seconds: float) -> None:
            self.compiled += seconds

        with event.install_timer("numba:compile", add):
            yield

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time spent inside to `stage`."""
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + perf_counter() - start
