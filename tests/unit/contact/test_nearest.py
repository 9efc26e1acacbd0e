"""Points that one kernel decides by their closest points, compared with the rule of `decide`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.sample import FULL, few

from contiga.contact import followed, nearest
from contiga.contact.foot_rows import blank
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import NO_POINTS, NO_SIZES, UNGUARDED, guard_states_of
from contiga.contact.search_records import Detection, Limits, Options, Step, StepSearch
from contiga.contact.settle_records import Candidates
from contiga.records import ContactStatus, Hit, Projection, SurfacePlaces, empty_hit, rows_of
from contiga.statuses import Status

pytestmark = pytest.mark.interpreted

UNHELD = guard_states_of(NO_SIZES, NO_POINTS, UNGUARDED)

N = few(1500 if FULL else 500, 150)
BAND = 0.01
LOOKED_FOR = (
    ContactStatus.NEW,
    ContactStatus.REACQUIRED,
    ContactStatus.FOUND,
    ContactStatus.LOST,
)


class Told:
    """A surface that counts what it is asked: nothing crosses it, and no point of it is closer."""

    contact_tables = None

    def __init__(self) -> None:
        self.asked = 0

    def last_crossings(self, _: Any, __: Any, rows: np.ndarray) -> tuple[Hit, np.ndarray]:
        self.asked += 1
        return empty_hit(len(rows)), np.zeros(len(rows), np.int8)

    def closest(self, _: Any, __: Any, out: Projection, ___: Any = None) -> None:
        self.asked += 1
        out.status[:] = Status.MAX_ITERATIONS

    def closest_facing(self, *given: Any) -> None:
        self.asked += 1
        given[-1].status[:] = Status.MAX_ITERATIONS

    def track(self, *_: Any) -> None:
        """Of no points, as none crosses it."""


def feet_of(rng: np.random.Generator, n: int, status: list[int]) -> Projection:
    gap = rng.normal(size=n)
    gap[::5] = 0.5 * BAND * np.sign(gap[::5])
    gap[1::11] = 0.0
    return Projection(
        rng.integers(0, 5, n).astype(np.int32),
        *(rng.random((n, 2)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), gap),
        *(rng.integers(0, 3, n).astype(np.int8), rng.choice(status, n).astype(np.int8)),
        rng.integers(0, 2, n).astype(np.int8),
    )


def scene(seed: int, is_nearest: bool) -> tuple[Candidates, Step]:
    """Points to be decided on, and their paths."""
    rng = np.random.default_rng(seed)
    truth = feet_of(rng, N, [Status.OK, Status.OK, Status.MAX_ITERATIONS])
    feet = feet_of(rng, N, [Status.OK, Status.BORDER])
    if is_nearest:
        feet.certified[:] = 0  # they are followed, and no closest points
    same = rng.random(N) < 0.7
    feet.point[same] = truth.point[same]
    side = rng.integers(-1, 2, N).astype(np.int8)
    was = rng.random(N) < 0.5
    # As `decide` has it, who asks for the closest points that it needs.
    spared = (side != 0) & was & (rng.random(N) < 0.5)
    spared &= (side > 0) | (not is_nearest)
    truth.status[spared], truth.patch[spared] = settle_nb.NOT_SEARCHED, -1
    rows = np.sort(rng.choice(2 * N, N, replace=False)).astype(np.int32)
    becomes = rng.choice([ContactStatus.OLD, ContactStatus.HELD], N).astype(np.int8)
    kept = was & (rng.random(N) < 0.6)
    guard = rng.normal(size=(N, 3)) * (rng.random((N, 1)) < 0.7)
    known = side, rng.random(N), rng.random(N), guard, rng.normal(size=N) + 0.5
    asked = Candidates(rows, was, kept, becomes, *known, rng.random(N) < 0.1, feet, truth)
    way, ignored = rng.random(2 * N), rng.random(2 * N) < 0.3
    way[::7] = np.inf
    points, near = rng.normal(size=(2 * N, 3)), np.zeros(2 * N, np.int32)
    old = near, rng.random((2 * N, 2)), UNHELD
    gone = np.where(np.isfinite(way), way, 0.0)[:, None] * [1.0, 0.0, 0.0]
    return asked, Step(points - gone, points, way, ignored, *old)


def rows_of_asked(asked: Candidates, which: np.ndarray) -> Candidates:
    columns: Any = [column[which] for column in asked[:-2]]
    return Candidates(*columns, rows_of(asked.feet, which), rows_of(asked.closest, which))


def found_by(asked: Candidates, step: Step, options: Options) -> tuple[Detection, int]:
    """What `decide` makes of them, and how often it asked the surface."""
    n, surface = len(step.path_length), Told()
    none = np.zeros((0,), np.int32)
    found = Detection(
        *(np.full(n, -9, np.int8), blank(n), np.full(n, -7.0), np.full(n, -5, np.int32)),
        *(np.full((n, 2), -3.0), none),
    )
    last = SurfacePlaces(np.zeros(n, np.int32), np.zeros((n, 2)))
    search = StepSearch(surface, step, last, found, options)  # type: ignore[arg-type]
    (nearest if options.nearest else followed).decide(search, asked)
    return found, surface.asked


def options_of(penetration: bool, is_nearest: bool, depth: float) -> Options:
    return Options(penetration, False, False, is_nearest, depth, True, 2.0, BAND)


@pytest.mark.parametrize("is_nearest", [False, True])
@pytest.mark.parametrize(("penetration", "depth"), [(False, np.inf), (True, np.inf), (True, 0.5)])
def test_plain_points_are_judged_as_all_are(
    monkeypatch: pytest.MonkeyPatch, penetration: bool, depth: float, is_nearest: bool
) -> None:
    asked, step = scene(3, is_nearest)
    options = options_of(penetration, is_nearest, depth)
    plain = np.zeros(N, bool)
    kernel = settle_nb.decide_all

    def seen(*given: Any) -> bool:
        own = kernel(*given)
        if len(given[0].rows) == 1:
            plain[np.searchsorted(asked.rows, given[0].rows[0])] = own
        return bool(own)

    monkeypatch.setattr(settle_nb, "decide_all", seen)
    for i in range(N):
        found, questions = found_by(rows_of_asked(asked, np.array([i])), step, options)
        if not plain[i]:
            # Where the nearest wall pushes, its foot is known already.
            assert is_nearest or questions > 0 or found.status[asked.rows[i]] in LOOKED_FOR
        else:
            assert questions == 0
    assert 0.2 * N < plain.sum() < 0.9 * N
    now, _ = found_by(rows_of_asked(asked, np.flatnonzero(plain)), step, options)
    monkeypatch.setattr(settle_nb, "decide_all", lambda *_: False)
    own = rows_of_asked(asked, np.flatnonzero(plain))
    wanted, questions = found_by(own, step, options)
    assert questions == 0
    for name in ("status", "safe_distance", "last_patch", "uv"):
        a, b = getattr(now, name), getattr(wanted, name)
        assert a.tobytes() == b.tobytes(), name
    for a, b in zip(now.feet, wanted.feet, strict=True):
        assert a.tobytes() == b.tobytes()


def test_where_one_is_not_plain_nothing_is_written() -> None:
    asked, step = scene(4, False)
    n = len(step.path_length)
    into = np.zeros(n, np.int8), np.zeros(n), np.zeros(n, np.int32), np.zeros((n, 2))
    status, safe_distance, near, uv = into
    found = Detection(status, blank(n), safe_distance, near, uv, near[:0])
    limits = Limits(True, False, False, False, BAND, 0.0, np.inf, 1e-9)
    assert not settle_nb.decide_all(asked, step, limits, found)
    assert not any(array.any() for array in into)
    assert (found.feet.patch == -1).all()
