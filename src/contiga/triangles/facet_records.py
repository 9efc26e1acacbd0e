"""What kernels hand each other that search a mesh of triangles."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray, IndexArray

Vector = tuple[float, float, float]


class Segment(NamedTuple):
    """A path p → p + length d, the mesh's frame."""

    p: Vector
    d: Vector
    """Of length one."""
    length: float
    slack: float
    """Lengths below are none: a few times the rounding of the coordinates."""
    spare: float
    """How far beyond its ends a crossing may lie, length."""


class Queue(NamedTuple):
    """Nodes of the hierarchy that wait, the nearest on top, and room for the children of one."""

    nodes: IndexArray
    bounds: FloatArray
    """What is known of each: its squared distance, or where a path enters its box."""
    lane: FloatArray
    """(WIDTH,) the same of the children of the node that is looked at."""
