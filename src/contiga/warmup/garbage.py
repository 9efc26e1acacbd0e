"""Let Python look for garbage seldom while a process of ours compiles."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

BETWEEN = (50_000, 20, 50)
"""New objects between two looks for garbage, and looks between larger ones: Python's own counts
cost a twelfth of the processor time of compiling kernels, and of that to a first step."""


@contextmanager
def looked_for_seldom() -> Iterator[None]:
    """Within this: for the command line and its helpers, whose processes nobody shares."""
    before = gc.get_threshold()
    gc.set_threshold(*BETWEEN)
    try:
        yield
    finally:
        gc.set_threshold(*before)
