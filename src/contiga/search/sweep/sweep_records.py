"""Records that the kernels of path crossings pass to each other."""

from __future__ import annotations

from typing import NamedTuple

from contiga.elements.element_arrays import Elements
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.table_types import Tables

Vector = tuple[float, float, float]


class LeafPath(NamedTuple):
    """A straight path p + x d near one element, relative to its origin."""

    p: Vector
    d: Vector
    """Direction, of length one."""
    slack: float
    """Length below which distances count as zero."""
    wide: float
    """Largest distance beside the element at which a crossing counts, length: its widest edge."""
    room: tuple[float, float, float, float]
    """Largest distance beyond each side at which a crossing counts, length."""


class Ends(NamedTuple):
    """The part of a path that is searched."""

    length: float
    spare: float
    """Largest distance of a crossing at a small angle beyond the ends, length."""
    max_x: float
    """Distance from the start at which the search ends, length."""
    sense: int
    """Kind of crossings that count: ENTRIES or EITHER."""


class CellWork(NamedTuple):
    """Work arrays of the search of a leaf."""

    stack: FloatArray
    """(cells, 4) pending cells (s0, s1, t0, t1)."""
    h: FloatArray
    """(4, 6) point and derivatives."""
    k: FloatArray
    """(9,) bounds of the derivatives over a cell."""
    corner: FloatArray
    """(2, 3) box of a cell."""
    counts: IntArray
    """(2,) number of cells opened; 1 if the search was given up, else 0."""


class Queue(NamedTuple):
    """Pending nodes of the hierarchy."""

    nodes: IntArray
    entry: FloatArray
    """Distance from the start at which the path enters the box of each node, length."""


@pass_by_pointer
class MovingSurface(NamedTuple):
    """A surface that moves linearly from one shape to another."""

    now: Tables
    """Tables of the last shape, to which all parameters and neighbours refer."""
    before: Elements
    """Elements of the first shape."""
    change: Elements
    """Bernstein coefficients of the displacement from the first to the last shape; for bounds."""
    max_displacement: float
    """Largest displacement of any point, length."""


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
