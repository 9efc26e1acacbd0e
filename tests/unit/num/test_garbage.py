"""When Python looks for garbage."""

from __future__ import annotations

import gc

from contiga.num.garbage import BETWEEN, look_seldom


def test_it_looks_less_often_than_by_itself():
    before = gc.get_threshold()
    try:
        look_seldom()
        assert gc.get_threshold() == BETWEEN
        assert gc.isenabled()
        assert BETWEEN[0] > 700
    finally:
        gc.set_threshold(*before)
