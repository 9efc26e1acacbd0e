"""Garbage is looked for seldom within commands, and as before after them."""

from __future__ import annotations

import gc

import pytest

from contiga.warmup.garbage import BETWEEN, looked_for_seldom


def test_python_looks_seldom_within_and_as_before_after() -> None:
    before = gc.get_threshold()
    with looked_for_seldom():
        assert gc.get_threshold() == BETWEEN
    assert gc.get_threshold() == before
    with pytest.raises(ZeroDivisionError), looked_for_seldom():
        raise ZeroDivisionError
    assert gc.get_threshold() == before
