"""Records of paths that searches of splines and of triangles hand to their kernels."""

from __future__ import annotations

from typing import NamedTuple

Vector = tuple[float, float, float]


class Segment(NamedTuple):
    """A path p → p + length d, in the frame of what is searched."""

    p: Vector
    d: Vector
    """Of length one."""
    length: float
    slack: float
    """Lengths below are none: a few times the rounding of the coordinates."""
    spare: float
    """How far beyond its ends a crossing may lie, length."""
