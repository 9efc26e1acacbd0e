"""Springs: forces, energies, what goes slack, what has no direction, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from contiga.curves.characteristic import Characteristic
from contiga.dynamics.springs import Spring, SpringState
from contiga.errors import InputError, RunError
from contiga.rigid import pose

STILL = np.zeros((2, 3))
AT = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


def spring(**given: Any) -> Spring:
    """Between two bodies, two long at the start."""
    return Spring(**({"between": ("a", "b"), "at": AT} | given))


def ends(length: float) -> np.ndarray:
    return np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]])


def along(speed: float) -> np.ndarray:
    return np.array([[0.0, 0.0, 0.0], [speed, 0.0, 0.0]])


def follow(of: Spring, elongations: list[float], damper_speed: float = 0.0) -> list[SpringState]:
    """States at elongations that it goes through one after the other."""
    states = [of.start(ends(of.length + elongations[0]), along(damper_speed))]
    for x in elongations[1:]:
        states.append(of.step(states[-1], ends(of.length + x), along(damper_speed)))
    return states


@pytest.mark.parametrize("x", [0.5, -0.5, 7.0])
def test_a_stiffness_pulls_and_pushes(x: float) -> None:
    of = spring(curve=3.0)
    for state in (of.start(ends(2.0 + x), STILL), of.step(of.start(AT, STILL), ends(2 + x), STILL)):
        assert state.force == pytest.approx(3.0 * x, rel=1e-15)
        assert state.memory == state.force
        assert state.stored == pytest.approx(1.5 * x * x, rel=1e-14)
        assert (state.stiffness, state.damper, state.hysteresis, state.damping) == (3.0, 0, 0, 0)
        np.testing.assert_allclose(state.pull, [3.0 * x, 0.0, 0.0], rtol=1e-15)


def test_a_rest_length_of_its_own_makes_a_pretension_that_is_stored_at_the_start() -> None:
    state = spring(curve=3.0, length=1.5).start(AT, STILL)
    assert (state.force, state.stored, state.hysteresis) == (1.5, 0.375, 0.0)
    assert spring(curve=3.0).start(AT, STILL).force == 0.0


TABLES = [
    [[-2, -8], [-1, -1], [1, 2], [3, 3]],
    [[0, 0], [1, 2]],
    [[-1, 0], [0, 0], [1, 100]],
    [[0.5, 1], [1, 4]],
    [[-3, -2], [-1, -4]],
    [[0, 5], [1, 3], [2, 8]],
]


@pytest.mark.parametrize("extrapolation", ["linear", "constant"])
@pytest.mark.parametrize("table", TABLES)
def test_energy_and_stiffness_of_a_table_are_integral_and_slope_on_both_sides(
    table, extrapolation
) -> None:
    curve = Characteristic(table, extrapolation=extrapolation)
    of = spring(curve=curve, at=[[0, 0, 0], [10, 0, 0]])
    for x in (-5.0, -1.5, -0.7, -1e-3, 0.0, 1e-3, 0.6, 0.9, 1.7, 4.0):
        state = of.start(ends(10.0 + x), STILL)
        x = state.length - 10.0
        kinks = [k for k in (*curve.x, 0.0) if min(x, 0) < k < max(x, 0)] or None
        stored = quad(lambda s: float(curve(s)), 0.0, x, points=kinks)[0]
        assert state.force == pytest.approx(float(curve(x)), rel=1e-13, abs=1e-13)
        assert state.stored == pytest.approx(stored, rel=1e-12, abs=1e-13)
        slope = (float(curve(x + 1e-7)) - float(curve(x))) / 1e-7
        assert state.stiffness == pytest.approx(slope, abs=1e-5)


def test_a_table_that_must_not_be_left_stops_the_run() -> None:
    table = Characteristic([[-1, -1], [1, 1]], extrapolation="error")
    of = spring(curve=table)
    assert of.start(ends(3.0), STILL).force == 1.0
    for length in (3.001, 0.999):
        with pytest.raises(RunError, match=r"curve: .*outside its table \[-1, 1\]"):
            of.start(ends(length), STILL)


def test_the_same_holds_with_hysteresis() -> None:
    table = Characteristic([[0, 0], [1, 2]], extrapolation="error")
    of = spring(curve=table, unloading=1.0, hysteresis_slope=5.0)
    assert of.start(ends(3.0), STILL).force == 2.0
    assert of.start(ends(0.5), STILL).force == 0.0
    with pytest.raises(RunError, match=r"outside its table \[0, 1\]"):
        of.start(ends(3.001), STILL)


def test_a_function_is_integrated_and_differentiated_on_both_sides() -> None:
    of = spring(curve=lambda x: x**3 + x)
    for x in (-1.9, -0.5, 0.0, 0.5, 4.0):
        state = of.start(ends(2.0 + x), STILL)
        assert state.force == pytest.approx(x**3 + x, rel=1e-13, abs=1e-15)
        assert state.stored == pytest.approx(x**4 / 4 + x**2 / 2, rel=1e-13, abs=1e-15)
        assert state.stiffness == pytest.approx(3 * x * x + 1, rel=1e-8)
        assert of.stiffness_bound(state)[0] == state.stiffness


def test_a_damper_alone_feels_the_rate_along_its_line() -> None:
    of = spring(damping=4.0)
    velocities = np.array([[1.0, 5.0, 0.0], [3.0, -2.0, 9.0]])
    state = of.start(AT, velocities)
    assert (state.force, state.damper, state.stiffness, state.stored) == (8.0, 8.0, 0.0, 0.0)
    np.testing.assert_array_equal(state.pull, [8.0, 0.0, 0.0])


def test_a_damper_takes_its_force_times_the_way_by_the_trapezoidal_rule() -> None:
    of = spring(curve=1.0, damping=4.0)
    one = of.start(AT, along(0.5))
    two = of.step(one, ends(2.1), along(1.5))
    three = of.step(two, ends(2.0), along(-2.5))
    assert (one.damper, two.damper, three.damper) == (2.0, 6.0, -10.0)
    assert one.damping == 0.0
    assert two.damping == pytest.approx(0.5 * (2.0 + 6.0) * 0.1)
    assert three.damping == pytest.approx(two.damping + 0.5 * (6.0 - 10.0) * -0.1)
    assert two.force == pytest.approx(0.1 + 6.0)


BELT = {"curve": 2.0, "unloading": [[0, 0], [0.5, 0], [1, 1]], "hysteresis_slope": 4.0}


def test_hysteresis_makes_a_belt_that_is_slack_when_short() -> None:
    of = spring(**BELT)
    _, up, less, lower, slack, again = follow(of, [0.0, 1.0, 0.9, 0.7, -0.3, 0.25])
    assert (up.force, up.stiffness) == (2.0, 2.0)
    assert less.force == pytest.approx(1.6)  # down the line of hysteresis
    assert less.stiffness == 4.0
    assert lower.force == pytest.approx(0.8)
    assert tuple(slack[2:7]) == (0.0, 0.0, 0.0, 0.0, 0.0)
    np.testing.assert_array_equal(slack.pull, np.zeros(3))
    assert again.force == pytest.approx(0.5)  # along the loading curve: what was is forgotten
    # To one: 1 by L; back it gives the corner of the line to where it meets U, and under U.
    meet = 1.0 - 0.5  # 2 − 4 (1 − x) = 0 where U is zero up to 0.5
    given_back = 0.5 * 2.0 * (1.0 - meet)
    assert up.stored == pytest.approx(given_back)
    assert slack.hysteresis == pytest.approx(1.0 - given_back)


def test_the_damper_of_a_belt_never_pushes() -> None:
    of = spring(**BELT, damping=10.0)
    taut = of.start(ends(2.5), along(-1.0))
    assert (taut.force, taut.damper, taut.memory) == (0.0, -1.0, 1.0)
    assert of.start(ends(2.5), along(1.0)).force == 11.0
    slack = of.step(taut, ends(1.9), along(-1.0))
    assert (slack.force, slack.damper) == (0.0, 0.0)
    assert slack.damping == pytest.approx(0.5 * -1.0 * -0.6)
    assert of.step(taut, ends(1.9), along(1.0)).force == 0.0


@pytest.mark.parametrize("loading", [[[0, 1], [1, 3]], lambda x: 1.0 + 2.0 * x])
def test_a_belt_that_is_tight_at_its_rest_length_is_slack_below_it(loading) -> None:
    of = spring(curve=loading, unloading=[[0, 0.5], [1, 1]], hysteresis_slope=4.0)
    tight, slack, again = follow(of, [1.0, -0.1, 0.0])
    assert tight.force == 3.0
    assert tuple(slack[2:-1]) == (0.0,) * 7
    assert again.force == 0.5  # on the unloading curve: a new one from no force


def test_what_a_belt_lost_before_the_start_is_not_counted() -> None:
    state = spring(**BELT).start(ends(3.0), STILL)
    assert state.hysteresis == 0.0
    assert state.stored == pytest.approx(0.5)


def test_belts_of_functions_are_those_of_tables() -> None:
    def lower(x: np.ndarray) -> np.ndarray:
        return np.maximum(2.0 * x - 1.0, 0.0)

    path = [0.0, 0.6, 1.0, 0.9, 0.95, 0.3, 0.8, -0.2, 0.4]
    tables = follow(spring(**BELT), path)
    functions = follow(spring(**(BELT | {"curve": lambda x: 2.0 * x, "unloading": lower})), path)
    for a, b in zip(tables, functions, strict=True):
        np.testing.assert_allclose(a[1:6], b[1:6], rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(a[6:-1], b[6:-1], atol=1e-4)  # Gauss's rule across a kink


def test_ends_at_one_point_have_no_direction_and_no_force() -> None:
    of = spring(curve=3.0, damping=2.0)
    before = of.step(of.start(AT, STILL), ends(1e-300), along(-1.0))
    at = of.step(before, ends(0.0), along(-1.0))
    after = of.step(at, [[0, 0, 0], [-1e-3, 0, 0]], along(-1.0))
    assert np.isfinite(before.pull).all()
    assert at.force == -6.0  # the elastic part goes on, so that the energies do
    assert at.stored == pytest.approx(6.0)
    np.testing.assert_array_equal(at.pull, np.zeros(3))
    np.testing.assert_array_equal(of.stiffness_bound(at), [3.0, 3.0])
    # Behind it the ends have changed sides: pushed apart, the first one to the right.
    assert after.pull[0] > 0.0
    assert after.damper == 2.0


def test_ends_change_places_and_turn_with_the_world() -> None:
    rng = np.random.default_rng(5)
    at, now, velocities = rng.normal(size=(3, 2, 3))
    one = Spring(("a", "b"), at=at, curve=TABLES[0], damping=0.7)
    state = one.step(one.start(at, velocities), now, velocities)
    other = Spring(("b", "a"), at=at[::-1], curve=TABLES[0], damping=0.7)
    swapped = other.step(other.start(at[::-1], velocities[::-1]), now[::-1], velocities[::-1])
    np.testing.assert_allclose(swapped.pull, -state.pull, rtol=1e-14)
    np.testing.assert_allclose(swapped[1:-1], state[1:-1], rtol=1e-14)
    X = pose.rotation([1.0, 2.0, -1.0], 0.9)
    R = X[:3, :3]
    turned = Spring(("a", "b"), at=at @ R.T, curve=TABLES[0], damping=0.7)
    first = turned.start(at @ R.T, velocities @ R.T)
    last = turned.step(first, now @ R.T, velocities @ R.T)
    np.testing.assert_allclose(last.pull, R @ state.pull, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(last[1:-1], state[1:-1], rtol=1e-12, atol=1e-13)


def test_a_state_is_not_changed_by_what_comes_after() -> None:
    of = spring(**BELT, damping=1.0)
    where = ends(2.7)
    state = of.start(where, along(1.0))
    kept = [np.copy(value) for value in state]
    one = of.step(state, ends(2.4), along(-1.0))
    where[:] = 99.0
    two = of.step(state, ends(2.4), along(-1.0))
    for before, after in zip(kept, state, strict=True):
        np.testing.assert_array_equal(before, after)
    np.testing.assert_array_equal(one[1:-1], two[1:-1])


def test_bounds_of_the_stiffness_see_the_pieces_beside() -> None:
    of = spring(curve=[[-1, -7], [0, 0], [1, 1], [2, 30], [3, 31]], at=[[0, 0, 0], [8, 0, 0]])
    for x, bound in ((-3.0, 7.0), (-0.5, 7.0), (0.5, 29.0), (1.5, 29.0), (2.5, 29.0), (9.0, 1.0)):
        state = of.start(ends(8.0 + x), STILL)
        along_it, across = of.stiffness_bound(state)
        assert along_it == bound
        assert across == pytest.approx(max(state.force, 0.0) / (8.0 + x))
    falling = spring(curve=[[0, 0], [1, -1]])
    assert falling.stiffness_bound(falling.start(AT, STILL))[0] == 0.0
    belt = spring(**BELT)
    for x in (-1.0, 0.0, 0.5):
        assert belt.stiffness_bound(belt.start(ends(2.0 + x), STILL))[0] == 4.0


def test_names() -> None:
    assert spring(curve=1.0).name == "a-b"
    assert spring(curve=1.0, name="left belt").name == "left belt"
    assert spring(between=["a", "ground"], curve=1.0).between == ("a", "ground")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "curve: a spring needs a curve or a damping; found 'neither'"),
        ({"unloading": 1.0}, "curve: is missing.*Give the curve, or remove unloading"),
        ({"hysteresis_slope": 1.0, "damping": 1.0}, "curve: is missing"),
        ({"curve": 1.0, "damping": -1.0}, "damping: must not be negative"),
        ({"curve": 1.0, "length": -1.0}, "length: must not be negative"),
        ({"curve": 1.0, "length": np.inf}, "length: must be finite"),
        ({"curve": 1.0, "between": ("a", "a")}, "between: both ends are of one body.*'a', 'a'"),
        ({"curve": 1.0, "between": ("ground", "ground")}, "between: both ends are on the ground"),
        ({"curve": 1.0, "between": ("a",)}, "between: must be two names"),
        ({"curve": 1.0, "between": "a"}, "between: must be two names; found 'a'"),
        ({"curve": 1.0, "between": ("a", "")}, "between: must be two names"),
        ({"curve": 1.0, "at": [[1, 2, 3], [1, 2, 3]]}, "at: the two points are one"),
        ({"curve": 1.0, "at": [[0, 0, 0], [0, 0, 0]]}, "at: the two points are one"),
        ({"curve": 1.0, "at": [[100, 0, 0], [100 + 1e-14, 0, 0]]}, "at: the two points are one"),
        ({"curve": 1.0, "at": [1, 2, 3]}, "at: must be two finite points"),
        ({"curve": 1.0, "at": [[1, 2, 3], [1, 2]]}, "at: must be two points"),
        ({"curve": 1.0, "at": [[1, 2, 3], [1, 2, np.nan]]}, "at: must be two finite points"),
        ({"curve": [[0, 0]]}, "curve: .*at least 2 rows"),
        ({"curve": 2.0, "unloading": 1.0}, "hysteresis_slope: is missing"),
        ({"curve": 1.0, "unloading": 2.0, "hysteresis_slope": 5.0}, "unloading: .*above the load"),
        ({"curve": 2.0, "unloading": 1.0, "hysteresis_slope": 1.0}, "hysteresis_slope: must not"),
        (
            {"curve": Characteristic([[1, 0], [2, 1]], extrapolation="error")},
            "curve: .*needs the elongation zero in it",
        ),
    ],
)
def test_a_wrong_spring_is_refused_with_its_rule(given, message) -> None:
    with pytest.raises(InputError, match=message):
        spring(**given)
