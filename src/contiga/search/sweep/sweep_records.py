"""What kernels hand each other that look for where a path crosses a body."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray, IntArray

Vector = tuple[float, float, float]


class LeafPath(NamedTuple):
    """The same path as one element sees it, from its origin."""

    p: Vector
    d: Vector
    slack: float
    wide: float
    """How far beside the element a crossing still counts, length: its widest edge."""
    room: tuple[float, float, float, float]
    """The same beyond each of its sides."""


class Ends(NamedTuple):
    """Which part of a path is looked at."""

    length: float
    spare: float
    """How far beyond its ends a crossing at a small angle may lie, length."""
    far: float
    """Where crossings need not be looked for any more, length from its start."""
    sense: int
    """ENTRIES or EITHER."""


class CellWork(NamedTuple):
    """Memory to search a leaf in."""

    stack: FloatArray
    """(cells, 4) cells that wait, (s0, s1, t0, t1)."""
    h: FloatArray
    """(4, 6) derivatives."""
    k: FloatArray
    """(9,) bounds of the derivatives over a cell."""
    corner: FloatArray
    """(2, 3) box of a cell."""
    counts: IntArray
    """(2,) cells opened, and whether the path was given up."""


class Queue(NamedTuple):
    """Nodes of the hierarchy that wait."""

    nodes: IntArray
    entry: FloatArray
    """Where the path enters the box of each."""
