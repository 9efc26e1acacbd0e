"""What kernels hand each other that look for feet."""

from __future__ import annotations

from typing import NamedTuple


class Expansion(NamedTuple):
    """f = |S − P|²/2 about a place (s, t) of an element, to second order."""

    f: float
    f_s: float
    f_t: float
    f_ss: float
    f_st: float
    f_tt: float
    square_s: float
    """|S_s|²"""
    square_t: float
    """|S_t|²"""
