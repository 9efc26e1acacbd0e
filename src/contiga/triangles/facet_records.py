"""Records that kernels hand each other to search a mesh of triangles."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray, IndexArray


class Queue(NamedTuple):
    """Nodes of the hierarchy that wait, the nearest on top, and room for the children of one."""

    nodes: IndexArray
    bounds: FloatArray
    """What is known of each: its squared distance, or where a path enters its box."""
    lane: FloatArray
    """(WIDTH,) the same of the children of the node that is looked at."""


class WalkStarts(NamedTuple):
    """The places that feet are continued from."""

    slots: IndexArray
    """(n,) of the triangles; −1 where there is none."""
    before: FloatArray
    """(n, 3) where the points were, the mesh's frame; (0, 3) where that is not known."""
