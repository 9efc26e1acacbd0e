"""Friction against closed forms: stick and slip, where the work goes, how tractions are carried."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.laws.friction import (
    MIN_POINTS,
    Coulomb,
    Friction,
    FrictionInput,
    FrictionOutput,
    ViscousFriction,
)

UP = np.array([0.0, 0.0, 1.0])


def seen(normal, before, force, path, memory, *, stiffness=0.0, area=1.0, velocity=0.0):
    """A `FrictionInput` with single values spread over all points."""
    path = np.atleast_2d(np.asarray(path, dtype=float))
    n = len(path)

    def spread(value, shape):
        return np.broadcast_to(np.asarray(value, dtype=float), shape).copy()

    return FrictionInput(
        spread(normal, (n, 3)),
        spread(before, (n, 3)),
        spread(force, n),
        spread(stiffness, n),
        spread(area, n),
        path,
        spread(velocity, (n, 3)),
        0.1,
        memory,
    )


@pytest.mark.parametrize(
    "law",
    [
        Coulomb(0.4, stiffness=1e3),
        Coulomb(0.4, 0.3, decay=2.0, stiffness=1e3),
        ViscousFriction(0.3, 0.01),
    ],
)
def test_the_largest_coefficient_is_reached_and_never_exceeded(law: Friction) -> None:
    speeds = np.array([0.0, 0.1, 1.0, 10.0])
    velocity = speeds[:, None] * [1.0, 0.0, 0.0]
    path = np.tile([1.0, 0.0, 0.0], (4, 1))
    answer = law.respond(seen(UP, UP, 5.0, path, np.zeros((4, law.n_memory)), velocity=velocity))
    ratios = np.linalg.norm(answer.force, axis=1) / 5.0
    assert ratios.max() == pytest.approx(law.largest_coefficient, rel=1e-12)


def drag(law: Friction, ways, force, **given) -> list[FrictionOutput]:
    """One block on a plane moved to each of `ways` along x under the normal `force`."""
    memory, at, answers = np.zeros((1, law.n_memory)), 0.0, []
    forces = np.broadcast_to(np.asarray(force, dtype=float), len(ways))
    for way, pressed in zip(ways, forces, strict=True):
        before = UP if answers else np.zeros(3)
        answers.append(
            law.respond(seen(UP, before, pressed, [way - at, 0.0, 0.0], memory, **given))
        )
        memory, at = answers[-1].memory, way
    return answers


def test_a_block_on_a_spring_sticks_slips_and_turns_as_the_closed_form_says() -> None:
    """k = 100, μF = 4: slips from 0.04 on; turned at 0.1 it sticks until 0.02, then slips back."""
    steps = drag(Coulomb(0.4, stiffness=100.0), [0.03, 0.04, 0.1, 0.06, 0.02, -0.05], 10.0)
    assert [s.force[0, 0] for s in steps] == pytest.approx([-3.0, -4.0, -4.0, 0.0, 4.0, 4.0])
    stored = [0.045, 0.08, 0.08, 0.0, 0.08, 0.08]
    assert [s.stored[0] for s in steps] == pytest.approx(stored, abs=1e-15)
    lost = [0.0, 0.0, 4.0 * 0.06, 0.0, 0.0, 4.0 * 0.07]
    assert [s.lost[0] for s in steps] == pytest.approx(lost, abs=1e-15)
    assert [s.memory[0, 3] for s in steps] == pytest.approx([0.03, 0.04, 0.1, 0.06, 0.02, -0.05])
    assert all(s.stiffness[0] == 100.0 for s in steps)


def test_a_cycle_of_dragging_loses_the_area_of_its_loop() -> None:
    """4 μF (X − μF/k) of each full cycle of amplitude X, in steps that end where it slips."""
    cycle = [0.02, -0.1, -0.02, 0.1]
    steps = drag(Coulomb(0.4, stiffness=100.0), [0.04, 0.1, *cycle, *cycle], 10.0)
    lost = [s.lost[0] for s in steps[2:]]
    assert sum(lost) == pytest.approx(2 * 4.0 * 4.0 * (0.1 - 0.04), rel=1e-13)


def test_a_block_stops_after_the_distance_its_speed_is_good_for() -> None:
    mass, g, mu, speed, dt = 2.0, 9.81, 0.3, 1.0, 1e-4
    law, x, v = Coulomb(mu, stiffness=1e5), 0.0, speed
    memory, before = np.zeros((1, 7)), np.zeros(3)
    for _ in range(5000):
        answer = law.respond(seen(UP, before, mass * g, [v * dt, 0.0, 0.0], memory))
        memory, before = answer.memory, UP
        x += v * dt
        v += answer.force[0, 0] / mass * dt
    assert x == pytest.approx(speed**2 / (2 * mu * g), rel=2e-3)


def stuck_under_swinging_load(law: Coulomb, swings) -> np.ndarray:
    """Displacements (cycles, 4) of blocks that pulls below the cone hold in balance.

    `swings` are normal force and stiffness of each step of a cycle.
    """
    pulls = np.array([0.5, 1.0, 1.5, 1.9])
    memory, x, ends = np.zeros((4, 7)), np.zeros(4), []
    before = np.zeros(3)
    for _ in range(1000):
        for force, stiffness in swings:
            # The spring is straight while it sticks: one step from the old traction to balance.
            k = np.maximum(memory[:, 6], law.stiffness or stiffness)
            way = (pulls + memory[:, 0]) / k
            path = np.column_stack([way, 0.0 * way, 0.0 * way])
            answer = law.respond(seen(UP, before, force, path, memory, stiffness=stiffness))
            np.testing.assert_allclose(answer.force[:, 0], -pulls, rtol=1e-12)
            memory, before, x = answer.memory, UP, x + way
        ends.append(x)
    return np.array(ends)


@pytest.mark.parametrize("stiffness", [50.0, 0.0], ids=["given", "that of the normal law"])
def test_a_stuck_point_does_not_creep_under_a_swinging_load(stiffness: float) -> None:
    phase = 2.0 * np.pi * np.arange(8) / 8
    swings = list(zip(10.0 + 5.0 * np.sin(phase), 200.0 + 150.0 * np.sin(phase), strict=True))
    ends = stuck_under_swinging_load(Coulomb(0.4, stiffness=stiffness), swings)
    np.testing.assert_allclose(ends[-1], ends[0], rtol=1e-11)


def test_a_spring_that_grows_stiffer_keeps_its_traction_and_loses_the_energy() -> None:
    law = Coulomb(1.0)
    first = law.respond(seen(UP, np.zeros(3), 10.0, [0.02, 0, 0], np.zeros((1, 7)), stiffness=100))
    then = law.respond(seen(UP, UP, 10.0, [0.0, 0, 0], first.memory, stiffness=400.0))
    back = law.respond(seen(UP, UP, 10.0, [0.0, 0, 0], then.memory, stiffness=1.0))
    assert then.force[0, 0] == first.force[0, 0] == -2.0
    assert (first.stored[0], then.stored[0]) == pytest.approx((0.02, 0.005))
    assert then.lost[0] == pytest.approx(0.015)
    assert (back.stiffness[0], back.stored[0], back.lost[0]) == (400.0, then.stored[0], 0.0)


def test_a_cone_that_shrinks_takes_the_energy_of_the_spring() -> None:
    steps = drag(Coulomb(0.4, stiffness=100.0), [0.04, 0.04, 0.04], [10.0, 5.0, 0.0])
    assert [s.force[0, 0] for s in steps] == pytest.approx([-4.0, -2.0, 0.0])
    assert [s.lost[0] for s in steps] == pytest.approx([0.0, 0.06, 0.02])


def test_the_coefficient_falls_from_static_to_dynamic_with_the_speed() -> None:
    law = Coulomb(0.5, 0.2, decay=2.0, stiffness=1e6)
    path, memory = np.tile([1.0, 0.0, 7.0], (3, 1)), np.zeros((3, 7))
    speeds = np.array([0.0, 0.7, 1e3])
    velocity = np.column_stack([speeds, 0 * speeds, [3.0, 3.0, 3.0]])
    answer = law.respond(seen(UP, UP, 10.0, path, memory, velocity=velocity))
    np.testing.assert_allclose(
        -answer.force[:, 0], 10 * (0.2 + 0.3 * np.exp(-2.0 * speeds)), rtol=1e-14
    )
    np.testing.assert_array_equal(answer.force[:, 1:], 0.0)
    held = Coulomb(0.5, 0.2, stiffness=1e6).respond(
        seen(UP, UP, 10.0, path, memory, velocity=velocity)
    )
    np.testing.assert_allclose(held.force[:, 0], -5.0)


def test_the_stiffness_of_a_unit_area_goes_with_the_area() -> None:
    law = Coulomb(1.0, stiffness=30.0, per_area=True)
    answer = law.respond(
        seen(UP, UP, 10.0, np.tile([0.1, 0, 0], (2, 1)), np.zeros((2, 7)), area=[0.5, 2.0])
    )
    np.testing.assert_allclose(answer.force[:, 0], [-1.5, -6.0])


def arc(start, end, n=20) -> np.ndarray:
    """Normals along the great circle from `start` to `end`, unit vectors at a right angle."""
    angle = np.linspace(0.0, np.pi / 2, n + 1)[1:, None]
    return np.cos(angle) * start + np.sin(angle) * end


def carry(normals, traction) -> np.ndarray:
    """Traction of a point whose foot runs over `normals` (k, 3) without any sliding."""
    law, memory = Coulomb(1.0, stiffness=1.0), np.zeros((1, 7))
    memory[0, :3], memory[0, 6] = traction, 1.0
    for before, now in pairwise(normals):
        memory = law.respond(seen(now, before, 10.0, [0, 0, 0], memory)).memory
    return memory[0, :3]


def test_a_traction_carried_round_a_great_circle_comes_back() -> None:
    x = np.array([1.0, 0.0, 0.0])
    tilted = np.array([0.0, 0.6, 0.8])
    circle = np.vstack([[x], arc(x, tilted), arc(tilted, -x), arc(-x, -tilted), arc(-tilted, x)])
    traction = np.array([0.0, 0.3, 0.7])
    np.testing.assert_allclose(carry(circle, traction), traction, rtol=1e-13, atol=1e-14)
    assert np.linalg.norm(carry(circle[:31], traction)) == pytest.approx(
        np.linalg.norm(traction), rel=1e-14
    )


def test_a_traction_carried_round_an_octant_turns_by_its_area() -> None:
    """Parallel transport: the angle is the area of the spherical triangle, π/2."""
    x, y, z = np.eye(3)
    round_trip = np.vstack([[x], arc(x, y), arc(y, z), arc(z, x)])
    np.testing.assert_allclose(carry(round_trip, y), z, atol=1e-13)


def test_a_traction_carried_far_stays_in_the_tangent_plane() -> None:
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(3000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    start = np.cross(normals[0], UP)
    end = carry(normals, start)
    assert abs(end @ normals[-1]) < 2e-16
    assert np.linalg.norm(end) == pytest.approx(np.linalg.norm(start), rel=1e-12)


def test_a_foot_that_jumps_to_the_opposite_side_keeps_its_traction() -> None:
    np.testing.assert_array_equal(carry(np.array([UP, -UP]), [1.0, 2.0, 0.0]), [1.0, 2.0, 0.0])


def test_viscous_friction_goes_with_the_speed_and_stores_nothing() -> None:
    law = ViscousFriction(0.3, speed=0.5)
    velocity = np.array([[0.0, 0.4, 9.0], [0.0, 0.0, -2.0], [1e3, 0.0, 0.0]])
    path = 0.1 * velocity
    begun = law.respond(seen(UP, UP, 10.0, path, np.zeros((3, 3)), velocity=velocity))
    answer = law.respond(seen(UP, UP, 10.0, path, begun.memory, velocity=velocity))
    np.testing.assert_allclose(
        answer.force, [[0, -3 * np.tanh(0.8), 0], [0, 0, 0], [-3, 0, 0]], rtol=1e-14
    )
    # That of the mean force: of a point that comes in, half.
    np.testing.assert_allclose(answer.lost, [0.04 * 3 * np.tanh(0.8), 0.0, 300.0], rtol=1e-14)
    np.testing.assert_array_equal(begun.lost, 0.5 * answer.lost)
    np.testing.assert_array_equal(answer.stored, 0.0)
    np.testing.assert_array_equal(answer.memory, answer.force)


def test_a_way_there_and_back_over_a_curved_surface_leaves_no_traction() -> None:
    """Deeper on the way there: seen from its end alone, each way has another length."""
    law, side = Coulomb(9.0, stiffness=100.0), np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    path, memory = np.array([[0.1, 0.05, -0.08]]), np.zeros((1, 7))
    there = law.respond(seen(side, UP, 10.0, path, memory))
    back = law.respond(seen(UP, side, 10.0, -path, there.memory))
    assert np.abs(there.force).max() > 5.0
    np.testing.assert_allclose(back.force, 0.0, atol=1e-14)
    np.testing.assert_allclose(law.slid(back.memory), 0.0, atol=1e-16)


@pytest.mark.parametrize("law", [Coulomb(0.3), ViscousFriction(0.3, 1.0)])
def test_no_points_have_no_friction(law) -> None:
    none = np.zeros(0)
    rows = np.zeros((0, 3))
    inp = FrictionInput(rows, rows, none, none, none, rows, rows, 0.1, np.zeros((0, law.n_memory)))
    assert law.respond(inp).force.shape == (0, 3)


def test_a_point_with_no_stiffness_to_stick_by_says_what_to_do() -> None:
    law, path = Coulomb(0.4), np.zeros((3, 3))
    with pytest.raises(InputError, match=r"friction\.stiffness: 2 points .*Give one, such as Coul"):
        law.respond(seen(UP, UP, [1.0, 0.0, 2.0], path, np.zeros((3, 7))))
    free = law.respond(seen(UP, UP, 0.0, path, np.zeros((3, 7))))
    np.testing.assert_array_equal(free.force, 0.0)


def test_a_memory_of_another_friction_is_refused() -> None:
    with pytest.raises(InputError, match=r"memory: .*another friction; found \(1, 2\)"):
        Coulomb(0.4).respond(seen(UP, UP, 1.0, [0, 0, 0], np.zeros((1, 2))))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Coulomb(-0.1), "static: must not be negative; found -0.1"),
        (lambda: Coulomb(np.nan), "static: must be finite"),
        (lambda: Coulomb("rough"), "static: must be a number"),
        (lambda: Coulomb(None), "static: must be a number"),  # type: ignore[arg-type]
        (lambda: Coulomb(0.3, -0.1), "dynamic: must not be negative"),
        (lambda: Coulomb(0.3, 0.4), "static: .*below the dynamic one; found 0.3; .*0.4 or above"),
        (lambda: Coulomb(0.3, decay=-1.0), "decay: must not be negative"),
        (lambda: Coulomb(0.3, decay=np.inf), "decay: must be finite"),
        (lambda: Coulomb(0.3, stiffness=-1.0), "stiffness: must not be negative"),
        (lambda: ViscousFriction(-0.3, 1.0), "coefficient: must not be negative"),
        (lambda: ViscousFriction(0.3, 0.0), "speed: must be positive"),
        (lambda: ViscousFriction(0.3, np.inf), "speed: must be positive"),
    ],
)
def test_a_wrong_option_is_refused_by_name(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_one_step_sticks_as_many_do_while_the_stiffness_grows() -> None:
    up, law = np.array([[0.0, 0.0, 1.0]]), Coulomb(1e3)

    def pulled(parts: int) -> float:
        memory = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 100.0]])
        for stiffness in np.linspace(100.0, 300.0, parts + 1)[1:]:
            path = np.array([[0.2 / parts, 0.0, 0.0]])
            inp = FrictionInput(
                up, up, np.ones(1), np.array([stiffness]), np.zeros(1), path, path, 1.0, memory
            )
            memory = law.respond(inp).memory
        return float(memory[0, 0])

    # ∫k dx over a way on which k grows evenly from 100 to 300
    assert pulled(1) == pytest.approx(-200.0 * 0.2, rel=1e-12)
    assert pulled(100) == pytest.approx(-200.0 * 0.2, rel=1e-12)


def rubbed(n: int) -> FrictionInput:
    """Points that slide every way over a surface that turns, under forces large and small."""
    rng = np.random.default_rng(4)
    normals = rng.normal(size=(2, n, 3))
    normals /= np.linalg.norm(normals, axis=2)[..., None]
    memory = 0.1 * rng.normal(size=(n, 7))
    memory[:, 6] = rng.uniform(0.0, 3.0, n)
    path, velocity = rng.normal(size=(2, n, 3))
    numbers = rng.uniform(0.1, 2.0, (3, n))
    return FrictionInput(*normals, *numbers, path, velocity, 0.1, memory)


@pytest.mark.parametrize("law", [Coulomb(0.4, 0.2, decay=0.3), ViscousFriction(0.3, speed=0.5)])
def test_a_point_has_the_same_bits_alone_and_among_many_on_threads(law: Friction) -> None:
    n = 3 * MIN_POINTS
    inp = rubbed(n)
    inp = inp._replace(memory=inp.memory[:, : law.n_memory])
    whole = law.respond(inp)
    for k in (0, MIN_POINTS - 1, MIN_POINTS, n - 1):
        rows = slice(k, k + 1)
        part = (v[rows] if isinstance(v, np.ndarray) else v for v in inp)
        for one, all_of_them in zip(law.respond(FrictionInput._make(part)), whole, strict=True):
            assert one.tobytes() == all_of_them[rows].tobytes()


def test_an_input_of_another_shape_is_refused_and_a_locked_one_is_not() -> None:
    inp = rubbed(3)
    with pytest.raises(InputError, match=r"path: friction must be given one row a point; found"):
        Coulomb(0.4).respond(inp._replace(path=inp.path[:2]))
    locked = inp._replace(normal=np.asfortranarray(inp.normal))
    locked.normal.flags.writeable = False
    for one, other in zip(Coulomb(0.4).respond(locked), Coulomb(0.4).respond(inp), strict=True):
        np.testing.assert_array_equal(one, other)
