"""Feet that are proved by what is around them, against the search over all of a body."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.geometry.test_net import bent
from tests.unit.search.test_deformable import BODIES

import contiga as cg
from contiga.records import SurfacePlaces, empty_projection
from contiga.search.closest.kernels import proof_nb
from contiga.search.closest.surroundings import blocks_of, surroundings_of
from contiga.search.deformable import DeformedSurface, deformable_of
from contiga.statuses import Status


@njit
def is_closest(tables, surroundings, foot, point, distance):
    return proof_nb.is_closest(tables, surroundings, foot, point, distance)


def wavy(height: float = 0.3) -> DeformedSurface:
    """A sheet of 2 by 2 along a wave: beyond its crests a point has several feet."""
    parts = [k / 8 for k in range(1, 8)]
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0).k_refined((2, 2), parts, parts)])
    shape = body.net.points.copy()
    shape[:, 2] = height * np.cos(6.0 * shape[:, 0])
    return deformable_of(body).at(shape)


@pytest.mark.interpreted
def test_a_foot_is_proved_where_it_is_the_closest_point_and_never_elsewhere() -> None:
    surface = wavy()
    tables = surface.tables
    around = surroundings_of(blocks_of(tables.elements.table), tables.leaves)
    rng, n = np.random.default_rng(1), few(400, 12)
    points = np.column_stack([rng.uniform(-0.9, 0.9, (n, 2)), rng.uniform(-0.6, 0.9, n)])
    rows, closest = np.arange(n, dtype=np.int32), empty_projection(n)
    surface.closest(points, rows, closest)
    local = empty_projection(n)
    starts = rng.uniform(0.05, 0.95, (n, 2))
    surface.track(points, np.zeros(n, np.int32), starts, local)
    proved = others = 0
    for k in np.flatnonzero((closest.status == Status.OK) & (local.status == Status.OK)):
        for feet in (closest, local):
            e, s, t = _located(tables, feet.uv[k])
            away = float(np.linalg.norm(feet.point[k] - points[k]))
            told = is_closest(tables, around, (e, s, t), tuple(points[k]), away)
            farther = away > np.linalg.norm(closest.point[k] - points[k]) + 1e-9
            assert not (told and farther)
            proved, others = proved + (told and feet is closest), others + farther
    assert proved > 0.8 * (closest.status == Status.OK).sum()
    assert others > 0.1 * n


def _located(tables, uv):
    box = tables.elements.table["box"]
    held = (box[:, 0] <= uv[0]) & (uv[0] <= box[:, 1]) & (box[:, 2] <= uv[1]) & (uv[1] <= box[:, 3])
    e = int(np.flatnonzero(held)[0])
    low, high = box[e, ::2], box[e, 1::2]
    s, t = (uv - low) / (high - low) - 0.5
    return e, float(s), float(t)


@pytest.mark.parametrize("name", BODIES)
def test_feet_from_any_start_are_those_of_the_search(name: str) -> None:
    """Starts are feet on another shape, of the points or of others, or none."""
    body = BODIES[name]()
    deformable, rng, n = deformable_of(body), np.random.default_rng(4), 400
    low, high = body.bounds()
    points = rng.uniform(low - 0.3, high + 0.3, (n, 3))
    rows, before, closest = np.arange(n, dtype=np.int32), empty_projection(n), empty_projection(n)
    deformable.at(body.net.points).closest(points, rows, before)
    surface = deformable.at(bent(body, 2, 0.02))
    surface.closest(points, rows, closest)
    kind = rng.random(n)
    near = np.where(kind < 0.8, rows, rng.permutation(n))
    patch = np.where(kind < 0.1, -1, before.patch[near]).astype(np.int32)
    found = empty_projection(n)
    surface.closest_from(SurfacePlaces(patch, before.uv[near]), points, found)
    away, least = (np.linalg.norm(f.point - points, axis=1) for f in (found, closest))
    np.testing.assert_allclose(away, least, rtol=0, atol=1e-10 * body.size)
    assert (found.certified >= closest.certified).mean() > 0.99


def test_what_is_no_number_or_far_away_is_told_as_by_the_search() -> None:
    surface = wavy()
    points = np.array([[np.nan, 0.0, 0.0], [1e30, 2e30, 1e30], [0.1, 0.2, 0.5]])
    closest, found = empty_projection(3), empty_projection(3)
    surface.closest(points, np.arange(3, dtype=np.int32), closest)
    starts = SurfacePlaces(np.zeros(3, np.int32), np.full((3, 2), 0.4))
    surface.closest_from(starts, points, found)
    np.testing.assert_array_equal(found.status, closest.status)
    np.testing.assert_allclose(found.gap[1:], closest.gap[1:], rtol=1e-9)
