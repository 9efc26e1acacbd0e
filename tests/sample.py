"""What of a test each commit has time for, and what only `make stress` asks for.

Tests and parameters marked `full` run where `CONTIGA_FULL=1` is set alone, as `make stress` does.
Samples that are larger there ask `FULL`, those that are smaller without the compiler ask `few`.
Which of the other tests are left to `make check` is measured: `tests.durations`.
"""

from __future__ import annotations

import os
from typing import Any, TypeVar

import pytest
from numba import config

FULL = bool(os.environ.get("CONTIGA_FULL"))
T = TypeVar("T")


def few(many: T, interpreted: T) -> T:
    """`many` where kernels are compiled; where they run as Python, the little that is enough."""
    return interpreted if config.DISABLE_JIT else many


def full(*values: Any) -> list[Any]:
    """Parameters left to `make stress`, where each run has a quicker one; tuples are several."""
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.full)
        for value in values
    ]
