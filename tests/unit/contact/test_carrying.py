"""What is known of the points in contact before forces, against the same in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.contact.kernels.carrying_nb import gather
from contiga.contact.loads import NO_POINTS
from contiga.contact.respond import ContactRows, LastDepths
from contiga.records import Projection

pytestmark = pytest.mark.interpreted

N = 60


def feet_of(rng: np.random.Generator) -> Projection:
    point, normal = rng.normal(size=(2, N, 3))
    bytes_of = np.zeros((3, N), np.int8)
    bytes_of[0] = rng.integers(0, 3, N)
    gap = np.where(rng.random(N) < 0.2, 0.0, -rng.random(N))
    gap[::9] = 0.3
    return Projection(np.zeros(N, np.int32), np.zeros((N, 2)), point, normal, gap, *bytes_of)


@pytest.mark.parametrize("known", [False, True])
def test_every_point_is_seen_as_plain_numpy_says(known: bool) -> None:
    rng = np.random.default_rng(5)
    feet = feet_of(rng)
    rows = np.flatnonzero(rng.random(N) < 0.6).astype(np.int32)
    now, before = rng.normal(size=(2, N, 3))
    before[rows[3]], before[rows[5], 1] = np.nan, np.inf
    patch = rng.integers(-1, 2, N).astype(np.int32)
    feature = rng.integers(0, 3, N).astype(np.int8)
    deep = np.flatnonzero(rng.random(N) < 0.5).astype(np.int32)
    penetration = rng.random(len(deep))
    velocity = rng.normal(size=(len(rows), 3)) if known else NO_POINTS
    points = ContactRows.of(rows, velocity)
    last = LastDepths(patch, feature, before, deep, penetration)
    gather(feet, now, last, 0.25, points)

    depth, normal = np.maximum(-feet.gap[rows], 0.0), feet.normal[rows]
    way = now[rows] - before[rows]
    way = np.where(np.isfinite(way), way, 0.0)
    was = np.zeros(N)
    was[deep] = penetration
    old = patch[rows] >= 0
    if known:
        rate = -(velocity * normal).sum(axis=1)
    else:
        rate = np.where(old, depth - was[rows], -(way * normal).sum(axis=1)) / 0.25
    for name, wanted in (
        ("depth", depth), ("normal", normal), ("foot", feet.point[rows]),
        ("path", way), ("old", old), ("rate", rate),
        ("switched", (patch != feet.patch)[rows] | (feature != feet.feature)[rows]),
    ):  # fmt: skip
        np.testing.assert_array_equal(getattr(points, name), wanted, err_msg=name)
    assert not np.signbit(points.depth).any()


def test_those_that_carry_are_the_later_ones() -> None:
    points = ContactRows.of(np.array([2, 5, 9, 11], np.int32))
    points.depth[:] = [1.0, 2.0, 3.0, 4.0]
    for first, wanted in ((5, [2.0, 3.0, 4.0]), (6, [3.0, 4.0]), (12, [])):
        assert points.from_point(first).depth.tolist() == wanted
