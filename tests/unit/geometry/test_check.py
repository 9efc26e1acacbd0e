"""Triangles of a face are cut until all keep the distance."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg


@pytest.mark.parametrize("tol", [1e-2, 1e-3, 1e-4])
def test_no_place_of_the_face_is_farther_than_the_distance(tol):
    patch = cg.shapes.bumpy_plate(width=1.0, length=1.0, amplitude=0.05, waves=2)
    body = cg.Body([patch])
    mesh = body.tessellate(tol)
    (u0, u1), (v0, v1) = patch.domain
    grid = np.stack(np.meshgrid(np.linspace(u0, u1, 90), np.linspace(v0, v1, 90)), -1)
    points = patch.evaluate(grid.reshape(-1, 2))
    off = np.linalg.norm(mesh.project(points).point - points, axis=1).max()
    assert off <= tol
    assert off > 0.2 * tol
