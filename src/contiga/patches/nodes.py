"""Nodes of a slave on a shell: points of its surface, on the sides of its elements and inside them.

They are the points of Gauss-Lobatto's rule, whose first and last lie on the sides: edges of patches
have nodes of their own, which depend on the control points of the edge alone, so that a place names
an edge by its nodes. Their weights are above zero, and of an element they integrate polynomials of
twice its degree and one. Elements share the nodes of their sides, patches those of their joints:
the facets between them are one mesh.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.patches.basis import VALUE, BasisAt, U, V
from contiga.patches.net import Net, on_net
from contiga.patches.points import SparseRows, grid_facets, sparse_rows
from contiga.records import FloatArray, IntArray


class Rule(NamedTuple):
    """Points of an element in one direction, on 0 … 1, and their weights, whose sum is one."""

    points: FloatArray
    weights: FloatArray


def lobatto(count: int) -> Rule:
    """Return Gauss-Lobatto's rule: the ends, and where the derivative of P_{n−1} is zero.

    The weights are 2 / (n (n − 1) P_{n−1}²) on −1 … 1 (Abramowitz & Stegun, 25.4.32).
    """
    legendre = np.polynomial.legendre.Legendre.basis(count - 1)
    inner = np.sort(legendre.deriv().roots().real)
    points = np.concatenate([[-1.0], inner, [1.0]])
    weights = 2.0 / (count * (count - 1) * legendre(points) ** 2)
    return Rule(0.5 * (points + 1.0), 0.5 * weights)


class SurfaceNodes(NamedTuple):
    """Points on a shell that are the nodes of a slave."""

    rows: SparseRows
    """N (n, m)."""
    columns: SparseRows
    """Nᵀ (m, n)."""
    weight: FloatArray
    """(n,) area at rest that each stands for."""
    facets: IntArray
    """(f, 3) triangles between them."""
    grids: tuple[IntArray, ...]
    """(k, l) node of each point of each piece, along u and v."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return x = N q (n, 3) of control points (m, 3); velocities likewise."""
        return self.rows.times(q)

    def spread(self, f: FloatArray) -> FloatArray:
        """Return forces on the nodes (n, 3) as forces Nᵀ f (m, 3) on control points."""
        return self.columns.times(f)


def surface_nodes(net: Net, count: int | None = None) -> SurfaceNodes:
    """Return the nodes of all patches, `count` along each side of an element.

    If it is omitted there are two more than the highest degree.
    """
    if count is None:
        count = max(max(piece.degrees) for piece in net.pieces) + 2
    rule = lobatto(count)
    found: list[BasisAt] = []
    weights: list[FloatArray] = []
    grids: list[NDArray[np.intp]] = []
    first = 0
    for piece in net.pieces:
        (u, u_weights), (v, v_weights) = (_line(knots, rule) for knots in piece.knots)
        uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=2).reshape(-1, 2)
        at = on_net(piece, uv)
        normal = np.cross(at.of(U, net.points), at.of(V, net.points))
        area = np.sqrt(np.square(normal).sum(axis=1))
        found.append(at)
        weights.append((u_weights[:, None] * v_weights).ravel() * area)
        grids.append(first + np.arange(len(uv)).reshape(len(u), len(v)))
        first += len(uv)
    kept, numbers = _shared(net, grids, first)
    every = sparse_rows([at.control for at in found], [at.values[:, VALUE] for at in found])
    rows = every.at(kept)
    facets = [grid_facets(grid.shape[0], grid.shape[1], int(grid[0, 0])) for grid in grids]
    nodes = numbers.astype(np.int32)
    return SurfaceNodes(
        rows,
        rows.turned(len(net.points)),
        np.bincount(numbers, weights=np.concatenate(weights)).astype(np.float64),
        nodes[np.concatenate(facets)],
        tuple(nodes[grid] for grid in grids),
    )


def _line(knots: FloatArray, rule: Rule) -> tuple[FloatArray, FloatArray]:
    """Parameters along one direction, those between elements once, and their weights."""
    breaks = np.unique(knots)
    steps, inner = np.diff(breaks), len(rule.points) - 1
    points = np.append((breaks[:-1, None] + steps[:, None] * rule.points[:-1]).ravel(), breaks[-1])
    weights = np.zeros(len(points))
    for k, step in enumerate(steps):
        weights[k * inner : (k + 1) * inner + 1] += step * rule.weights
    return points, weights


def _shared(
    net: Net, grids: list[NDArray[np.intp]], count: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first of the points that are one node, of each node; and the node of each point."""
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        for joint in net.joints:
            one, other = (
                side_of(grids[piece], edge)
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            )
            other = other[::-1] if joint.turned else other
            least = np.minimum(lowest[one], lowest[other])
            np.minimum.at(lowest, one, least)
            np.minimum.at(lowest, other, least)
        if (before == lowest).all():
            return np.unique(lowest, return_inverse=True)


def side_of(grid: NDArray[Any], edge: str) -> NDArray[Any]:
    """The points on an edge of a grid."""
    end = 0 if edge[1] == "0" else -1
    return grid[end] if edge[0] == "u" else grid[:, end]
