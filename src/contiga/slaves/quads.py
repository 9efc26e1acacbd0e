"""Quadrilateral faces of solid elements: bilinear, though drawn and cut as two triangles each.

Areas, quadrature and loads use the bilinear face, so that they do not depend on the diagonal of the
split. (Shells of four corners are two triangles in all respects: as membranes they deform and have
their masses so.)

    x(u, v) = Σ_i N_i(u, v) x_i,  N = ((1 − u)(1 − v), u(1 − v), uv, (1 − u)v)

The Gauss rule of 2 × 2 points integrates without error the areas N_i |x_u × x_v| of a flat convex
quadrilateral, and the vectors N_i (x_u × x_v) of any, whose components are polynomials of degree 2
in u and in v.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.quadrature import gauss
from contiga.records import FloatArray, IntArray
from contiga.slaves.cells import SOLIDS

_AREA_POINTS = 4
"""Gauss points a direction for areas of corners: the error of warped faces is below 1e-6 if their
corners are off their plane by a fifth of a side."""


class SkinCorners(NamedTuple):
    """Corners of the faces of a skin, rows of the points of a slave."""

    quads: IntArray
    """(q, 4)."""
    triangles: IntArray
    """(t, 3) facets that are no half of a quadrilateral."""


class QuadRule(NamedTuple):
    """A product Gauss rule on the bilinear quadrilateral."""

    shape: FloatArray
    """(k, 4) shape functions of the corners."""
    along_u: FloatArray
    """(k, 4) their derivatives with respect to u."""
    along_v: FloatArray
    """(k, 4) with respect to v."""
    weight: FloatArray
    """(k,), their sum is one."""


def quad_rule(count: int) -> QuadRule:
    """Return the Gauss rule of count × count points; points of one u follow each other."""
    nodes, weights = gauss(count)
    u, v = (axis.ravel() for axis in np.meshgrid(nodes, nodes, indexing="ij"))
    return QuadRule(
        np.stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v], axis=1),
        np.stack([v - 1.0, 1.0 - v, v, -v], axis=1),
        np.stack([u - 1.0, -u, u, 1.0 - u], axis=1),
        np.outer(weights, weights).ravel(),
    )


_EXACT = quad_rule(2)
_FINE = quad_rule(_AREA_POINTS)


def halves_of(facets: IntArray | None, elements: Mapping[str, IntArray], count: int) -> IntArray:
    """Return pairs of triangles that are the halves of a quadrilateral face of a solid element.

    Two facets are a pair if they alone share an edge, and their four corners are those of a face.

    Parameters
    ----------
    facets : (m, 3) rows of points; None for a cloud
    elements : cells by kind, rows of points
    count : number of points

    Returns
    -------
    (q, 2) rows of `facets`, each pair ascending
    """
    quads = [
        cells[:, list(side)]
        for kind, cells in elements.items()
        if kind in SOLIDS
        for side in SOLIDS[kind].corner_faces
        if len(side) == 4
    ]
    if facets is None or len(facets) == 0 or not quads:
        return np.zeros((0, 2), np.int32)
    on_skin = np.zeros(count, np.bool_)
    on_skin[facets] = True
    faces = np.concatenate(quads)
    faces = faces[on_skin[faces].all(axis=1)]
    edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys = edges[:, 0] * np.int64(count) + edges[:, 1]
    order = np.argsort(keys, kind="stable")
    _, start, users = np.unique(keys[order], return_index=True, return_counts=True)
    inner = start[users == 2, None] + np.arange(2)
    sides_of_pair = order[inner]
    pairs = sides_of_pair // 3
    apexes = facets[:, [2, 0, 1]].ravel()[sides_of_pair]
    corners = np.concatenate([edges[sides_of_pair[:, 0]], apexes], axis=1)
    stacked = np.sort(np.concatenate([faces, corners]), axis=1)
    _, ids = np.unique(stacked, axis=0, return_inverse=True)
    is_face = np.isin(ids.ravel()[len(faces) :], ids.ravel()[: len(faces)])
    return np.sort(pairs[is_face].astype(np.int32), axis=1)


def corners_of(
    facets: IntArray, quads: IntArray, chosen: NDArray[np.bool_] | None = None
) -> SkinCorners:
    """Return the faces that facets (m, 3) make up: quadrilaterals of two halves, and triangles.

    `quads` (q, 2) are the rows of the halves. `chosen` (m,) selects facets; of a quadrilateral it
    must have both halves or none. Corners are in the sense of the facets, quadrilaterals in the
    order of `quads` and triangles in that of the facets.
    """
    is_triangle = np.ones(len(facets), np.bool_) if chosen is None else chosen.copy()
    halves = quads[is_triangle[quads].all(axis=1)]
    is_triangle[halves] = False
    first, second = facets[halves[:, 0]], facets[halves[:, 1]]
    # the corner that the other half lacks, and the two after it in the sense of the facet
    apex = np.argmin((first[:, :, None] == second[:, None, :]).any(axis=2), axis=1)
    other_apex = np.argmin((second[:, :, None] == first[:, None, :]).any(axis=2), axis=1)
    rows = np.arange(len(halves))
    a, b, d = (first[rows, (apex + k) % 3] for k in range(3))
    corners = np.stack([a, b, second[rows, other_apex], d], axis=1)
    return SkinCorners(np.ascontiguousarray(corners), np.ascontiguousarray(facets[is_triangle]))


def quad_normals(points: FloatArray, quads: IntArray, rule: QuadRule) -> FloatArray:
    """Return x_u × x_v (q, k, 3) at the k points of a rule on quadrilaterals (q, 4) of `points`."""
    corners = points[quads]
    along_u = np.einsum("kj,qjd->qkd", rule.along_u, corners, optimize=False)
    along_v = np.einsum("kj,qjd->qkd", rule.along_v, corners, optimize=False)
    return np.cross(along_u, along_v)


def triangle_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (t, 3) twice the areas of triangles (t, 3), along their normals."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def corner_areas(points: FloatArray, skin: SkinCorners) -> tuple[FloatArray, FloatArray]:
    """Return areas ∫ N_i dA of the corners: (q, 4) of quadrilaterals and (t, 3) of triangles.

    By 4 × 4 Gauss points on a quadrilateral: not exact on a warped one, see `_AREA_POINTS`.
    """
    jacobian = np.linalg.norm(quad_normals(points, skin.quads, _FINE), axis=2)
    of_quads = np.einsum("qk,k,kj->qj", jacobian, _FINE.weight, _FINE.shape, optimize=False)
    third = np.linalg.norm(triangle_normals(points, skin.triangles), axis=1) / 6.0
    return of_quads, np.repeat(third[:, None], 3, axis=1)


def corner_vectors(points: FloatArray, skin: SkinCorners) -> tuple[FloatArray, FloatArray]:
    """Return ∫ N_i n dA of the corners: (q, 4, 3) of quadrilaterals, (t, 3, 3) of triangles.

    They are exact; for a closed skin they are the gradient of the volume inside.
    """
    normals = quad_normals(points, skin.quads, _EXACT)
    shares = _EXACT.weight[:, None] * _EXACT.shape
    of_quads = np.einsum("kj,qkd->qjd", shares, normals, optimize=False)
    third = triangle_normals(points, skin.triangles) / 6.0
    return of_quads, np.repeat(third[:, None], 3, axis=1)


def at_corners(skin: SkinCorners, values: tuple[FloatArray, FloatArray], count: int) -> FloatArray:
    """Return sums (n,) at `count` points of values (q, 4) and (t, 3) at the corners of faces."""
    rows = np.concatenate([skin.quads.ravel(), skin.triangles.ravel()])
    weights = np.concatenate([values[0].ravel(), values[1].ravel()])
    return np.bincount(rows, weights=weights, minlength=count).astype(np.float64)
