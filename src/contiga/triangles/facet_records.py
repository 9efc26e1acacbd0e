"""Records that the kernels of triangle meshes pass to each other."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray, IndexArray


class Queue(NamedTuple):
    """Pending nodes of the hierarchy, the nearest on top, and work for the children of one."""

    nodes: IndexArray
    bounds: FloatArray
    """Squared distance of each node, or the position at which a path enters its box."""
    lane: FloatArray
    """(WIDTH,) the same numbers for the children of the current node."""


class WalkStarts(NamedTuple):
    """The places that feet are continued from."""

    slots: IndexArray
    """(n,) slots of the triangles; −1 for none."""
    before: FloatArray
    """(n, 3) last positions of the points, the mesh's frame; (0, 3) if unknown."""
