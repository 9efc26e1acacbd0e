"""Meshes at wanted errors, and how few triangles could do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import contiga as cg
from contiga_validation.rivals.rival_meshes import ERRORS, fewest_triangles, hausdorff, rival_meshes


def test_fewest_triangles_of_a_sphere() -> None:
    """∫√K dA = 4πR, over 3√3/2 · e."""
    body = cg.Body([cg.shapes.sphere(radius=2.0)])
    expected = 8.0 * np.pi / (1.5 * np.sqrt(3.0) * 1e-3)
    assert fewest_triangles(body, 1e-3) == pytest.approx(expected, rel=1e-3)


def test_fewest_triangles_of_a_torus() -> None:
    """√|K| dA = √(r |cos θ| (R + r cos θ)) dθ dφ, with another factor inside than outside."""
    major, minor = 2.0, 0.5

    def element(angle: float) -> float:
        share = 2.0 / (3.0 * np.sqrt(3.0)) if np.cos(angle) > 0.0 else 0.5 / np.sqrt(5.0)
        around = minor * abs(np.cos(angle)) * (major + minor * np.cos(angle))
        return float(share * np.sqrt(around))

    half = np.pi / 2
    total = quad(element, -half, half)[0] + quad(element, half, 3 * half)[0]
    body = cg.Body([cg.shapes.torus(major=major, minor=minor)])
    expected = 2.0 * np.pi * total / 1e-3
    assert fewest_triangles(body, 1e-3) == pytest.approx(expected, rel=1e-2)


def test_distance_of_a_mesh_is_that_of_its_farthest_point() -> None:
    mesh = cg.TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert hausdorff(mesh, np.array([[0.2, 0.2, 0.1], [0.3, 0.3, -0.25]])) == 0.25


def test_meshes_have_the_wanted_errors_with_fewer_triangles_than_the_proof_asks_for() -> None:
    """And a finer one is an even subdivision, in which no knot is missed by much."""
    body = cg.Body([cg.shapes.torus()])
    on = cg.clouds.random_on(body.patches[0], 4000, seed=1)
    actual = list(rival_meshes(body, on, 40_000))
    assert [rival.target for rival in actual] == list(ERRORS)
    built = [rival for rival in actual if rival.mesh is not None]
    assert [rival.target for rival in built] == [1e-2, 1e-3, 1e-4]
    for rival in built[1:]:
        assert rival.error == pytest.approx(rival.target, rel=0.2)
        assert rival.triangles == len(rival.mesh.triangles)
        assert rival.triangles > fewest_triangles(body, rival.error * body.size)
    assert built[2].triangles < len(body.tessellate(1e-4 * body.size).triangles)
    assert actual[3].triangles == pytest.approx(10 * actual[2].triangles, rel=1e-3)
    assert actual[3].error is None
