"""Masters of a user's own, from their closest points alone, beside exact bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.digest import Digest
from contiga.errors import GeometryError, InputError
from contiga.masters.protocol import Surface, is_master
from contiga.records import (
    ContactStatus,
    FacingLimits,
    FloatArray,
    SurfacePlaces,
    empty_projection,
)
from contiga.statuses import Status

RNG = np.random.default_rng(0)
CLOUD = RNG.uniform([-1.3, -1.3, 1.02], [1.3, 1.3, 1.3], (300, 3))
EXACT = cg.Body([cg.shapes.sphere(radius=1.0)])


class Ball(cg.Master):
    """A ball about the origin. Its centre has no closest point."""

    def __init__(self, radius: float = 1.0) -> None:
        self.radius = radius

    def bounds(self) -> FloatArray:
        return self.radius * np.array([[-1.0] * 3, [1.0] * 3])

    @property
    def surface(self) -> Surface:
        return cg.closest_point_search(self.closest_points)

    def closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        away = np.linalg.norm(points, axis=1)[:, None]
        normals = np.divide(points, away, out=np.full(points.shape, np.nan), where=away > 0.0)
        return self.radius * normals, normals


class Ground(cg.Master):
    """All below z = 0."""

    def bounds(self) -> FloatArray:
        return np.array([[-10.0, -10.0, -1.0], [10.0, 10.0, 0.0]])

    @property
    def surface(self) -> Surface:
        return cg.closest_point_search(
            lambda p: (p * [1.0, 1.0, 0.0], np.tile([0.0, 0.0, 1.0], (len(p), 1)))
        )


def pressed(master: cg.Master, **options: object) -> list[cg.State]:
    """States of a cloud that a turning ball passes under."""
    slave = cg.Slave(CLOUD, area=np.ones(len(CLOUD)))
    contact = cg.Contact(master, slave, law=cg.PenaltyLaw(10.0), **options)  # type: ignore[arg-type]
    states = [contact.start(CLOUD)]
    for k in range(1, 15):
        turn = cg.motion.pose.rotation("y", 0.1 * k)
        points = CLOUD - [0.02 * k, 0.0, 0.16 * k]
        states.append(contact.step(states[-1], points, turn, dt=1.0))
    return states


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"search": "penetration"},
        {"foot": "tracked"},
        {"through": "hold"},
        {"weights": "area", "friction": cg.Coulomb(0.3)},
    ],
)
def test_a_ball_of_ones_own_pushes_as_the_exact_one(options: dict[str, object]) -> None:
    own, exact = pressed(Ball(), **options), pressed(EXACT, **options)
    assert max(state.n_contact for state in exact) > 100
    for state, expected in zip(own, exact, strict=True):
        np.testing.assert_array_equal(state.status, expected.status)
        np.testing.assert_allclose(state.force, expected.force, rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.wrench, expected.wrench, rtol=0, atol=1e-8)
        assert state.n_unproved == 0


def falling(master: cg.Master) -> cg.Simulation:
    """A free ball under a plate, and dust that falls onto it."""
    square = [[x, y, 1.05] for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    plate = cg.Slave(square, [[0, 2, 1], [1, 2, 3]])
    dust = cg.Slave([[0.0, 0.3, 1.1], [0.3, 0.0, 1.2]], area=[0.1, 0.1], mass=[0.1, 0.1])
    law = cg.PenaltyLaw(10.0)
    free = cg.motion.Free(mass=4.0, inertia=np.eye(3), velocity=[0.0, 0.0, 0.1])
    return cg.Simulation(
        bodies={"ball": (master, free)},
        slaves={"plate": plate, "dust": (dust, cg.motion.Free(velocity=[0.0, 0.0, -0.3]))},
        contacts=[cg.Contact(master, plate, law=law), cg.Contact(master, dust, law=law)],
        end=2.0,
        step=0.05,
    )


def test_it_runs_in_a_simulation_and_writes_all_files(tmp_path: Path) -> None:
    own, exact = falling(Ball()), falling(EXACT)
    result, expected = own.run(out=tmp_path), exact.run()
    assert float(expected.history["ball-dust.n_contact"].max()) == 2.0
    for name, column in expected.history.items():
        if not name.endswith("wall_time"):
            np.testing.assert_allclose(result.history[name], column, rtol=0, atol=1e-10)
    facts = cg.open_result(tmp_path).summary["inputs"]["ball"]
    assert facts == {"kind": "Ball", "closed": True, "size": pytest.approx(np.sqrt(12.0))}
    assert (tmp_path / "fields.vtkhdf").exists()
    assert cg.preview(own).gaps == pytest.approx(cg.preview(exact).gaps)


def test_its_attributes_tell_simulations_apart() -> None:
    assert falling(Ball()).fingerprint() == falling(Ball()).fingerprint()
    assert falling(Ball()).fingerprint() != falling(Ball(1.01)).fingerprint()
    digests = [Digest(), Digest(), Digest()]
    for radius, digest in zip((1.0, 1.0, 1.01), digests, strict=True):
        Ball(radius).digest(digest)
    first, same, other = (digest.hexdigest() for digest in digests)
    assert first == same != other


def test_crossings_are_those_of_the_exact_ball() -> None:
    ball, n = Ball(), 400
    starts, ends = RNG.normal(size=(2, n, 3)) * 1.5
    rows = np.arange(n, dtype=np.int32)
    hit, expected = ball.first_hit(starts, ends), EXACT.first_hit(starts, ends)
    assert 50 < int((expected.patch >= 0).sum()) < n
    np.testing.assert_allclose(hit.fraction, expected.fraction, rtol=0, atol=1e-11)
    crossing, sense = ball.surface.last_crossings(starts, ends, rows)
    theirs, their_sense = EXACT.surface.last_crossings(starts, ends, rows)
    np.testing.assert_array_equal(sense, their_sense)
    crossed = sense != 0
    np.testing.assert_allclose(crossing.point[crossed], theirs.point[crossed], rtol=0, atol=1e-11)


def ring(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A ring of radius 2 about z, 0.5 thick. Points of its axis have no closest one."""
    flat, away = points * [1.0, 1.0, 0.0], np.hypot(points[:, 0], points[:, 1])[:, None]
    lost = np.full(points.shape, np.nan)
    middle = np.divide(2.0 * flat, away, out=lost, where=away > 0.0)
    off = points - middle
    with np.errstate(invalid="ignore"):
        normals = off / np.linalg.norm(off, axis=1)[:, None]
    return middle + 0.5 * normals, normals


def test_paths_go_over_places_without_a_closest_point() -> None:
    """The second step of the way lands on the axis of the ring."""
    search, one = cg.closest_point_search(ring), np.zeros(1, np.int32)
    start, end = np.array([[-0.75, 0.0, 0.0]]), np.array([[2.25, 0.0, 0.0]])
    assert search.entries(start, end, one).fraction[0] == pytest.approx(0.75, abs=1e-15)
    crossing, sense = search.last_crossings(start, end, one)
    assert (crossing.fraction[0], sense[0]) == (pytest.approx(0.75, abs=1e-15), 1)


def test_paths_begin_inside_where_there_is_no_closest_point() -> None:
    ball, one = Ball(), np.zeros(1, np.int32)
    centre, end = np.zeros((1, 3)), np.array([[0.0, 0.0, 2.0]])
    assert np.isnan(ball.first_hit(centre, end).fraction[0])
    crossing, sense = ball.surface.last_crossings(centre, end, one)
    assert (crossing.fraction[0], sense[0]) == (pytest.approx(0.5, abs=1e-15), -1)


def test_walls_that_face_away_or_are_too_near_do_not_hold() -> None:
    points = np.tile([0.0, 0.0, 0.9], (3, 1))
    guards = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    limits = FacingLimits(-0.5, np.array([0.05, 0.05, 0.15]), np.full(3, np.inf))
    starts, feet = SurfacePlaces(np.full(3, -1, np.int32), np.zeros((3, 2))), empty_projection(3)
    Ball().surface.closest_facing(points, guards, limits, starts, feet)
    assert feet.status.tolist() == [Status.OK, Status.MAX_ITERATIONS, Status.MAX_ITERATIONS]
    np.testing.assert_array_equal(feet.point[0], [0.0, 0.0, 1.0])


def test_points_sink_into_a_ground_of_ones_own() -> None:
    points = RNG.uniform([-5.0, -5.0, 0.1], [5.0, 5.0, 0.5], (50, 3))
    contact = cg.Contact(Ground(), cg.Slave(points, area=np.ones(50)), law=cg.PenaltyLaw(2.0))
    deep = points - [0.0, 0.0, 0.3]
    state = contact.step(contact.start(points), deep)
    np.testing.assert_allclose(state.penetration, np.maximum(-deep[:, 2], 0.0), atol=1e-15)
    np.testing.assert_allclose(state.force[:, 2], 2.0 * state.penetration, atol=1e-15)


def test_questions_that_need_its_search_alone_are_answered() -> None:
    ball = Ball(2.0)
    assert is_master(ball)
    assert (ball.name, ball.closed, ball.faces, ball.flaws) == ("Ball", True, None, [])
    feet = ball.project([[0.0, 0.0, 3.0], [0.0, 1.5, 0.0]])
    np.testing.assert_allclose(feet.gap, [1.0, -0.5])
    np.testing.assert_array_equal(
        ball.project([[0.0, 0.0, 3.0]], start=feet, mode="track").point, [[0.0, 0.0, 2.0]]
    )
    assert ball.contains([[0.0, 0.0, 3.0], [0.0, 1.5, 0.0]]).tolist() == [False, True]
    pad = cg.Slave([[0.0, 0.0, 9.0], [0.5, 0.0, 9.0]])
    placed = cg.place(pad, on=ball, direction=[0.0, 0.0, -1.0], gap=0.25)
    assert placed.points[0, 2] == pytest.approx(2.25)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (
            lambda ball: ball.transformed(np.eye(4)),
            "no transformed of its own.*Give the body a motion",
        ),
        (lambda ball: ball.mass_properties(1.0), "no mass_properties of its own.*as numbers"),
        (lambda ball: ball.with_reference_point([0, 0, 1]), "no with_reference_point of its own"),
    ],
)
def test_what_it_lacks_is_said_with_a_remedy(asked, message: str) -> None:
    with pytest.raises(InputError, match=message):
        asked(Ball())


def test_a_point_without_a_closest_one_is_left_out() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9]])
    slave = cg.Slave(points, area=[1.0, 1.0])
    contact = cg.Contact(Ball(), slave, law=cg.PenaltyLaw(1.0), search="penetration")
    state = contact.start(points)
    assert state.in_contact.tolist() == [False, True]
    later = contact.step(state, points + np.array([0.0, 0.0, 0.05]))
    assert later.status.tolist() == [ContactStatus.NEW, ContactStatus.OLD]


def test_a_class_without_a_search_is_no_master() -> None:
    class Half(cg.Master):
        def bounds(self) -> FloatArray:
            return np.zeros((2, 3))

    with pytest.raises(TypeError, match="surface"):
        Half()  # type: ignore[abstract]


def test_wrong_answers_are_refused() -> None:
    class Wrong(Ball):
        def closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
            return points, points[:, 0]

    class Unbounded(Ball):
        def bounds(self) -> FloatArray:
            return np.array([[-np.inf] * 3, [np.inf] * 3])

    slave, law = cg.Slave([[0.0, 0.0, 1.1]], area=[1.0]), cg.PenaltyLaw(1.0)
    with pytest.raises(GeometryError, match=r"closest_points.*shapes \(1, 3\) and \(1,\)"):
        cg.Contact(Wrong(), slave, law=law).start(slave.points)
    with pytest.raises(GeometryError, match=r"Unbounded, bounds.*corner of a box"):
        cg.Contact(Unbounded(), slave, law=law)
    with pytest.raises(InputError, match=r"derived from contiga\.Master"):
        cg.Contact(object(), slave, law=law)  # type: ignore[arg-type]
