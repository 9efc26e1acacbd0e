"""Steps in which the body turns: what counts is the curve a point makes in its frame."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.scenes import box

import contiga as cg
from contiga.contact import contact as search_of_step
from contiga.contact import curved
from contiga.contact.curved import Path, StepHistory, bulge_of
from contiga.contact.foot_rows import blank
from contiga.contact.search_records import BULGE, Detection
from contiga.records import ContactStatus as Is
from contiga.rigid import pose
from contiga.rigid.frames import to_world
from contiga.rigid.screw import screw_between

UNIT = cg.PenaltyLaw(1.0)
FLAGGED = (Is.LOST, Is.FOUND, Is.REACQUIRED)
RADIUS, HALF = 0.49, 0.01
# Into which a turn is divided that is made in one step, too.
SMALL = 300 if FULL else 75
Pose = Callable[[float], np.ndarray]


@cache
def _master(name: str) -> cg.Body | cg.TriMesh:
    """Bodies about the z axis: teeth reach from 0.45 to 0.5."""
    tooth = box((0.45, -HALF, -0.3), (0.5, HALF, 0.3))
    if name == "tooth":
        return tooth
    if name == "blade":
        return box((-0.5, -HALF, -0.3), (0.5, HALF, 0.3))
    if name == "blade of triangles":
        return box((-0.5, -HALF, -0.3), (0.5, HALF, 0.3)).tessellate(0.1)
    if name == "sheet":
        return cg.Body(box((-0.5, -0.3, -HALF), (0.5, 0.3, HALF)).patches[:2])
    turns = [pose.rotation("z", 2.0 * np.pi * k / 8.0) for k in range(8)]
    return cg.Body([patch.transformed(X) for X in turns for patch in tooth.patches])


def _contact(name: str, n: int, **options: object) -> cg.Contact:
    slave = cg.Slave(np.zeros((n, 3)), area=np.ones(n))
    return cg.Contact(_master(name), slave, law=UNIT, **options)  # type: ignore[arg-type]


def _swept(name: str, angle: float, turn: float, **options: object) -> list[cg.State]:
    """A point at rest at `angle` about z, degrees, and a body that turns by `turn` in one step."""
    a = np.radians(angle)
    point = np.array([[RADIUS * np.cos(a), RADIUS * np.sin(a), 0.1]])
    contact = _contact(name, 1, **options)
    states = [contact.start(point)]
    states.append(contact.step(states[0], point, pose.rotation("z", np.radians(turn))))
    return states


def test_it_comes_in_by_the_side_that_leads() -> None:
    """Along its chord the point would come in by the inner side of the tooth."""
    state = _swept("tooth", 150.0, 150.5, foot="tracked")[-1]
    n = pose.rotation("z", np.radians(150.5))[:3, 1]
    assert state.status.tolist() == [Is.NEW]
    np.testing.assert_allclose(state.normal, [n], rtol=0, atol=1e-14)
    depth = HALF + RADIUS * np.sin(np.radians(0.5))
    np.testing.assert_allclose(state.penetration, [depth], rtol=0, atol=1e-14)


def test_it_is_held_though_its_chord_meets_nothing() -> None:
    held, released = (_swept("tooth", 40.0, 60.0, through=how) for how in ("hold", "release"))
    assert held[-1].status.tolist() == [Is.THROUGH]
    depth = HALF + RADIUS * np.sin(np.radians(20.0))
    np.testing.assert_allclose(held[-1].penetration, [depth], rtol=0, atol=1e-14)
    assert released[-1].status.tolist() == [Is.FREE]


def test_its_curve_passes_what_its_chord_meets() -> None:
    """A point beyond the reach of a blade, whose chord the blade would cut."""
    a = np.radians(45.0)
    point = 0.51 * np.array([[np.cos(a), np.sin(a), 0.0]])
    contact = _contact("blade", 1, through="hold")
    state = contact.step(contact.start(point), point, pose.rotation("z", 2.0 * a))
    assert state.status.tolist() == [Is.FREE]


def _both_move(degrees: float, moved: float, n: int = 250) -> tuple[np.ndarray, np.ndarray, Pose]:
    """Points at the start and the end of a step, and a pose that goes evenly on a screw."""
    rng = np.random.default_rng(int(degrees))
    points = rng.uniform([-0.55, -0.55, -0.3], [0.55, 0.55, 0.3], (n, 3))
    turned = pose.rotation([0.2, 0.1, 1.0], np.radians(degrees))
    X = pose.compose(pose.translation([0.1, 0.0, -0.05]), turned)
    screw = screw_between(np.eye(4), X)
    return points, points + rng.normal(0.0, moved, points.shape), lambda s: (
        screw.pose(s) if s < 1.0 else X
    )  # fmt: skip


@pytest.mark.parametrize("degrees", [10.0, 30.0, 60.0, 90.0] if FULL else [10.0, 90.0])
@pytest.mark.parametrize("how", ["release", "hold"])
@pytest.mark.parametrize("name", ["sheet", *full("blade", "teeth")])
def test_one_big_turn_is_many_small_ones(name: str, how: str, degrees: float) -> None:
    points, end, pose_at = _both_move(degrees, 0.05)
    contact = _contact(name, len(points), through=how)
    start = small = contact.start(points, pose_at(0.0))
    big = contact.step(start, end, pose_at(1.0))
    flagged = np.zeros(len(points), dtype=bool)
    for s in np.linspace(0.0, 1.0, SMALL + 1)[1:]:
        now = end if s == 1.0 else points + s * (end - points)
        small = contact.step(small, now, pose_at(s))
        flagged |= np.isin(small.status, FLAGGED)
    clear = ~flagged
    assert clear.mean() > 0.95
    np.testing.assert_array_equal(big.in_contact[clear], small.in_contact[clear])
    for one, other in ((big.penetration, small.penetration), (big.normal, small.normal)):
        np.testing.assert_allclose(one[clear], other[clear], rtol=0, atol=1e-9)
    through = clear & (small.status == Is.THROUGH)
    np.testing.assert_array_equal(big.status[through], Is.THROUGH)


def test_the_turns_of_these_tests_touch() -> None:
    counts = {}
    for name in ("blade", "teeth"):
        points, end, pose_at = _both_move(60.0, 0.05)
        contact = _contact(name, len(points), through="hold")
        counts[name] = contact.step(contact.start(points), end, pose_at(1.0)).n_contact
    assert min(counts.values()) > 5


def test_a_mesh_is_swept_too() -> None:
    states = _swept("blade of triangles", 50.0, 50.5, foot="tracked")
    depth = HALF + RADIUS * np.sin(np.radians(0.5))
    assert states[-1].max_penetration == pytest.approx(depth, abs=1e-14)


def test_a_far_axis_loses_no_digits() -> None:
    """A thousand sizes off: the blade goes three sizes sideways along an arc."""
    centre, angle = [1000.0, 0.0, 0.0], 3e-3
    rng = np.random.default_rng(4)
    points = rng.uniform([-0.45, -3.0, -0.2], [0.45, -0.1, 0.2], (200, 3))
    contact = _contact("blade", 200, through="hold")
    start = small = contact.start(points)
    big = contact.step(start, points, pose.rotation("z", angle, centre))
    for s in np.linspace(0.0, 1.0, 101)[1:]:
        small = contact.step(small, points, pose.rotation("z", s * angle, centre))
    assert big.n_contact == 200
    np.testing.assert_array_equal(big.in_contact, small.in_contact)
    np.testing.assert_allclose(big.penetration, small.penetration, rtol=0, atol=1e-11)


def test_a_point_does_not_hang_on_others() -> None:
    points, end, pose_at = _both_move(60.0, 0.05)
    whole = _contact("teeth", len(points), through="hold")
    state = whole.step(whole.start(points), end, pose_at(1.0))
    rows = np.arange(0, len(points), 7)
    part = _contact("teeth", len(rows), through="hold")
    own = part.step(part.start(points[rows]), end[rows], pose_at(1.0))
    for name in ("status", "patch", "uv", "penetration", "normal", "foot", "safe_distance"):
        np.testing.assert_array_equal(getattr(own, name), getattr(state, name)[rows])


def test_what_the_body_carries_along_goes_as_if_neither_turned() -> None:
    """A far turn of the whole scene, in which points slip a little into the blade."""
    points = np.random.default_rng(6).uniform([-0.4, 0.011, -0.2], [0.4, 0.04, 0.2], (100, 3))
    slipped = points - [0.003, 0.015, 0.001]
    contact = _contact("blade", 100)
    start = contact.start(points)
    still = contact.step(start, slipped)
    X = pose.compose(pose.translation([1.0, -2.0, 0.5]), pose.rotation([1.0, 2.0, 0.5], 1.5))
    carried = contact.step(start, pose.apply(X, slipped), X)
    assert 20 < still.n_contact < 100
    np.testing.assert_array_equal(carried.status, still.status)
    np.testing.assert_allclose(carried.penetration, still.penetration, rtol=0, atol=1e-14)


class _Counted:
    """Counts the searches of a step and their points."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.points: list[int] = []
        inner = curved.detect

        def counted(surface: object, now: np.ndarray, *others: object) -> Detection:
            self.points.append(len(now))
            return inner(surface, now, *others)  # type: ignore[arg-type]

        monkeypatch.setattr(curved, "detect", counted)
        monkeypatch.setattr(search_of_step, "detect", counted)


def test_what_cannot_touch_costs_no_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(300, 3))
    points *= 40.0 / np.linalg.norm(points, axis=1)[:, None]
    points[:2] = [[0.3, 0.05, 0.0], [np.nan, 0.0, 0.0]]
    contact = _contact("blade", 300)
    state = contact.start(points)
    counted = _Counted(monkeypatch)
    state = contact.step(state, points, pose.rotation("z", np.radians(20.0)))
    assert counted.points[0] == 300
    assert set(counted.points[1:]) == {1}
    assert len(counted.points) in (9, 17, 33, 65)
    assert state.status[1] == Is.NOT_FINITE


def test_a_step_without_turning_is_one_search(monkeypatch: pytest.MonkeyPatch) -> None:
    points, end, _ = _both_move(30.0, 0.05)
    contact = _contact("blade", len(points))
    turned = pose.rotation("z", 0.7)
    states = [contact.start(points, turned)]
    counted = _Counted(monkeypatch)
    monkeypatch.setattr(curved, "screw_between", None)
    moved = pose.compose(pose.translation([0.1, 0.2, 0.3]), turned)
    state = contact.step(states[0], end, moved)
    assert counted.points == [len(points)]
    np.testing.assert_array_equal(state.pose, moved)


def test_the_bulge_is_a_bound_and_near_the_truth() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        X = pose.compose(pose.translation(rng.normal(size=3)),
                         pose.rotation(rng.normal(size=3), rng.uniform(0.0, 1.0)))  # fmt: skip
        screw = screw_between(np.eye(4), X)
        start, now = rng.normal(size=(2, 40, 3))
        path = Path(screw, start, to_world(X, now), now)
        bulge = bulge_of(screw, path.start, path.end)
        off = np.zeros(40)
        for s in np.linspace(0.0, 1.0, 41):
            chord = start + s * (now - start)
            off = np.maximum(off, np.linalg.norm(path.at(s) - chord, axis=1))
        assert (off <= bulge * (1.0 + 1e-9)).all()
        assert (off >= 0.1 * bulge).any()


@pytest.mark.parametrize("degrees", [0.2, 3.0, 45.0, *full(170.0)])
def test_pieces_are_as_straight_as_is_asked(
    monkeypatch: pytest.MonkeyPatch, degrees: float
) -> None:
    points, end, pose_at = _both_move(degrees, 0.2, 250 if FULL else 80)
    contact = _contact("blade", len(points))
    state = contact.start(points)
    seen: list[float] = []
    inner = curved._follow_pieces

    def followed(*given: object) -> Detection:
        path, pieces = given[1], given[4]
        assert isinstance(path, Path)
        assert isinstance(pieces, int)
        for k in range(pieces):
            a, m, b = (path.at((k + h) / pieces) for h in (0.0, 0.5, 1.0))
            seen.append(float(np.linalg.norm(m - 0.5 * (a + b), axis=1).max()))
        return inner(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(curved, "_follow_pieces", followed)
    contact.step(state, end, pose_at(1.0))
    assert 0.0 < max(seen) <= BULGE * contact.master.size


def test_points_far_from_the_surface_are_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """However little is left of the distances that were known of them, as they turned round."""
    points = cg.clouds.sample(cg.shapes.plane(width=3.0, length=3.0), 31, 31)
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    slave = cg.Slave(points, area=np.full(len(points), 0.01))
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(4e3), search="penetration")
    low = pose.translation([0.0, 0.0, 0.972])
    state, seen = contact.start(points, low), [0]
    inner = curved._follow_pieces

    def followed(*given: object) -> Detection:
        path = given[1]
        assert isinstance(path, Path)
        seen[-1] += len(path.now)
        return inner(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(curved, "_follow_pieces", followed)
    for k in range(12):
        turned = pose.rotation([1.0, 0.0, 0.0], 0.05 * (k + 1))
        state = contact.step(state, points, pose.compose(low, turned), dt=1e-3)
        seen.append(0)
    assert state.n_contact > 15
    assert max(seen) < 0.2 * len(points)


def _found(status: Is, certified: int = 1) -> Detection:
    feet = blank(1)
    feet.patch[:] = 0 if status in cg.records.IN_CONTACT else -1
    feet.certified[:] = certified
    none = np.zeros(1)
    held = np.flatnonzero(feet.patch >= 0).astype(np.int32)
    return Detection(np.array([status], np.int8), feet, none, np.full(1, -1, np.int32), none, held)


STORIES = [
    (True, [Is.OLD, Is.OLD], Is.OLD),
    (True, [Is.OLD, Is.HELD], Is.HELD),
    (True, [Is.NEW, Is.OLD], Is.NEW),
    (True, [Is.RELEASED, Is.FREE], Is.RELEASED),
    (True, [Is.OLD, Is.SLID_OFF, Is.FREE], Is.SLID_OFF),
    (True, [Is.RELEASED, Is.NEW, Is.OLD], Is.NEW),
    (True, [Is.REACQUIRED, Is.OLD], Is.REACQUIRED),
    (True, [Is.REACQUIRED, Is.RELEASED, Is.NEW], Is.NEW),
    (True, [Is.THROUGH, Is.OLD], Is.OLD),
    (True, [Is.OLD, Is.LOST, Is.FREE], Is.LOST),
    (False, [Is.NEW, Is.OLD], Is.NEW),
    (False, [Is.FREE, Is.NEW, Is.THROUGH], Is.THROUGH),
    (False, [Is.NEW, Is.REACQUIRED, Is.OLD], Is.REACQUIRED),
    (False, [Is.FOUND, Is.OLD], Is.FOUND),
    (False, [Is.NEW, Is.RELEASED], Is.FREE),
    (False, [Is.NEW, Is.RELEASED, Is.FREE], Is.FREE),
    (False, [Is.LOST, Is.FREE], Is.LOST),
    (False, [Is.LOST, Is.NEW], Is.NEW),
]


@pytest.mark.parametrize(("began", "pieces", "whole"), STORIES)
def test_what_became_of_a_point_in_a_step(began: bool, pieces: list[Is], whole: Is) -> None:
    story = StepHistory.begin(np.array([began]))
    for status in pieces:
        story = story.after(_found(status))
    assert Is(int(story.status(np.array([pieces[-1]], np.int8))[0])) is whole


def test_a_foot_is_proved_if_it_is_in_all_pieces_since_it_was_taken() -> None:
    story = StepHistory.begin(np.array([True]))
    proved = []
    for status, certified in [(Is.OLD, 1), (Is.OLD, 0), (Is.OLD, 1), (Is.REACQUIRED, 1),
                              (Is.OLD, 1), (Is.RELEASED, 0)]:  # fmt: skip
        story = story.after(_found(status, certified))
        proved.append(int(story.certified[0]))
    assert proved == [1, 0, 0, 1, 1, 0]
