"""Meshes and exact geometry beside each other, at a small size."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.thesis import comparison


def test_exact_penetrations_are_right_to_1e_10_and_meshes_get_there_by_their_tolerance() -> None:
    """An error of a mesh is at most its tolerance; of the exact side its feet's miss."""
    rows = comparison.accuracy(n=4000, repeats=3, most=50_000)
    for name in comparison.bodies():
        exact, *meshes = [row for row in rows if row.body == name]
        assert exact.master == comparison.NURBS
        assert exact.depth_error <= 1e-10
        assert len(meshes) == 3
        for row in meshes:
            assert exact.depth_error < row.depth_error <= row.relative
            assert row.megabytes > 0.0
        assert [row.elements for row in meshes] == sorted(row.elements for row in meshes)


def test_exact_penetrations_of_a_torus_have_the_closed_form() -> None:
    """|(ρ − R, z)| − r, with the foot tracked over several steps."""
    body = comparison.bodies()["torus"]
    low, high = body.bounds()
    minor = 0.5 * (high[2] - low[2])
    major = high[0] - minor
    places = comparison.path(body, 2000, 3)
    feet = body.project(places[0])
    for place in places[1:]:
        feet = body.project(place, start=feet, mode="track")
    across = np.hypot(places[-1][:, 0], places[-1][:, 1]) - major
    gap = np.hypot(across, places[-1][:, 2]) - minor
    np.testing.assert_allclose(feet.gap, gap, rtol=0, atol=1e-12 * body.size)
    assert (gap < 0.0).any()


def test_points_of_the_comparison_have_a_foot_inside_the_body_at_every_step() -> None:
    """None runs over the border of the plate, where distances are to an edge."""
    body = comparison.bodies()["bumpy plate"]
    places = comparison.path(body, 2000, 3)
    assert 1500 < len(places[0]) <= 2000
    for place in places:
        assert (body.project(place).status == cg.Status.OK).all()


def test_a_turning_torus_has_a_constant_force_and_a_turning_mesh_has_not() -> None:
    """Noise below 1e-9 of the force against more than 1e-4 of a mesh with an error of 1e-3."""
    found = comparison.noise(points=800, turns=31, finest=2)
    assert found.spread(comparison.NURBS) < 1e-9
    assert found.force[comparison.NURBS].min() > 0.0
    assert found.spread("mesh 1e-02") > found.spread("mesh 1e-03") > 1e-4
