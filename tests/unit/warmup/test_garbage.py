"""Garbage is looked for seldom within commands, and as before after them."""

from __future__ import annotations

import gc

import pytest

from contiga.warmup.garbage import THRESHOLDS, rare_collections


def test_python_looks_seldom_within_and_as_before_after() -> None:
    before = gc.get_threshold()
    with rare_collections():
        assert gc.get_threshold() == THRESHOLDS
    assert gc.get_threshold() == before
    with pytest.raises(ZeroDivisionError), rare_collections():
        raise ZeroDivisionError
    assert gc.get_threshold() == before
