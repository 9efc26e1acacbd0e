"""What of a test each commit has time for, and what only `make stress` asks for.

Tests and parameters marked `slow` are left out of `make test`; samples that are larger under
`make stress` ask `FULL`, those that are smaller without the compiler ask `few`.
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


def slow(*values: Any) -> list[Any]:
    """These parameters, of which each is a test of more than some seconds; tuples are several."""
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)
        for value in values
    ]
