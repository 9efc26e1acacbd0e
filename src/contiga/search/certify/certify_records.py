"""Records of arrays that kernels make for the certificates of tracked feet."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray


class Bending(NamedTuple):
    """The Taylor polynomial of a cell and its remainder, as `bend_bounds` leaves them."""

    derivatives: FloatArray
    """(4, 6) S and its derivatives to the second order in the middle, by parameters that run over
    [-1, 1] in the cell."""
    rest: FloatArray
    """(2, 5) what they depart from that polynomial by over the cell, at most; along the normal."""


class Principal(NamedTuple):
    """The largest curvatures and the metric at a place; see `bend_nb.principal`."""

    inner: float
    outer: float
    metric: tuple[float, float, float, float]


class Seen(NamedTuple):
    """A motion P(0) → P(1), as a foot sees it."""

    heights: tuple[float, float]
    """(P − Q)·n of both."""
    far: float
    """The larger distance from the foot."""
    slip: float
    """How far the motion leads along the surface at most, length."""
