"""How the stages of a step are timed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

StageClock = Callable[[str], AbstractContextManager[None]]
"""Called with the name of a stage, gives a context that times it."""

_NO_CLOCK: AbstractContextManager[None] = nullcontext()


def untimed(_: str) -> AbstractContextManager[None]:
    """Of stages that nobody times."""
    return _NO_CLOCK
