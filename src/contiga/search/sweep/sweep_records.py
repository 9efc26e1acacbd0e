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
    """A surface that goes evenly from one shape to another."""

    now: Tables
    """Of the last shape, to which all parameters and neighbours belong."""
    before: Elements
    """Of the first."""
    change: Elements
    """Bernstein coefficients of the displacement from the first to the last; bounds only."""
    way: float
    """How far any of its points goes, length."""


class MovingSegment(NamedTuple):
    """A path p → q beside a surface that moves in the same time."""

    p: Vector
    q: Vector
    shares: tuple[float, float]
    """Of the surface's way that is gone as the path begins, and as it ends."""
    slack: float
    """Lengths below are none."""
    spare: float
    """How far beyond its ends a crossing may lie, length."""


class MovingWork(NamedTuple):
    """Memory to search a leaf of a moving surface in."""

    begin: FloatArray
    """(4, 6), with the next, derivatives as a segment begins,"""
    end: FloatArray
    """as it ends,"""
    mid: FloatArray
    """and half-way, or at a crossing."""
    bound: FloatArray
    """(9,) bounds of the derivatives over a cell,"""
    change: FloatArray
    """(9,) and of those of the displacement."""
    stack: FloatArray
    """(cells, 6) cells that wait, (s0, s1, t0, t1, τ0, τ1)."""
    counts: IntArray
    """(2,) cells opened, and whether the path was given up."""
