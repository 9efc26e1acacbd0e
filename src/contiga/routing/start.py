"""A first way outside the obstacles: the straight line, or the shortest way over a grid.

The grid's ways decide on which side of a body the string runs; how it runs there is the matter of
`taut`. Ways of the grid are longer than the shortest by up to a tenth, so that of two sides that
are nearly as long either may be taken.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray
from contiga.routing.obstacles import Obstacles

CELLS = 32
"""Along the longest side of the grid."""
MARGIN = 0.08
"""Room around obstacles and ends, as a share of the longest side."""
NEAR = 2.6
"""Cells from an end to nodes of the grid that it may be joined to."""
WAYS = np.array([way for way in product((-1, 0, 1), repeat=3) if way > (0, 0, 0)])
"""(13, 3) steps to half of the neighbours."""
SKIN = 1e-6
"""Share of the obstacles' size within which an end counts as on the surface."""


def first_way(obstacles: Obstacles, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return (k, 3) corners of a polyline from `start` to `end` (3,) that goes round the obstacles.

    Raises
    ------
    InputError
        None is found: an end is shut in.
    """
    ends = np.array([start, end])
    if not obstacles.blocks(ends[:1], ends[1:], SKIN * obstacles.size).any() and _is_free(
        obstacles, ends
    ):
        return ends
    grid = _Grid(obstacles, ends)
    return np.concatenate([start[None], grid.shortest(), end[None]])


def _is_free(obstacles: Obstacles, ends: FloatArray) -> bool:
    """Whether the middle of a segment that enters nothing is outside.

    It may be inside, for example if the segment starts on a surface and leads inwards.
    """
    middle = np.array([0.25, 0.5, 0.75])[:, None]
    between = (1.0 - middle) * ends[0] + middle * ends[1]
    return bool(obstacles.clearances(between).gap.min() > -SKIN * obstacles.size)


class _Grid:
    """Nodes of a regular grid outside the obstacles, and the ways between neighbours."""

    def __init__(self, obstacles: Obstacles, ends: FloatArray) -> None:
        self._obstacles, self._ends = obstacles, ends
        corners = np.concatenate([obstacles.box, ends])
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = MARGIN * float((high - low).max())
        low, high = low - margin, high + margin
        self._cell = float((high - low).max()) / CELLS
        shape = np.ceil((high - low) / self._cell).astype(int) + 1
        index = np.indices(shape).reshape(3, -1).T
        self._points: FloatArray = np.ascontiguousarray(low + self._cell * index)
        self._reach = obstacles.reach(self._points)
        number = np.arange(len(index)).reshape(shape)
        pairs = []
        for way in WAYS:
            there = index + way
            inside = ((there >= 0) & (there < shape)).all(axis=1)
            pairs.append(np.stack([number.ravel()[inside], number[tuple(there[inside].T)]], axis=1))
        edges = np.concatenate(pairs)
        self._edges: IndexArray = edges[(self._reach[edges] > 0.0).all(axis=1)]

    def shortest(self) -> FloatArray:
        """Return (k, 3) nodes of the shortest way between the ends."""
        doors = [self._doors(end) for end in self._ends]
        edges = self._edges
        way = self._way(edges, doors)
        steps = self._points[way]
        if self._obstacles.blocks(steps[:-1], steps[1:], 0.0).any():
            # Something thinner than a cell lies between nodes: all that may pass it are looked at.
            lengths = np.linalg.norm(np.diff(self._points[edges], axis=1)[:, 0], axis=1)
            near = np.flatnonzero(self._reach[edges].sum(axis=1) < lengths)
            ahead = self._points[edges[near]]
            blocked = self._obstacles.blocks(ahead[:, 0].copy(), ahead[:, 1].copy(), 0.0)
            edges = np.delete(edges, near[blocked], axis=0)
            way = self._way(edges, doors)
        return self._points[way]

    def _doors(self, end: FloatArray) -> IndexArray:
        """Nodes that a straight line leads to from an end."""
        away = np.linalg.norm(self._points - end, axis=1)
        near = np.flatnonzero((away < NEAR * self._cell) & (self._reach > 0.0))
        here = np.repeat(end[None], len(near), axis=0)
        skin = SKIN * self._obstacles.size
        # From the node: where the end is on a surface, the line meets it there.
        seen = near[~self._obstacles.blocks(self._points[near], here, skin)]
        if len(seen) == 0:
            raise _shut_in(end)
        return seen

    def _way(self, edges: IndexArray, doors: list[IndexArray]) -> IndexArray:
        """Nodes of the shortest way from a door of the one end to a door of the other."""
        n = len(self._points)
        links = [edges, *(np.stack([np.full(len(d), n + i), d], 1) for i, d in enumerate(doors))]
        pairs = np.concatenate(links)
        where = np.concatenate([self._points, self._ends])
        lengths = np.linalg.norm(where[pairs[:, 0]] - where[pairs[:, 1]], axis=1)
        graph = coo_array((lengths, tuple(pairs.T)), shape=(n + 2, n + 2)).tocsr()
        distance, before = dijkstra(graph, directed=False, indices=n, return_predecessors=True)
        if not np.isfinite(distance[n + 1]):
            raise _shut_in(self._ends[1])
        way = [int(before[n + 1])]
        while before[way[-1]] != n:
            way.append(int(before[way[-1]]))
        return np.array(way[::-1])


def _shut_in(end: FloatArray) -> InputError:
    return InputError(
        "no way outside the bodies leads here",
        found=end.tolist(),
        allowed="a point that can be reached from outside",
        remedy="Move it off the surface, or leave out the body that shuts it in",
    )


def resampled(corners: FloatArray, n: int) -> FloatArray:
    """Return (n + 1, 3) points evenly along a polyline with the given corners."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    keep = np.concatenate([[True], np.diff(arc) > 0.0])
    at = np.linspace(0.0, arc[-1], n + 1)
    return np.stack([np.interp(at, arc[keep], x) for x in corners[keep].T], axis=1)
