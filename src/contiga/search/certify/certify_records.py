"""Records of the certificates of tracked feet."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray


class Bending(NamedTuple):
    """The Taylor polynomial of a cell and the bounds of its remainder; see `bend_bounds`."""

    derivatives: FloatArray
    """(4, 6) S and its derivatives to second order in the middle, by parameters that run over
    [-1, 1] in the cell."""
    remainder: FloatArray
    """(2, 5) bounds of the remainder's derivatives over the cell: of their length, and of their
    part along the normal."""


class Principal(NamedTuple):
    """The largest curvatures and the metric at a place; see `bend_nb.principal`."""

    inner: float
    outer: float
    metric: tuple[float, float, float, float]


class Motion(NamedTuple):
    """A motion P(0) → P(1), relative to a foot Q with normal n."""

    heights: tuple[float, float]
    """(P − Q)·n of both ends."""
    distance: float
    """The larger distance of both ends from the foot."""
    slip: float
    """Upper bound of the tangential part of the motion, length."""
