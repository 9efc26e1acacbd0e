"""When Python looks for garbage: seldom, where next to nothing is any."""

from __future__ import annotations

import gc

BETWEEN = (50_000, 20, 50)
"""New objects between two looks for garbage, and looks between larger ones: Python's own counts
cost a twelfth of the processor time to a first step, and of that of compiling kernels."""


def look_seldom() -> None:
    """From now on, in this process."""
    gc.set_threshold(*BETWEEN)
