"""Records of paths for the kernels of searches of splines and of triangles."""

from __future__ import annotations

from typing import NamedTuple

Vector = tuple[float, float, float]


class Segment(NamedTuple):
    """A path p → p + length d, in the frame of the surface."""

    p: Vector
    d: Vector
    """Unit vector."""
    length: float
    slack: float
    """Length below which lengths count as zero: a few times the rounding of the coordinates."""
    spare: float
    """Largest distance of a crossing beyond the ends, length."""
