"""Nodes of a slave on a shell: points of its surface, on the sides of its elements and inside them.

They are the points of the Gauss-Lobatto rule, whose first and last points lie on the sides: the
nodes of an edge of a patch depend on the control points of the edge alone. Their weights are
positive, and integrate polynomials up to twice an element's degree plus one. Elements share the
nodes of their sides, patches the nodes of their joints: the facets between them are one mesh.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.patches.basis import VALUE, BasisAt, U, V
from contiga.patches.net import Net, merge_joined, on_net
from contiga.patches.pieces import rows_from
from contiga.patches.points import SparseRows, grid_facets, sparse_rows
from contiga.records import FloatArray, IntArray


class Rule(NamedTuple):
    """Points of an element in one direction, on [0, 1], and their weights, whose sum is one."""

    points: FloatArray
    """(n,) ascending."""
    weights: FloatArray
    """(n,)."""


def lobatto(count: int) -> Rule:
    """Return the Gauss-Lobatto rule of `count` ≥ 2 points on [0, 1], ascending.

    Its points are the ends and the roots of the derivative of P_{n−1}. The weights are 2 / (n (n −
    1) P_{n−1}²) on [−1, 1] (Abramowitz & Stegun, 25.4.32).
    """
    legendre = np.polynomial.legendre.Legendre.basis(count - 1)
    inner = np.sort(legendre.deriv().roots().real)
    points = np.concatenate([[-1.0], inner, [1.0]])
    weights = 2.0 / (count * (count - 1) * legendre(points) ** 2)
    return Rule(0.5 * (points + 1.0), 0.5 * weights)


class SurfaceNodes(NamedTuple):
    """Nodes of a slave on a shell of m control points: n points of its surface."""

    rows: SparseRows
    """N (n, m), the basis functions at the nodes."""
    columns: SparseRows
    """Nᵀ (m, n)."""
    weight: FloatArray
    """(n,) area at rest of each node."""
    facets: IntArray
    """(f, 3) triangles between the nodes."""
    grids: tuple[IntArray, ...]
    """(k, l) for each piece, node of each of its points along u and v."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return x = N q (n, 3) from control points q (m, 3); velocities likewise."""
        return self.rows.times(q)

    def spread(self, f: FloatArray) -> FloatArray:
        """Return forces on the nodes (n, 3) as forces Nᵀ f (m, 3) on control points."""
        return self.columns.times(f)


def surface_nodes(net: Net, count: int | None = None) -> SurfaceNodes:
    """Return the nodes of all patches, `count` along each side of an element.

    The default is the highest degree plus two. Nodes of joined edges are one; nodes are numbered
    piece by piece, along v first. Their areas are Gauss-Lobatto weights times |S_u × S_v|.
    """
    if count is None:
        count = max(max(piece.degrees) for piece in net.pieces) + 2
    rule = lobatto(count)
    bases: list[BasisAt] = []
    weights: list[FloatArray] = []
    grids: list[NDArray[np.intp]] = []
    n_points = 0
    for piece in net.pieces:
        (u, u_weights), (v, v_weights) = (_composite_rule(knots, rule) for knots in piece.knots)
        uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=2).reshape(-1, 2)
        at = on_net(piece, uv)
        normal = np.cross(at.of(U, net.points), at.of(V, net.points))
        area = np.sqrt(np.square(normal).sum(axis=1))
        bases.append(at)
        weights.append((u_weights[:, None] * v_weights).ravel() * area)
        grids.append(n_points + np.arange(len(uv)).reshape(len(u), len(v)))
        n_points += len(uv)
    first, numbers = merge_joined(grids, net.joints, n_points)
    all_rows = sparse_rows([at.control for at in bases], [at.values[:, VALUE] for at in bases])
    rows = all_rows.at(first)
    facets = [grid_facets(grid.shape[0], grid.shape[1], int(grid[0, 0])) for grid in grids]
    nodes = numbers.astype(np.int32)
    return SurfaceNodes(
        rows,
        rows.turned(len(net.points)),
        np.bincount(numbers, weights=np.concatenate(weights)).astype(np.float64),
        nodes[np.concatenate(facets)],
        tuple(nodes[grid] for grid in grids),
    )


def _composite_rule(knots: FloatArray, rule: Rule) -> Rule:
    """Return the rule repeated over all knot spans, in parameters of the knots.

    A point between two spans occurs once, with the sum of both weights. All weights sum to the
    length of the domain.
    """
    breaks = np.unique(knots)
    steps, inner = np.diff(breaks), len(rule.points) - 1
    points = np.append((breaks[:-1, None] + steps[:, None] * rule.points[:-1]).ravel(), breaks[-1])
    weights = np.zeros(len(points))
    for k, step in enumerate(steps):
        weights[k * inner : (k + 1) * inner + 1] += step * rule.weights
    return Rule(points, weights)


def side_of(grid: NDArray[Any], edge: str) -> NDArray[Any]:
    """Return the points on an edge of a grid (n, m), in the direction of u or v."""
    return rows_from(grid, edge)[0]
