"""A first polyline outside the obstacles: a straight line, or the shortest path over a grid.

The path over the grid decides on which side of a body the string runs; `taut` decides how it runs
there. Paths over the grid are longer than the shortest one by up to a tenth, so that of two sides
that are nearly as long either may be taken.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray
from contiga.routing.obstacles import Obstacles

N_CELLS = 32
"""Number of cells along the longest side of the grid."""
MARGIN = 0.08
"""Room around obstacles and ends, as a share of the longest side."""
JOIN_DIST = 2.6
"""Largest distance of an end from the nodes that it is joined to, in cells."""
STEPS = np.array([step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)])
"""(13, 3) steps from a node to half of its neighbours."""
SKIN = 1e-6
"""Share of the obstacles' size within which an end counts as on the surface."""


def first_polyline(obstacles: Obstacles, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return (k, 3) corners of a polyline from `start` to `end` (3,) that goes round the obstacles.

    It is the segment between the two if that enters nothing and its quarter points are outside,
    otherwise the shortest path over the nodes of a grid, `N_CELLS` cells along its longest side.

    Raises
    ------
    InputError
        There is no such polyline: an end is shut in.
    """
    ends = np.array([start, end])
    skin = SKIN * obstacles.size
    if not obstacles.blocks(ends[:1], ends[1:], skin).any():
        # A segment that enters nothing may still be inside: it may start on a surface and lead in.
        t = np.array([0.25, 0.5, 0.75])[:, None]
        if obstacles.clearances((1.0 - t) * ends[0] + t * ends[1]).gap.min() > -skin:
            return ends
    grid = _Grid(obstacles, ends)
    return np.concatenate([start[None], grid.shortest_path(), end[None]])


class _Grid:
    """Nodes of a regular grid outside the obstacles, and the edges between neighbours."""

    def __init__(self, obstacles: Obstacles, ends: FloatArray) -> None:
        self._obstacles, self._ends = obstacles, ends
        corners = np.concatenate([obstacles.box, ends])
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = MARGIN * float((high - low).max())
        low, high = low - margin, high + margin
        self._cell = float((high - low).max()) / N_CELLS
        shape = np.ceil((high - low) / self._cell).astype(int) + 1
        index = np.indices(shape).reshape(3, -1).T
        self._nodes: FloatArray = np.ascontiguousarray(low + self._cell * index)
        self._reach = obstacles.reach(self._nodes)
        number = np.arange(len(index)).reshape(shape)
        pairs = []
        for step in STEPS:
            target = index + step
            inside = ((target >= 0) & (target < shape)).all(axis=1)
            ahead = number[tuple(target[inside].T)]
            pairs.append(np.stack([number.ravel()[inside], ahead], axis=1))
        edges = np.concatenate(pairs)
        self._edges: IndexArray = edges[(self._reach[edges] > 0.0).all(axis=1)]

    def shortest_path(self) -> FloatArray:
        """Return (k, 3) nodes of the shortest path between the ends, without these.

        An end is joined to the free nodes within `JOIN_DIST` cells that a straight line reaches.

        Raises
        ------
        InputError
            An end is shut in: it sees no node, or no path joins those of both ends.
        """
        skin = SKIN * self._obstacles.size
        seen: list[IndexArray] = []
        for end in self._ends:
            distance = np.linalg.norm(self._nodes - end, axis=1)
            nodes = np.flatnonzero((distance < JOIN_DIST * self._cell) & (self._reach > 0.0))
            # From the node: where the end is on a surface, the line meets it there.
            targets = np.repeat(end[None], len(nodes), axis=0)
            seen.append(nodes[~self._obstacles.blocks(self._nodes[nodes], targets, skin)])
            if len(seen[-1]) == 0:
                raise _shut_in(end)
        edges = self._edges
        path = self._nodes[self._dijkstra(edges, seen)]
        if self._obstacles.blocks(path[:-1], path[1:], 0.0).any():
            # A part thinner than a cell lies between nodes: test every edge that may pass it.
            lengths = np.linalg.norm(np.diff(self._nodes[edges], axis=1)[:, 0], axis=1)
            doubtful = np.flatnonzero(self._reach[edges].sum(axis=1) < lengths)
            segments = self._nodes[edges[doubtful]]
            starts, ends = segments[:, 0].copy(), segments[:, 1].copy()
            blocked = self._obstacles.blocks(starts, ends, 0.0)
            edges = np.delete(edges, doubtful[blocked], axis=0)
            path = self._nodes[self._dijkstra(edges, seen)]
        return path

    def _dijkstra(self, edges: IndexArray, seen: list[IndexArray]) -> IndexArray:
        """Return the nodes (k,) of the shortest path from the first end to the second, by length.

        `seen` are the nodes joined to each end. Raises `InputError` if no path joins the ends.
        """
        n = len(self._nodes)
        joints = [np.stack([np.full(len(s), n + i), s], 1) for i, s in enumerate(seen)]
        pairs = np.concatenate([edges, *joints])
        points = np.concatenate([self._nodes, self._ends])
        lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        graph = coo_array((lengths, tuple(pairs.T)), shape=(n + 2, n + 2)).tocsr()
        distance, previous = dijkstra(graph, directed=False, indices=n, return_predecessors=True)
        if not np.isfinite(distance[n + 1]):
            raise _shut_in(self._ends[1])
        path = [int(previous[n + 1])]
        while previous[path[-1]] != n:
            path.append(int(previous[path[-1]]))
        return np.array(path[::-1])


def _shut_in(end: FloatArray) -> InputError:
    return InputError(
        "no way outside the bodies leads here",
        found=end.tolist(),
        allowed="a point that can be reached from outside",
        remedy="Move it off the surface, or leave out the body that shuts it in",
    )


def resampled(corners: FloatArray, n: int) -> FloatArray:
    """Return (n + 1, 3) points at equal arc lengths of a polyline, both its ends among them."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    distinct = np.concatenate([[True], np.diff(arc) > 0.0])
    s = np.linspace(0.0, arc[-1], n + 1)
    return np.stack([np.interp(s, arc[distinct], x) for x in corners[distinct].T], axis=1)
