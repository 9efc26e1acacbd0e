"""Meshes are as fine as the surface bends, and no finer."""

from __future__ import annotations

import math

import numpy as np

import contiga as cg


def lengths(mesh):
    p = mesh.vertices[mesh.triangles]
    return np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2)


def test_triangles_of_a_sphere_are_as_wide_as_the_distance_allows():
    """A chord of length l is off a circle of radius R by l²/8R."""
    tol = 1e-3
    mesh = cg.Body([cg.shapes.sphere()]).tessellate(tol)
    longest = np.median(lengths(mesh).max(axis=1))
    assert 0.5 * math.sqrt(8.0 * tol) < longest < 2.0 * math.sqrt(8.0 * tol)


def test_triangles_of_a_cylinder_are_long_where_it_is_straight():
    mesh = cg.Body([cg.shapes.cylinder(radius=1.0, height=20.0)]).tessellate(1e-3)
    p = mesh.vertices[mesh.triangles]
    along = np.ptp(p[:, :, 2], axis=1)
    around = np.linalg.norm(np.ptp(p[:, :, :2], axis=1), axis=1)
    assert np.median(along / around) > 5.0


def test_a_plane_needs_no_vertex_inside():
    mesh = cg.Body([cg.shapes.plane(width=3.0, length=2.0)]).tessellate(1e-3)
    assert len(mesh.triangles) == 2
