"""Run Python's garbage collector less often while a process compiles."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

THRESHOLDS = (50_000, 20, 50)
"""Thresholds of the garbage collector: Python's own cost a twelfth of the processor time of
compiling kernels, and of the time to a first step."""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Raise the garbage collector's thresholds in this block, and restore them after it.

    They hold for the whole process, so this is for processes that belong to contiga alone.
    """
    old_thresholds = gc.get_threshold()
    gc.set_threshold(*THRESHOLDS)
    try:
        yield
    finally:
        gc.set_threshold(*old_thresholds)
