"""Records that the kernels of closest points pass to each other."""

from __future__ import annotations

from typing import NamedTuple

Vector = tuple[float, float, float]


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


class FootRecord(NamedTuple):
    """A foot inside a face."""

    point: Vector
    """Body frame, or relative to the origin of an element."""
    normal: Vector
    """Unit vector to the free side."""
    gap: float
    """Signed distance of the projected point along the normal, length; negative inside."""


class Guess(NamedTuple):
    """A foot that may be the closest point."""

    element: int
    """−1 for none."""
    uv: tuple[float, float]
    record: FootRecord
