"""Elements of a net of patches: basis functions at Gauss points, and the shell's axes at rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import checked_choice
from contiga.errors import GeometryError
from contiga.patches.basis import UU, UV, VALUE, VV, BasisAt, U, V, elements_of
from contiga.patches.checks import PARALLEL_TOL, whole_number
from contiga.patches.net import Net, on_net
from contiga.patches.nodes import Rule, SurfaceNodes, surface_nodes
from contiga.patches.pieces import Piece
from contiga.patches.points import SplinePoints, grid_facets, sparse_rows
from contiga.records import FloatArray


def gauss(count: int) -> Rule:
    """Return Gauss's rule on 0 … 1."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return Rule(0.5 * (points + 1.0), 0.5 * weights)


def midpoints(count: int) -> Rule:
    """Return the midpoint rule on 0 … 1."""
    return Rule((np.arange(count) + 0.5) / count, np.full(count, 1.0 / count))


RULES = {"gauss": gauss, "grid": midpoints}
"""Rules for points of contact inside elements."""


class Grid(NamedTuple):
    """Points of all elements of a piece, with v running fastest through all elements."""

    shape: tuple[int, int]
    """Numbers of elements in u and in v."""
    points: tuple[int, int]
    """Numbers of points of an element in u and in v."""
    at: BasisAt
    """Basis functions, with numbers of the net for the control points."""
    weights: FloatArray
    """(k,) integration weights in the parameters."""

    def by_element(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values (k, …) at points as (e, g, …)."""
        (e, f), (g, h) = self.shape, self.points
        grid = values.reshape(e, g, f, h, *values.shape[1:]).swapaxes(1, 2)
        return np.ascontiguousarray(grid.reshape(e * f, g * h, *values.shape[1:]))


def grid_of(piece: Piece, rules: tuple[Rule, Rule]) -> Grid:
    """Return the points of the elements of a piece by a rule in u and one in v."""
    parameters, weights, shape = [], [], []
    for knots, rule in zip(piece.knots, rules, strict=True):
        spans = elements_of(knots)
        length = spans[:, 1] - spans[:, 0]
        parameters.append((spans[:, :1] + length[:, None] * rule.points).ravel())
        weights.append((length[:, None] * rule.weights).ravel())
        shape.append(len(spans))
    at = _at_grid(piece, parameters[0], parameters[1])
    counts = len(rules[0].points), len(rules[1].points)
    weights_uv = (weights[0][:, None] * weights[1]).ravel()
    return Grid((shape[0], shape[1]), counts, at, weights_uv)


def _at_grid(piece: Piece, u: FloatArray, v: FloatArray) -> BasisAt:
    """Return the basis at a grid of parameters (n,) and (m,)."""
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=2).reshape(-1, 2)
    return on_net(piece, uv)


class AtRest(NamedTuple):
    """A shell at rest at k points."""

    axes: FloatArray
    """(k, 2, 2) components of orthonormal axes in S_u and S_v: e_i = Σ Q_αi S_α."""
    area: FloatArray
    """(k,) |S_u × S_v|."""
    basis: FloatArray
    """(k, c, 5) derivatives along these axes: 1, 2, 11, 22, 12."""
    curvature: FloatArray
    """(k, 3) B₁₁, B₂₂, B₁₂."""


def at_rest(net: Net, at: BasisAt, direction: FloatArray | None) -> AtRest:
    """Return a shell at rest at points; its first axis is along S_u, or a direction (3,).

    Raises
    ------
    GeometryError
        No normal at a point, or a direction across the surface.
    """
    a, b = at.of(U, net.points), at.of(V, net.points)
    normal = np.cross(a, b)
    area = lengths(normal)
    is_flat = ~(area > PARALLEL_TOL * lengths(a) * lengths(b))
    if is_flat.any():
        place = at.of(VALUE, net.points)[np.argmax(is_flat)]
        raise GeometryError(
            "has no normal inside an element",
            where="surfaces",
            found=np.round(place, 9).tolist(),
            allowed="surfaces whose S_u and S_v span a plane",
        )
    normal /= area[:, None]
    first = a if direction is None else direction - _dot(normal, direction)[:, None] * normal
    length = lengths(first)
    if (length <= PARALLEL_TOL).any() and direction is not None:
        raise GeometryError(
            "the warp is across the surface",
            where="direction",
            found=direction.tolist(),
            allowed="a direction along the surface everywhere",
        )
    first = first / length[:, None]
    second = np.cross(normal, first)
    # S_α = Σ L_αi e_i, so that e_i = Σ (L⁻¹)_iα S_α.
    p, q, r, s = _dot(a, first), _dot(a, second), _dot(b, first), _dot(b, second)
    axes = np.stack([s, -r, -q, p], axis=1).reshape(-1, 2, 2) / (p * s - q * r)[:, None, None]
    # Derivatives along the axes, from those in u and v.
    (u_1, u_2), (v_1, v_2) = axes[:, 0].T[:, :, None], axes[:, 1].T[:, :, None]
    n_u, n_v, n_uu, n_vv, n_uv = (at.values[:, k] for k in (U, V, UU, VV, UV))
    derivatives = [
        u_1 * n_u + v_1 * n_v,
        u_2 * n_u + v_2 * n_v,
        u_1 * u_1 * n_uu + 2.0 * u_1 * v_1 * n_uv + v_1 * v_1 * n_vv,
        u_2 * u_2 * n_uu + 2.0 * u_2 * v_2 * n_uv + v_2 * v_2 * n_vv,
        u_1 * u_2 * n_uu + (u_1 * v_2 + u_2 * v_1) * n_uv + v_1 * v_2 * n_vv,
    ]
    basis = np.stack(derivatives, axis=2)
    second_derivatives = np.stack(
        [(basis[:, :, k, None] * net.points[at.control]).sum(axis=1) for k in (2, 3, 4)], axis=1
    )
    curvature = np.asarray((second_derivatives * normal[:, None]).sum(axis=2))
    return AtRest(axes, area, basis, curvature)


def contact_points(net: Net, kind: str, count: int | None) -> SplinePoints | SurfaceNodes:
    """Return the points of contact of a shell: "nodes" of its surface, or of a rule in `RULES`.

    `count` is their number in an element each way, at least 2 for nodes; None for the default.

    Raises
    ------
    InputError
        An unknown kind, or a count that is too small.
    """
    checked_choice("contact", kind, ("nodes", *RULES))
    if count is not None:
        count = whole_number(count, "points", 2 if kind == "nodes" else 1)
    return surface_nodes(net, count) if kind == "nodes" else points_of(net, RULES[kind], count)


def points_of(net: Net, rule: Callable[[int], Rule], count: int | None) -> SplinePoints:
    """Return the points of a rule in all elements, `count` each way; p + 1 and q + 1 if None."""
    bases: list[BasisAt] = []
    measures: list[FloatArray] = []
    shapes: list[tuple[int, int]] = []
    for piece in net.pieces:
        p, q = piece.degrees
        grid = grid_of(piece, (rule(count or p + 1), rule(count or q + 1)))
        bases.append(grid.at)
        measures.append(grid.weights)
        shapes.append((grid.shape[0] * grid.points[0], grid.shape[1] * grid.points[1]))
    return _spline_points(net, bases, np.concatenate(measures), shapes)


def drawn_points(net: Net, parts: int) -> SplinePoints:
    """Return a mesh of all patches with their edges, each element in `parts` in u and in v.

    Its points have no area: they are for pictures.
    """
    bases: list[BasisAt] = []
    shapes: list[tuple[int, int]] = []
    for piece in net.pieces:
        lines = []
        for knots in piece.knots:
            breaks = np.unique(knots)
            steps = np.arange(parts) / parts
            inner = breaks[:-1, None] + np.diff(breaks)[:, None] * steps
            lines.append(np.append(inner.ravel(), breaks[-1]))
        bases.append(_at_grid(piece, lines[0], lines[1]))
        shapes.append((len(lines[0]), len(lines[1])))
    return _spline_points(net, bases, np.zeros(sum(n * m for n, m in shapes)), shapes)


def _spline_points(
    net: Net, bases: list[BasisAt], measure: FloatArray, shapes: list[tuple[int, int]]
) -> SplinePoints:
    """Return the points of grids, one for each piece, with the facets between them.

    `bases` are the basis functions at the points of each grid, `shapes` the numbers of its points
    in u and v, and `measure` (n,) the weights of all points in the parameters.
    """
    columns = [at.control for at in bases]
    rows, along_u, along_v = (
        sparse_rows(columns, [at.values[:, order] for at in bases]) for order in (VALUE, U, V)
    )
    facets = []
    first = 0
    for n, m in shapes:
        facets.append(grid_facets(n, m, first))
        first += n * m
    normals = np.cross(along_u.times(net.points), along_v.times(net.points))
    weight = measure * lengths(normals)
    columns_of = rows.turned(len(net.points))
    return SplinePoints(rows, columns_of, along_u, along_v, measure, weight, np.concatenate(facets))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.sum(a * b, axis=-1))


def lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths (…) of vectors (…, 3)."""
    return np.asarray(np.sqrt(_dot(vectors, vectors)))
