"""Points on paths that bulge, against the same in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.layout import locked
from contiga.contact.kernels import bulging_nb
from contiga.contact.search_records import CHUNK, listed
from contiga.contact.settle_records import ChunkLists, LastPlaces, Motion

pytestmark = [
    pytest.mark.interpreted,
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
]


def paths(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Where points were and are, some of them nowhere."""
    rng = np.random.default_rng(3)
    before, now = rng.normal(size=(2, n, 3)) * [[[1.0, 3.0, 2.0]]]
    before[::17, 1], now[::19, 2], now[::23, 0] = np.nan, np.inf, np.nan
    before[5], now[5] = 1e200, -1e200
    return before, now


def ways(before: np.ndarray, now: np.ndarray) -> np.ndarray:
    return np.sqrt(((now - before) ** 2).sum(axis=1))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_farthest_way_and_coordinate_are_those_of_points_that_are_somewhere(axis, sign):
    n, size = 250, 100
    before, now = paths(n)
    before[30] = now[30] = 0.0
    before[30, axis] = now[30, axis] = 40.0 * sign
    before[130, axis], now[231, axis] = 50.0 * sign, 60.0 * sign
    most = np.full((3, 2), np.nan)
    bulging_nb.largest_paths(Motion(before, now), most, size, 0, 2)
    assert np.isnan(most[2]).all()
    bulging_nb.largest_paths(Motion(before, now), most, size, 2, 3)
    way = ways(before, now)
    for c in range(3):
        own = np.flatnonzero(np.isfinite(way[c * size : (c + 1) * size])) + c * size
        assert most[c, 0] == pytest.approx(way[own].max(), rel=1e-15)
        assert most[c, 1] == np.abs([before[own], now[own]]).max()


def test_nothing_is_farthest_of_no_points():
    most, none = np.ones((1, 2)), np.full((3, 3), np.nan)
    bulging_nb.largest_paths(Motion(none, none), most, 10, 0, 1)
    assert most.tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("size", [130, 400])
def test_points_within_reach_are_listed(size):
    n, bulge = 400, 0.5
    before, now = paths(n)
    rng = np.random.default_rng(4)
    patch = rng.integers(-2, 2, n).astype(np.int32)
    distance = rng.normal(size=n) * 8.0
    distance[::31] = np.nan
    active = rng.random(n) < 0.7
    way = ways(before, now)
    distance[200], patch[200], active[200] = way[200] + bulge, -1, True
    chunks = -(-n // size)
    lists = ChunkLists(np.full(n, -7, np.int32), np.full(chunks, -7))
    known = LastPlaces(patch, distance, locked(active))
    bulging_nb.list_within_reach(Motion(before, now), known, bulge, lists, size, 0, chunks)
    room = np.where(patch >= 0, 0.0, np.abs(distance))
    wanted = np.isfinite(way) & (active | (patch >= 0)) & (room <= way + bulge)
    parts = [lists.rows[c * size : c * size + count] for c, count in enumerate(lists.counts)]
    np.testing.assert_array_equal(np.concatenate(parts), np.flatnonzero(wanted))
    assert wanted[200]


def test_what_chunks_have_listed_is_one_list():
    own = np.arange(3 * CHUNK, dtype=np.int32)
    assert listed(own, np.array([3])).tolist() == [0, 1, 2]
    wanted = [0, 1, 2 * CHUNK]
    assert listed(own, np.array([2, 0, 1])).tolist() == wanted
    assert listed(own[:0], np.zeros(0, np.int64)).tolist() == []
