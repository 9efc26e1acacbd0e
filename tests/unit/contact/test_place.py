"""What is known of points after they have moved, against the same in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.layout import locked
from contiga.contact.foot_rows import blank
from contiga.contact.kernels import place_nb
from contiga.contact.loads import NO_POINTS, NO_SIZES, UNGUARDED, guard_states_of
from contiga.contact.search_records import Columns, Detection, Last, PlacementArrays
from contiga.records import ContactStatus
from contiga.rigid.frames import to_body

pytestmark = pytest.mark.interpreted

UNHELD = guard_states_of(NO_SIZES, NO_POINTS, UNGUARDED)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("chunks", [1, 3])
@pytest.mark.parametrize("calm", [False, True])
@pytest.mark.parametrize("surface_way", [0.0, 0.75])
def test_every_point_is_placed_as_plain_numpy_says(chunks, calm, surface_way):
    rng = np.random.default_rng(2)
    n = 3000
    before, now = rng.normal(size=(2, n, 3))
    before[::17, 1], now[::19, 2], now[::23, 0] = np.nan, np.inf, np.nan
    patch = rng.integers(-1, 3, n).astype(np.int32)
    near = rng.integers(-1, 3, n).astype(np.int32)
    uv = rng.random((n, 2))
    distance = rng.normal(size=n) * 4.0
    distance[::13], distance[1::13], distance[2::29] = np.inf, 0.0, np.nan
    active = rng.random(n) < 0.8
    # What the memory says of an earlier step, where it says something.
    status, safe_distance = rng.integers(0, 4, n).astype(np.int8), rng.normal(size=n)
    old, found_near = rng.integers(-1, 2, (2, n)).astype(np.int32)
    feature, certified = np.where(old >= 0, 1, np.array([[-1], [0]])).astype(np.int8)
    found_uv = np.where(((old >= 0) | (found_near >= 0))[:, None], rng.random((n, 2)), 0.0)
    if calm:  # whole stretches of points that are free and far, and in each some that are not
        quiet = rng.random(n) < 0.995
        patch[quiet] = near[quiet] = old[quiet] = found_near[quiet] = feature[quiet] = -1
        certified[quiet], found_uv[quiet] = 0, 0.0
        active |= quiet
        distance[quiet] = np.where(rng.random(n) < 0.3, -np.inf, 50.0 * (rng.random(n) + 1))[quiet]
        before[quiet] = np.where(np.isfinite(before), before, 0.0)[quiet]
        now[quiet] = np.where(np.isfinite(now), now, 0.0)[quiet]
        now[rng.random(n) < 1e-3] = np.nan
        before[rng.random(n) < 1e-3] = np.inf
        distance[rng.random(n) < 1e-3] *= 1e-3
        active[rng.random(n) < 1e-3] = False
        distance[500] = np.nan
        before[700], now[700], distance[700] = 0.0, [3.0, 4.0, 0.0], 5.0  # as far as it may go
    way, ignored = np.empty(n), np.empty(n, bool)
    lists = np.empty((2, n), np.int32), np.zeros((chunks, 2), np.int64)
    columns = Columns(status, safe_distance, found_near, found_uv, old, feature, certified)
    size = -(-n // chunks)
    last = Last(before, patch, uv, near, distance, UNHELD)
    placing = PlacementArrays(
        before, now, last, locked(active), columns, way, ignored, *lists, surface_way
    )
    place_nb.place(placing, size, 0, chunks)
    touching, free = (
        np.concatenate([own[c * size : c * size + count] for c, count in enumerate(lists[1][:, i])])
        for i, own in enumerate(lists[0])
    )

    whole = np.isfinite(now).all(axis=1)
    gone = np.linalg.norm(now - before, axis=1) + surface_way
    gone = np.where(np.isfinite(gone), gone, np.inf)
    held = whole & (patch >= 0)
    loose = whole & active & ~held
    left = np.maximum(np.abs(distance) - gone, 0.0)
    wanted = np.where(active, 0.0, np.inf)
    wanted[held] = np.maximum(distance - gone, 0.0)[held]
    wanted[loose] = np.copysign(left, distance)[loose]
    near_by = np.concatenate((touching, free))
    np.testing.assert_allclose(way[near_by], gone[near_by], rtol=1e-15)
    np.testing.assert_allclose(safe_distance, wanted, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(
        status, np.where(whole, ContactStatus.FREE, ContactStatus.NOT_FINITE)
    )
    np.testing.assert_array_equal(found_near, np.where(loose, near, -1))
    known = loose & (near >= 0)
    np.testing.assert_array_equal(found_uv, np.where(known[:, None], uv, 0.0))
    assert (old == -1).all()
    assert (feature == -1).all()
    assert not certified.any()
    np.testing.assert_array_equal(ignored[near_by], distance[near_by] < 0.0)
    np.testing.assert_array_equal(touching, np.flatnonzero(held))
    np.testing.assert_array_equal(free, np.flatnonzero(loose & (left <= 0.0)))


def test_what_is_held_is_listed_and_the_rest_forgets_its_parameters():
    rng = np.random.default_rng(5)
    n = 300
    patch, near = rng.integers(-1, 2, (2, n)).astype(np.int32)
    foot_uv, uv = rng.random((2, n, 2))
    asked = rng.random(n) < 0.7
    patch[~asked] = -1
    first = asked & (rng.random(n) < 0.5)
    lists = [np.flatnonzero(own).astype(np.int32) for own in (first, asked & ~first)]
    for order in (lists, lists[::-1], [np.flatnonzero(asked).astype(np.int32), lists[0][:0]]):
        own, rows = uv.copy(), np.empty(n, np.int32)
        feet = blank(n)._replace(patch=patch, uv=foot_uv)
        found = Detection(np.zeros(n, np.int8), feet, np.zeros(n), near, own, rows[:0])
        count = place_nb.list_touching(*order, found, rows)
        np.testing.assert_array_equal(rows[:count], np.flatnonzero(patch >= 0))
        wanted = np.where((patch >= 0)[:, None], foot_uv, uv)
        wanted[asked & (patch < 0) & (near < 0)] = 0.0
        np.testing.assert_array_equal(own, wanted)


@pytest.mark.parametrize("chunks", [1, 3])
def test_points_that_are_moved_are_placed_as_those_that_were(chunks):
    rng = np.random.default_rng(3)
    n = 1000
    p_W, before = rng.normal(size=(2, n, 3))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.linalg.qr(rng.normal(size=(3, 3)))[0], [0.3, -2.0, 1.0]
    now, size = to_body(pose, p_W), -(-n // chunks)
    none, distance = np.full(n, -1, np.int32), rng.random(n)

    def placed(kernel, points, *world):
        last = Last(before, none, np.zeros((n, 2)), none, distance, UNHELD)
        lists = np.zeros((2, n), np.int32), np.zeros((chunks, 2), np.int64)
        columns, ways = Columns.of(n), (np.zeros(n), np.zeros(n, bool))
        placing = PlacementArrays(
            before, points, last, locked(np.ones(n, bool)), columns, *ways, *lists
        )
        kernel(placing, *world, size, 0, chunks)
        return *columns, *ways, *lists

    filled = np.full((n, 3), np.nan)
    moved = placed(place_nb.move_and_place, filled, locked(p_W), pose)
    assert np.array_equal(filled, now)
    for own, other in zip(placed(place_nb.place, now), moved, strict=True):
        assert np.array_equal(own, other)
