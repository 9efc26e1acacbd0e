"""The closest point of a body, against dense samples of it."""

from __future__ import annotations

import numpy as np
import pytest
from tests import occ_solids

import contiga as cg
from contiga.geometry.kernels.trim_nb import points_in_trim


def rough(seed, rows=6):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, rows)], indexing="ij")
    net = np.stack([x, y, 0.6 * rng.normal(size=(rows, rows))], axis=-1)
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, rows - 2), np.ones(3)])
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.5, 2.0, (rows, rows)))


@pytest.mark.parametrize("seed", range(4))
def test_no_sample_of_the_surface_is_closer(seed):
    patch = rough(seed)
    u = np.linspace(0.0, 1.0, 160)
    samples = patch.evaluate(np.stack(np.meshgrid(u, u), -1).reshape(-1, 2))
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (80, 3))
    feet = cg.Body([patch]).project(points)
    found = np.linalg.norm(points - feet.point, axis=1)
    nearest = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert (found <= nearest + 1e-12).all()
    assert (found >= nearest - 0.06).all()
    assert feet.certified[feet.feature == cg.Feature.FACE].all()


STAR = np.array([[0, 0], [3, 0.2], [0.6, 0.5], [1.2, 2.5], [0.3, 0.7], [-1.5, 0.4], [-0.1, 0.2]])


def polygon(corners):
    """The part of a plane patch over [−4, 4]² that a polygon bounds."""
    ends = np.column_stack([corners, np.zeros(len(corners))])
    loop = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [a, b])
        for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True)
    )
    plane = cg.shapes.bilinear([-4, -4, 0], [4, -4, 0], [-4, 4, 0], [4, 4, 0])
    knots = [-4.0, -4.0, 4.0, 4.0]
    return cg.Body([cg.NurbsSurface((1, 1), (knots, knots), plane.control_points)], trims=[[loop]])


def distance_to_polygon(corners, points):
    a, b = corners, np.roll(corners, -1, axis=0)
    way = b - a
    r = points[:, None, :2] - a
    share = np.clip((r * way).sum(axis=2) / (way * way).sum(axis=1), 0.0, 1.0)
    border = np.linalg.norm(r - share[..., None] * way, axis=2).min(axis=1)
    x, y = points[:, 0, None], points[:, 1, None]
    crosses = (a[:, 1] <= y) != (b[:, 1] <= y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) / way[:, 1] * way[:, 0]
    inside = (crosses & (at > x)).sum(axis=1) % 2 == 1
    return np.hypot(np.where(inside, 0.0, border), points[:, 2])


@pytest.mark.parametrize("turned", [False, True])
def test_of_a_face_with_sharp_corners_the_nearest_is_found(turned):
    corners = STAR[::-1] if turned else STAR
    rng = np.random.default_rng(2)
    points = rng.uniform(-4.0, 4.0, (2000, 3))
    points[:300] = np.column_stack([STAR[rng.integers(0, 7, 300)], np.zeros(300)])
    points[:300] += rng.normal(size=(300, 3)) * np.geomspace(1e-9, 0.1, 300)[:, None]
    feet = polygon(corners).project(points)
    found = np.linalg.norm(feet.point - points, axis=1)
    np.testing.assert_allclose(found, distance_to_polygon(corners, points), rtol=0, atol=1e-11)


def test_of_trimmed_curved_faces_no_sample_is_nearer(tmp_path):
    body = cg.read_cad(occ_solids.write(occ_solids.crossing_bores(), tmp_path / "solid.step"))
    samples = []
    for k, patch in enumerate(body.patches):
        u, v = (np.linspace(*ends, 60) for ends in patch.domain)
        uv = np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)
        samples.append(patch.evaluate(uv[points_in_trim(body.trim_tables, k, uv)]))
    samples = np.concatenate(samples)
    points = np.random.default_rng(3).uniform(-13.0, 13.0, (300, 3))
    found = np.linalg.norm(body.project(points).point - points, axis=1)
    nearest = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert (found <= nearest + 1e-9).all()
    assert (found >= nearest - 0.5).all()
