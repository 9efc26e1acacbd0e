"""Distances to the boxes of a hierarchy of triangles, against all of them."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.kernels import closest_nb


def test_the_distance_to_the_nearest_box_of_a_triangle_is_exact():
    mesh = cg.Body([cg.shapes.torus()]).tessellate(0.02)
    facets = tables_of(mesh).facets
    corners = mesh.vertices[mesh.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    points = np.random.default_rng(0).uniform(-6.0, 6.0, (40, 3))
    points[7] = np.nan
    rows = np.arange(40, dtype=np.int32)[::-1].copy()
    actual = np.zeros(40)
    closest_nb.box_distance(facets, points, rows, actual, 0, 40)
    away = np.maximum(np.maximum(low - points[:, None], points[:, None] - high), 0.0)
    expected = np.linalg.norm(away, axis=2).min(axis=1)
    expected[7] = np.inf
    np.testing.assert_allclose(actual, expected, rtol=1e-9, atol=1e-9)


def test_feet_are_the_closest_of_all_triangles():
    mesh = cg.Body([cg.shapes.saddle()]).tessellate(0.05)
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (60, 3))
    feet = mesh.project(points)
    single = [cg.TriMesh(mesh.vertices, t[None]).project(points).gap for t in mesh.triangles]
    np.testing.assert_allclose(np.abs(feet.gap), np.abs(single).min(axis=0), rtol=1e-12, atol=1e-14)
