"""What is known of points after they have moved, against the same in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.contact.kernels import place_nb
from contiga.records import ContactStatus

pytestmark = pytest.mark.interpreted


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("chunks", [1, 3])
def test_every_point_is_placed_as_plain_numpy_says(chunks):
    rng = np.random.default_rng(2)
    n = 400
    before, now = rng.normal(size=(2, n, 3))
    before[::17, 1], now[::19, 2], now[::23, 0] = np.nan, np.inf, np.nan
    patch = rng.integers(-1, 3, n).astype(np.int32)
    near = rng.integers(-1, 3, n).astype(np.int32)
    uv = rng.random((n, 2))
    distance = rng.normal(size=n) * 4.0
    distance[::13], distance[1::13], distance[2::29] = np.inf, 0.0, np.nan
    active = rng.random(n) < 0.8
    status, safe_distance = np.zeros(n, np.int8), np.zeros(n)
    found_near, found_uv = np.zeros(n, np.int32), np.zeros((n, 2))
    way, ignored = np.empty(n), np.empty(n, bool)
    lists = np.empty((2, n), np.int32), np.zeros((chunks, 2), np.int64)
    found = (status, safe_distance, found_near, found_uv, way, ignored)
    size = -(-n // chunks)
    known = patch, uv, near, distance
    place_nb.place((before, now), known, active, found, lists, size, 0, chunks)
    touching, free = (
        np.concatenate([own[c * size : c * size + count] for c, count in enumerate(lists[1][:, i])])
        for i, own in enumerate(lists[0])
    )

    whole = np.isfinite(now).all(axis=1)
    gone = np.linalg.norm(now - before, axis=1)
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
    np.testing.assert_array_equal(ignored[near_by], distance[near_by] < 0.0)
    np.testing.assert_array_equal(touching, np.flatnonzero(held))
    np.testing.assert_array_equal(free, np.flatnonzero(loose & (left <= 0.0)))
