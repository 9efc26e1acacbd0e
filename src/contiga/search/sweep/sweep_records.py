"""What kernels hand each other that look for where a path crosses a body."""

from __future__ import annotations

from typing import NamedTuple

from contiga.elements.element_arrays import Elements
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.table_types import Tables

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


@pass_by_pointer
class MovingSurface(NamedTuple):
    """A surface that moves linearly from one shape to another."""

    now: Tables
    """Tables of the last shape, to which all parameters and neighbours refer."""
    before: Elements
    """Elements of the first shape."""
    change: Elements
    """Bernstein coefficients of the displacement from the first to the last shape; for bounds."""
    way: float
    """Largest displacement of any of its points, length."""


class MovingSegment(NamedTuple):
    """A straight path p → q near a surface that moves in the same time."""

    p: Vector
    q: Vector
    shares: tuple[float, float]
    """Shares of the surface's motion at the beginning and at the end of the path."""
    slack: float
    """Length below which distances count as zero."""
    spare: float
    """Largest distance of a crossing beyond the ends of the path, length."""


class MovingWork(NamedTuple):
    """Work arrays of a search in a leaf of a moving surface."""

    begin: FloatArray
    """(4, 6) point and derivatives at the beginning of a segment."""
    end: FloatArray
    """(4, 6) point and derivatives at its end."""
    mid: FloatArray
    """(4, 6) point and derivatives half-way, or at a crossing."""
    bound: FloatArray
    """(9,) bounds of the surface's derivatives over a cell."""
    change: FloatArray
    """(9,) bounds of the displacement's derivatives over a cell."""
    stack: FloatArray
    """(cells, 6) pending cells (s0, s1, t0, t1, τ0, τ1)."""
    counts: IntArray
    """(2,) number of cells opened; 1 if the search was given up, else 0."""
