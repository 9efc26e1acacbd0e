"""Calls of kernels that are called `straight`, looked at: in a run nobody looks at their types."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numba

from contiga.jit.dispatcher import KernelDispatcher

FEW = 2
"""Of the calls of a kernel the first are looked at: a look takes longer than most calls."""


class StraightCalls:
    """What was called straight, and what was handed over that a kernel is not compiled for."""

    def __init__(self) -> None:
        self.kernels: Counter[str] = Counter()
        """Names of kernels that were called so, and how often."""
        self.wrong: list[str] = []
        """A line for each call with other types."""

    def look(self, kernel: KernelDispatcher, arguments: tuple[Any, ...]) -> bool:
        """Note a call; whether the kernel is compiled for it, as far as is looked at."""
        name = kernel.py_func.__name__
        self.kernels[name] += 1
        if self.kernels[name] > FEW:
            return True
        (compiled,) = kernel.overloads
        given = tuple(map(numba.typeof, arguments))
        if given != compiled:
            self.wrong.append(f"{name} was handed {given}, not {compiled}")
        return given == compiled


class _Looked:
    """`KernelDispatcher.entries` of kernels whose calls are looked at."""

    def __init__(self, calls: StraightCalls) -> None:
        self._calls = calls

    def __get__(self, kernel: KernelDispatcher, kind: type) -> tuple[Callable[..., Any], ...]:
        own: tuple[Callable[..., Any], ...] = vars(kernel).get("entries", ())

        def call(*arguments: Any) -> Any:
            return (own[0] if self._calls.look(kernel, arguments) else kernel)(*arguments)

        return (call,) if len(own) == 1 else own

    def __set__(self, kernel: KernelDispatcher, entries: tuple[Callable[..., Any], ...]) -> None:
        vars(kernel)["entries"] = entries


@contextmanager
def looked_at() -> Iterator[StraightCalls]:
    """Look within this at all that kernels called straight are handed."""
    calls = StraightCalls()
    with patch.object(KernelDispatcher, "entries", _Looked(calls)):
        yield calls
