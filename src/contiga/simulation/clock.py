"""Measure the time of a run: wall-clock seconds by stage."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class Stage:
    """A context that times one stage; a class, as a generator takes twice as long per use."""

    __slots__ = ("_name", "_seconds", "_start")

    def __init__(self, seconds: dict[str, float], name: str) -> None:
        self._seconds, self._name = seconds, name

    def __enter__(self) -> None:
        self._start = perf_counter()

    def __exit__(self, *_: object) -> None:
        spent = self._seconds.get(self._name, 0.0)
        self._seconds[self._name] = spent + perf_counter() - self._start


class Clock:
    """Wall-clock seconds by stage, and seconds of compiling by numba.

    >>> clock = Clock()
    >>> with clock("reading"):
    ...     text = "some"
    >>> list(clock.seconds)
    ['reading']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.compiled = 0.0
        self._stages: dict[str, Stage] = {}

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Add the seconds of compiling inside to `compiled`; kernels in numba's cache cost none."""
        from numba.core import event

        def add(seconds: float) -> None:
            self.compiled += seconds

        with event.install_timer("numba:compile", add):
            yield

    def __call__(self, stage: str) -> Stage:
        """Return a context that adds the time inside to `stage`, which does not nest."""
        if stage not in self._stages:
            self._stages[stage] = Stage(self.seconds, stage)
        return self._stages[stage]

    def add(self, stage: str, begin: float) -> None:
        """Add the time since `begin`, a value of `perf_counter`, to `stage`."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + perf_counter() - begin
