"""The tables the kernels on triangle meshes work on.

Triangles stand in the order of the hierarchy ("slots"), so that those of one place in space are
in one place in memory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IntArray

BORDER = -1
"""Neighbour across an edge where the surface ends. Below it: −2 − fan of more than two."""
WIDTH = 8
"""Children of a node."""


class Facets(NamedTuple):
    """What the search knows of a mesh; m triangles that have an area, v welded vertices."""

    plane: FloatArray
    """(m, 12) first corner a, duals g1 and g2, unit normal n: barycentric coordinates of a point
    P are (P − a)·g1 and (P − a)·g2, its height over the plane (P − a)·n."""
    corner: FloatArray
    """(m, 9) corners."""
    vertex: IntArray
    """(m, 3) welded vertices."""
    neighbour: IntArray
    """(m, 3) slot across the edge from corner k to k + 1, `BORDER`, or −2 − fan."""
    fan_first: IntArray
    fan: IntArray
    """fan[fan_first[f] : fan_first[f + 1]] are the slots that meet at edges of fan f."""
    ring_first: IntArray
    ring: IntArray
    """ring[ring_first[v] : ring_first[v + 1]] are the slots around vertex v."""
    vertex_normal: FloatArray
    """(v, 3) unit sums of the normals around, weighted by angle."""
    at_border: NDArray[np.int8]
    """(v,) 1 where the surface ends at a vertex."""
    triangle: IntArray
    """(m,) triangle of the mesh by slot."""
    slot: IntArray
    """By triangle of the mesh its slot; that of its twin for a duplicate, −1 without area."""
    box: FloatArray
    """(k, 6 · WIDTH) boxes of each node's children: low x of all, low y, … high z."""
    child: IntArray
    """(k, WIDTH) node, −1 − slot of a triangle, or NOBODY."""
    scale: FloatArray
    """(2,) size of the mesh, length below which two points are one."""


NOBODY = np.iinfo(np.int32).max
"""Child of a node that is not there; its box is at infinity."""
