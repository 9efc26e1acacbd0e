"""The single passes over points that are settled at once, against the same in whole arrays."""

from __future__ import annotations

import numpy as np
import pytest
from numba import config

from contiga.contact.foot_rows import blank
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import UNHELD
from contiga.contact.search_records import Detected, Limits, Step
from contiga.contact.settle_records import AskedFeet, FootBalls, FreeRows, TouchingRows
from contiga.records import ContactStatus, KnownSides, Projection, SurfacePlaces
from contiga.statuses import Feature, Status

pytestmark = [
    pytest.mark.interpreted,
    pytest.mark.skipif(not config.DISABLE_JIT, reason="only kernels call them"),
]
N = 2000
BAND = 0.01


def _feet(rng: np.random.Generator, n: int) -> Projection:
    status = [Status.OK, Status.OK, Status.BORDER, Status.TRIMMED, Status.BRANCH_EVENT]
    return Projection(
        rng.integers(0, 5, n).astype(np.int32),
        rng.random((n, 2)),
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3)),
        np.where(rng.random(n) < 0.1, 0.5 * BAND, rng.normal(size=n)),
        rng.integers(0, 3, n).astype(np.int8),
        rng.choice([*status, Status.MAX_ITERATIONS], n).astype(np.int8),
        rng.integers(0, 2, n).astype(np.int8),
    )


def touching_rows() -> TouchingRows:
    (rows, patch), (before, now) = np.empty((2, N), np.int32), np.empty((2, N, 3))
    side, reach = np.empty(N, np.int8), np.empty(N)
    return TouchingRows(rows, side, reach, patch, np.empty((N, 2)), before, now)


def free_rows() -> FreeRows:
    which, patch = np.empty((2, N), np.int32)
    return FreeRows(which, patch, np.empty((N, 2)), np.empty((N, 3)))


def limits_of(*, hold: bool = False, closed: bool = True) -> Limits:
    return Limits(closed, False, hold, False, BAND, 0.0, np.inf, 1e-9)


def _found(
    status: np.ndarray,
    safe_distance: np.ndarray,
    last_patch: np.ndarray | None = None,
    uv: np.ndarray | None = None,
) -> Detected:
    """What is found of as many points; feet of none."""
    n = len(status)
    near = np.full(n, -1, np.int32) if last_patch is None else last_patch
    places = np.zeros((n, 2)) if uv is None else uv
    return Detected(status, blank(n), safe_distance, near, places, np.zeros(0, np.int32))


def _step(before: np.ndarray, now: np.ndarray) -> Step:
    """A step of points of which nothing else is known."""
    n = len(now)
    ignored, patch = np.zeros(n, bool), np.full(n, -1, np.int32)
    return Step(before, now, np.zeros(n), ignored, patch, np.zeros((n, 2)), UNHELD)


def _sound(feet: Projection) -> np.ndarray:
    good = np.isin(feet.status, (Status.OK, Status.BRANCH_EVENT))
    return good & (feet.feature == Feature.FACE) & (np.abs(feet.gap) > BAND)


def _balls(
    feet: Projection, rows: np.ndarray, radius: np.ndarray, side: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Sides and reaches by balls, filled in; which of the rows are proved to be closest points."""
    nearest = np.zeros(len(side), bool)
    for i, ball in zip(rows, radius, strict=True):
        sign, height = np.sign(feet.gap[i]), abs(feet.gap[i])
        way = min(height, 2.0 * ball - height)
        nearest[i] = height + BAND <= ball
        if way > BAND and side[i] != -sign:
            side[i], reach[i] = sign, max(reach[i], way)
    return nearest


def test_points_that_are_outside_are_released_and_the_others_listed() -> None:
    rng = np.random.default_rng(1)
    rows = np.sort(rng.choice(2 * N, N, replace=False)).astype(np.int32)
    side, reach = rng.integers(-1, 2, N).astype(np.int8), rng.random(N)
    before, now = rng.normal(size=(2, 2 * N, 3))
    patch, uv = rng.integers(0, 9, 2 * N).astype(np.int32), rng.random((2 * N, 2))
    status, safe = np.zeros(2 * N, np.int8), np.full(2 * N, -7.0)
    work = touching_rows()
    found, step = _found(status, safe), _step(before, now)
    n = settle_nb.stay(
        rows, KnownSides(side, reach), step, SurfacePlaces(patch, uv), found, BAND, work
    )
    out, left = rows[side > 0], side <= 0
    assert n == left.sum()
    assert 0 < n < N
    wanted = np.full(2 * N, -7.0)
    wanted[out] = reach[side > 0] - BAND
    np.testing.assert_array_equal(safe, wanted)
    np.testing.assert_array_equal(np.flatnonzero(status == ContactStatus.RELEASED), out)
    own = rows[left]
    listed = own, side[left], reach[left], patch[own], uv[own], before[own], now[own]
    for a, b in zip(work, listed, strict=True):
        np.testing.assert_array_equal(a[:n], b)


@pytest.mark.parametrize("hold", [False, True])
def test_what_becomes_of_points_in_contact(hold: bool) -> None:
    rng = np.random.default_rng(2)
    feet, rows = _feet(rng, N), np.sort(rng.choice(2 * N, N, replace=False)).astype(np.int32)
    side, reach = rng.integers(-1, 1, N).astype(np.int8), rng.random(N)
    safe = np.where(rng.random(2 * N) < 0.4, rng.random(2 * N), 0.0)
    at_border = np.isin(feet.status, (Status.BORDER, Status.TRIMMED))
    solved = feet.status != Status.MAX_ITERATIONS
    keep = solved & (feet.gap <= 0.0) & (hold | ~at_border)
    kept = keep & ((safe[rows] > 0.0) | (-feet.gap <= BAND))

    mark, ways = np.empty(N, np.int8), np.empty(N, np.int32)
    asked = AskedFeet(np.empty(N, np.int32), np.empty(N, np.int8))
    limits = limits_of(hold=hold)
    n, m = settle_nb.look(rows, feet, side, safe, limits, mark, ways, asked)
    np.testing.assert_array_equal(mark & settle_nb.KEEP > 0, keep)
    np.testing.assert_array_equal(mark & settle_nb.KEPT > 0, kept)
    np.testing.assert_array_equal(ways[:n], np.flatnonzero(keep & ~kept & (side < 0)))
    index = np.flatnonzero(_sound(feet) & ~kept)
    np.testing.assert_array_equal(asked.which[:m], index)
    np.testing.assert_array_equal(asked.side[:m], feet.gap[index] > 0.0)

    clear = ways[:n:2]
    mark[clear] |= settle_nb.KEPT
    kept[clear] = True
    radius = 2.0 * rng.random(m)
    radius[::5] = np.abs(feet.gap[index[::5]]) + 0.5 * BAND  # not enough
    want_side, want_reach = side.copy(), reach.copy()
    doubtful = ~kept[index]
    nearest = _balls(feet, index[doubtful], radius[doubtful], want_side, want_reach)
    kept |= nearest & keep
    out = want_side > 0
    want_safe = safe.copy()
    held = np.fmax(safe[rows], np.where(want_side < 0, want_reach - BAND, 0.0))
    want_safe[rows[kept]] = held[kept]
    want_safe[rows[out]] = want_reach[out] - BAND

    status, near, uv = np.zeros(2 * N, np.int8), np.full(2 * N, -1, np.int32), np.zeros((2 * N, 2))
    taken = _feet(np.random.default_rng(0), 2 * N)
    taken.patch[:] = -1
    balls, known = FootBalls(asked.which[:m], radius), KnownSides(side, reach)
    result = _found(status, safe, near, uv)._replace(feet=taken)
    left = settle_nb.settle(rows, feet, known, mark, balls, limits, result, ways)
    np.testing.assert_array_equal(side, want_side)
    np.testing.assert_array_equal(reach, want_reach)
    np.testing.assert_array_equal(safe, want_safe)
    np.testing.assert_array_equal(ways[:left], np.flatnonzero(~kept & ~out))
    assert min(left, kept.sum(), out.sum()) > 5
    np.testing.assert_array_equal(np.flatnonzero(taken.patch >= 0), rows[kept])
    for a, b in zip(taken, feet, strict=True):
        np.testing.assert_array_equal(a[rows[kept]], b[kept])
    np.testing.assert_array_equal(near[rows[out]], feet.patch[out])
    np.testing.assert_array_equal(uv[rows[out]], feet.uv[out])
    becomes = np.where(at_border, ContactStatus.HELD, ContactStatus.OLD)
    becomes[feet.status == Status.BRANCH_EVENT] = ContactStatus.REACQUIRED
    np.testing.assert_array_equal(status[rows[kept & ~out]], becomes[kept & ~out])
    assert (status[rows[out]] == ContactStatus.RELEASED).all()


def test_feet_of_free_points_start_at_the_last_foot_or_near_by() -> None:
    rng = np.random.default_rng(3)
    rows = np.sort(rng.choice(2 * N, N, replace=False)).astype(np.int32)
    side = rng.integers(-1, 2, N).astype(np.int8)
    patch, uv = rng.integers(-1, 3, N).astype(np.int32), rng.random((N, 2))
    way, now = rng.random(2 * N), rng.normal(size=(2 * N, 3))
    old, old_uv = rng.integers(-1, 3, 2 * N).astype(np.int32), rng.random((2 * N, 2))
    near = np.full(2 * N, 8, np.int32)
    work = free_rows()
    step = _step(now, now)._replace(way=way, last_patch=old, uv=old_uv)
    n = settle_nb.starts(rows, side, SurfacePlaces(patch, uv), step, near, 0.5, work)
    last = (old[rows] >= 0) & ((way[rows] <= 0.5) | (patch < 0))
    index = np.flatnonzero((side == 0) & (last | (patch >= 0)))
    np.testing.assert_array_equal(work.which[:n], index)
    np.testing.assert_array_equal(work.patch[:n], np.where(last, old[rows], patch)[index])
    np.testing.assert_array_equal(work.uv[:n], np.where(last[:, None], old_uv[rows], uv)[index])
    np.testing.assert_array_equal(work.now[:n], now[rows[index]])
    np.testing.assert_array_equal(np.flatnonzero(near == -1), rows[side != 0])


def test_what_feet_tell_of_free_points() -> None:
    rng = np.random.default_rng(4)
    feet, index = _feet(rng, N), np.sort(rng.choice(2 * N, N, replace=False)).astype(np.int32)
    points = rng.normal(size=(N, 3))
    side, reach = rng.integers(-1, 2, 2 * N).astype(np.int8), rng.random(2 * N)
    within = np.full(2 * N, np.inf)
    asked = AskedFeet(np.empty(N, np.int32), np.empty(N, np.int8))
    m = settle_nb.askable(feet, len(feet.gap), BAND, asked)
    own = np.flatnonzero(_sound(feet))
    np.testing.assert_array_equal(asked.which[:m], own)
    np.testing.assert_array_equal(asked.side[:m], feet.gap[own] > 0.0)
    radius = 2.0 * rng.random(m)
    want = side[index], reach[index]
    _balls(feet, own, radius, *want)
    balls = FootBalls(own.astype(np.int32), radius)
    known = KnownSides(side, reach)
    settle_nb.tell(index, feet, points, balls, BAND, known, within)
    np.testing.assert_array_equal(side[index], want[0])
    np.testing.assert_array_equal(reach[index], want[1])
    good = np.isin(feet.status, (Status.OK, Status.BRANCH_EVENT))
    away = np.linalg.norm(points - feet.point, axis=1)
    np.testing.assert_allclose(within[index], np.where(good, away, np.inf), rtol=1e-15)
    assert np.isinf(np.delete(within, index)).all()

    safe, rest = np.zeros(2 * N), np.empty(2 * N, np.int32)
    held = (side < 0) & (rng.random(2 * N) < 0.5)
    rows = rng.permutation(2 * N).astype(np.int32)
    n = settle_nb.leave(rows, known, held, BAND, safe, rest)
    free = (side > 0) | held
    np.testing.assert_array_equal(rest[:n], np.flatnonzero(~free))
    np.testing.assert_array_equal(safe[rows[free]], (side * (reach - BAND))[free])
    assert not safe[rows[~free]].any()
