"""Points whose sides and feet do not tell what becomes of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import ByteArray, FloatArray, IntArray, Projection


class Asked(NamedTuple):
    """Points to be judged, one row each."""

    rows: IntArray
    was: NDArray[np.bool_]
    """In contact before."""
    kept: NDArray[np.bool_]
    """In contact before, with a foot that would do."""
    status: ByteArray
    """What the foot would make of a point that is kept."""
    side: ByteArray
    """1 outside, −1 inside, 0 not known."""
    safe_distance: FloatArray
    """Way to the surface at least, where the side is known."""
    within: FloatArray
    """Distance to a point of the surface, infinite where none is known."""
    guard: FloatArray
    """(n, 3) normals that tell which walls are opposite to those that were in contact, else 0."""
    depth: FloatArray
    """(n,) how deep those were, else 0."""
    opposed: NDArray[np.bool_]
    """(n,) whose nearest walls were opposite to those that held them."""
    feet: Projection
    """The feet that would do; then those of all points inside."""
    truth: Projection
    """The closest points, of the rows that are asked for them; status −1 in others."""


class JudgeLimits(NamedTuple):
    """What decides of points that are asked for."""

    penetration: bool
    """Whether the search is by penetration."""
    nearest: bool
    """Whether the nearest wall pushes."""
    band: float
    """Distance below which rounding decides whether a point is inside, length."""
    depth: float
    """Deepest penetration that a search by penetration takes for one, length."""
    same_foot: float
    """How far feet that are one may be apart, length."""
