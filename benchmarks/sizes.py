"""How large the benchmarks are: as the goals say, or so small that all run in seconds."""

from __future__ import annotations

from typing import NamedTuple


class Sizes(NamedTuple):
    """Counts of points, faces and repeats."""

    points: int = 1_000_000
    rival_points: int = 50_000
    """Of splinepy, which takes a hundred times as long."""
    cold_points: int = 200_000
    triangles_a_side: int = 200
    """2 · 200² = 80,000 triangles for FCPW."""
    copies: int = 20
    """Copies of the state that a whole step is set beside."""
    small_steps: int = 3_000
    rounds: int = 7
    """Repeats of which the median is taken; the first one is left out."""
    faces: tuple[int, ...] = (1, 100, 10_000)
    face_points: int = 1_000_000
    counts: tuple[int, ...] = (10_000, 100_000, 1_000_000, 10_000_000)
    stream: int = 20_000_000
    """Numbers in the arrays of the test of the memory."""


FULL = Sizes()
SMALL = Sizes(
    points=2_000,
    rival_points=200,
    cold_points=500,
    triangles_a_side=10,
    copies=2,
    small_steps=20,
    rounds=2,
    faces=(1, 4),
    face_points=500,
    counts=(500, 1_000),
    stream=10_000,
)
