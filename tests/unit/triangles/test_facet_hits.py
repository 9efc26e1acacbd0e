"""First entries through triangles: against every triangle, through edges and corners."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import Status, TriMesh
from contiga.errors import InputError


def _hits_are_the_oracles(oracle, mesh, a, b):
    hits = mesh.first_hit(a, b)
    tau = oracle.entries(mesh, a, b)
    first = tau.min(axis=1)
    met = np.isfinite(first)
    np.testing.assert_array_equal(hits.patch >= 0, met)
    np.testing.assert_allclose(hits.fraction[met], first[met], rtol=0, atol=1e-12)
    assert np.isnan(hits.fraction[~met]).all()
    on_path = a + hits.fraction[:, None] * (b - a)
    np.testing.assert_allclose(hits.point[met], on_path[met], rtol=0, atol=1e-8)
    reached = oracle.on_triangles(mesh, hits.patch[met], hits.uv[met])
    np.testing.assert_allclose(reached, hits.point[met], rtol=0, atol=1e-12)
    return hits


def test_hits_on_a_closed_mesh_are_those_of_every_triangle(oracle):
    torus = cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.05)
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 800, 3)) * [2.0, 2.0, 0.7]
    hits = _hits_are_the_oracles(oracle, torus, a, b)
    assert {Status.OK, Status.NO_HIT} == set(hits.status)


def test_hits_on_an_open_rough_sheet_are_those_of_every_triangle(oracle):
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-0.2, 1.2, (2, 800, 3)) - [[[0, 0, 0.5]]]
    _hits_are_the_oracles(oracle, oracle.rough(1), a, b)


def test_no_path_slips_through_edges_or_corners():
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.02)
    middles = ball.corners()[:, [0, 1, 2]] + ball.corners()[:, [1, 2, 0]]
    ends = np.concatenate([ball.vertices, 0.5 * middles.reshape(-1, 3)])
    rng = np.random.default_rng(2)
    for _ in range(20):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turned = TriMesh(ball.vertices @ turn.T, ball.triangles)
        if turned.volume() < 0.0:
            turned = turned.flipped()
        through = ends @ turn.T
        hits = turned.first_hit(2.0 * through, 0.1 * through)
        assert (hits.status == Status.OK).all()
        np.testing.assert_allclose(hits.fraction, 1.0 / 1.9, rtol=0, atol=1e-9)


def test_paths_along_axes_through_corners_of_the_boxes_are_seen(oracle):
    box = oracle.box()
    x = np.linspace(-0.5, 0.5, 11)
    grid = np.stack([*np.meshgrid(x, x, indexing="ij"), np.full((11, 11), 2.0)], -1).reshape(-1, 3)
    for axis in range(3):
        a = np.roll(grid, axis, axis=1)
        b = a.copy()
        b[:, (2 + axis) % 3] = -2.0
        hits = box.first_hit(a, b)
        assert (hits.fraction == 0.375).all()


@pytest.mark.interpreted
def test_only_the_way_in_counts(oracle):
    box = oracle.box()
    hits = box.first_hit([[0.1, 0.2, 0.0], [0.1, 0.2, 2.0]], [[0.1, 0.2, 2.0], [0.1, 0.2, -2.0]])
    assert hits.status.tolist() == [Status.NO_HIT, Status.OK]
    assert hits.fraction[1] == 0.375


def test_of_two_sheets_in_one_step_the_first_is_taken(oracle):
    box = oracle.box()
    stack = TriMesh(
        np.concatenate([box.vertices, box.vertices - [0, 0, 1.001]]),
        np.concatenate([box.triangles, box.triangles + 8]),
    )
    hit = stack.first_hit([[0.1, 0.2, 1.0]], [[0.1, 0.2, -3.0]])
    assert hit.fraction[0] == 0.125
    assert hit.patch[0] < 12


def test_starts_and_ends_on_the_surface_count(oracle):
    box = oracle.box()
    hits = box.first_hit(
        [[0.1, 0.2, 0.5], [0.1, 0.2, 1.0], [0.1, 0.2, 0.5]],
        [[0.1, 0.2, 0.0], [0.1, 0.2, 0.5], [0.1, 0.2, 0.9]],
    )
    assert hits.status.tolist() == [Status.AT_START, Status.OK, Status.NO_HIT]
    np.testing.assert_array_equal(hits.fraction[:2], [0.0, 1.0])


def test_bad_rows_are_marked_and_points_at_rest_hit_nothing(oracle):
    hits = oracle.box().first_hit(
        [[np.nan, 0, 0], [0, 0, 1], [0, 0, 2]], [[0, 0, 0], [0, np.inf, 0], [0, 0, 2]]
    )
    assert hits.status.tolist() == [Status.NOT_FINITE, Status.NOT_FINITE, Status.NO_HIT]


def test_segments_need_both_ends(oracle):
    with pytest.raises(InputError, match="as many ends as starts"):
        oracle.box().first_hit([[0, 0, 0]], [[0, 0, 0], [1, 1, 1]])
