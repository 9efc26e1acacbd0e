"""What of a test each commit has time for, and what only `make stress` asks for.

Tests and parameters marked `slow` are left out of `make test`; samples that are larger under
`make stress` ask `FULL`.
"""

from __future__ import annotations

import os
from typing import Any

import pytest

FULL = bool(os.environ.get("CONTIGA_FULL"))


def slow(*values: Any) -> list[Any]:
    """These parameters, of which each is a test of more than some seconds; tuples are several."""
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)
        for value in values
    ]
