"""Connected regions of contact; their number is not given in advance.

Points in contact are joined over the slave's facets if it has any. The points of a cloud are joined
to neighbours within `REACH` times the local spacing of the cloud at rest. Both happen in space: a
seam or a border between patches of the master does not divide a region, as it does clusters in
(u, v).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.area.kernels import components_nb, touch_nb
from contiga.area.method import Rest
from contiga.arrays.layout import locked
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray

# Largest distance of neighbours, in local spacings: past the diagonal of a square grid (√2), short
# of its second neighbour (2).
REACH = 1.6
# The local spacing is the distance to this nearest neighbour: the third is still one step away,
# inside a grid and on its edge.
K_NEIGHBOUR = 3


class Topology(NamedTuple):
    """The facets of a slave; those at point i are incident[first[i]:first[i+1]]."""

    facets: IntArray
    """(m, 3) corners."""
    first: NDArray[np.int64]
    """(n + 1,)."""
    incident: IntArray
    """(3 m,) facets, ascending at each point."""


class Graph(NamedTuple):
    """Neighbours of each point: neighbour[first[i]:first[i+1]]."""

    first: NDArray[np.int64]
    """(n + 1,)."""
    neighbour: IntArray
    """(k,) points; one may be listed twice."""


def topology_of(facets: IntArray, n: int) -> Topology:
    """Return which facets meet at each of n points.

    Raises
    ------
    InputError
        A facet names a point that does not exist.
    """
    corners = locked(np.ascontiguousarray(facets, dtype=np.int32))
    bad = np.flatnonzero(((corners < 0) | (corners >= n)).any(axis=1))
    if len(bad):
        raise InputError(
            f"facet {int(bad[0])} names a point that is not there",
            where="facets",
            found=corners[bad[0]].tolist(),
            allowed=f"0 to {n - 1}",
        )
    return Topology(corners, *touch_nb.incidence(corners, n))


def neighbours_of(points: FloatArray, reach: float = REACH) -> Graph:
    """Return the neighbours of each point of a cloud (n, 3), as a graph.

    Neighbours are within `reach` times the larger of their two local spacings.

    The local spacing of a point is the distance to its third neighbour (the last of fewer). A
    neighbour may be listed twice; their order is not ascending.
    """
    from scipy.spatial import cKDTree

    n = len(points)
    if n < 2:
        return Graph(np.zeros(n + 1, np.int64), np.zeros(0, np.int32))
    tree = cKDTree(points)
    k = min(K_NEIGHBOUR + 1, n)
    spacing = tree.query(points, k=k)[0][:, -1]
    lists = tree.query_ball_point(points, reach * spacing * (1.0 + 1e-9))
    a = np.repeat(np.arange(n), [len(entry) for entry in lists])
    b = np.concatenate([np.asarray(entry, dtype=np.int64) for entry in lists])
    is_pair = a != b
    a, b = np.concatenate([a[is_pair], b[is_pair]]), np.concatenate([b[is_pair], a[is_pair]])
    order = np.argsort(a, kind="stable")
    first = np.concatenate(([0], np.cumsum(np.bincount(a, minlength=n))))
    return Graph(first.astype(np.int64), b[order].astype(np.int32))


def structure_of(rest: Rest, reach: float = REACH) -> Topology | Graph:
    """Return the connectivity of a slave's points: its facets, or else its neighbours."""
    if rest.facets is not None and len(rest.facets):
        return topology_of(rest.facets, len(rest.points))
    return neighbours_of(rest.points, reach)


def regions(structure: Topology | Graph, rows: IntArray, points: FloatArray) -> IntArray:
    """Return (n_c,) number of the connected region of each of `rows`, in order of appearance."""
    place = np.full(len(points), -1, np.int32)
    if isinstance(structure, Graph):
        return components_nb.graph_components(structure.first, structure.neighbour, rows, place)
    whole, part = touch_nb.touched(structure, rows, place)
    return components_nb.facet_components(whole, place[structure.facets[part]], len(rows))
