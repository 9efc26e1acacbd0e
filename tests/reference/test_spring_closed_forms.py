"""Springs against closed forms: cycles of a belt, and masses that swing on springs and dampers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contiga.dynamics.springs import Spring, SpringState

AT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
MASS = 2.0


def longer(x: float) -> np.ndarray:
    """Ends of a spring that is longer by `x` than at the start."""
    return AT + np.array([[0.0, 0.0, 0.0], [x, 0.0, 0.0]])


def swing(
    of: Spring, start: float, speed: float, step: float, steps: int
) -> tuple[np.ndarray, np.ndarray, list[SpringState]]:
    """Places and speeds of a mass at the spring's second end, its first end held (Verlet).

    The damper is given the speed that half a step of the force before makes.
    """

    def seen(x: float, v: float) -> tuple[np.ndarray, np.ndarray]:
        return longer(x), np.array([[0, 0, 0], [v, 0, 0]])

    x, v = start, speed
    states = [of.start(*seen(x, v))]
    ways, speeds = [x], [v]
    for _ in range(steps):
        push = -states[-1].pull[0] / MASS
        half = v + 0.5 * step * push
        x += step * half
        states.append(of.step(states[-1], *seen(x, half + 0.5 * step * push)))
        v = half - 0.5 * step * states[-1].pull[0] / MASS
        ways.append(x)
        speeds.append(v)
    return np.array(ways), np.array(speeds), states


def ledger(speeds: np.ndarray, states: list[SpringState], step: float) -> np.ndarray:
    """Kinetic, stored and lost energy after every step.

    Verlet keeps m v²/2 − (F step)²/(8 m) in place of the kinetic energy itself: with the work of
    forces by the trapezoidal rule the sum is constant to rounding, if the ledger is right.
    """
    own = [state.stored + state.hysteresis + state.damping for state in states]
    force = np.array([state.pull[0] for state in states])
    return 0.5 * MASS * speeds**2 - (force * step) ** 2 / (8.0 * MASS) + np.array(own)


def swinging(k: float, c: float) -> Callable[[np.ndarray], np.ndarray]:
    """Elongation over time from rest at 0.3, less than critically damped."""
    rate, natural = c / (2.0 * MASS), k / MASS
    turns = np.sqrt(natural - rate**2)
    return lambda t: (
        0.3 * np.exp(-rate * t) * (np.cos(turns * t) + rate / turns * np.sin(turns * t))
    )


@pytest.mark.parametrize("c", [0.0, 0.4, 3.0])
def test_a_mass_on_a_spring_and_a_damper_dies_away_with_second_order(c: float) -> None:
    k, end, errors = 8.0, 6.0, []
    for steps in (600, 1200):
        of = Spring(("ground", "mass"), at=AT, curve=k, damping=c)
        x, v, states = swing(of, 0.3, 0.0, end / steps, steps)
        t = np.linspace(0.0, end, steps + 1)
        errors.append(np.abs(x - swinging(k, c)(t)).max())
        # Trapezoidal work on a linear spring is its energy: the ledger closes to rounding.
        total = ledger(v, states, end / steps)
        np.testing.assert_allclose(total, total[0], rtol=1e-12)
    assert errors[0] < 2e-4
    assert np.log2(errors[0] / errors[1]) > 1.9


def test_the_damper_takes_all_in_the_end() -> None:
    of = Spring(("ground", "mass"), at=AT, curve=8.0, damping=3.0)
    _, v, states = swing(of, 0.3, 0.0, 0.001, 30000)
    assert states[-1].damping == pytest.approx(0.5 * 8.0 * 0.3**2, rel=2e-6)
    assert abs(v[-1]) < 1e-9


def test_a_damper_alone_stops_a_mass_on_the_way_m_v_by_c() -> None:
    of = Spring(("ground", "mass"), at=AT, damping=0.5)
    x, v, states = swing(of, 0.0, 1.0, 0.02, 4000)
    t = 0.02 * np.arange(4001)
    np.testing.assert_allclose(v, np.exp(-0.25 * t), atol=2e-5)
    assert x[-1] == pytest.approx(MASS * 1.0 / 0.5, rel=1e-4)
    total = ledger(v, states, 0.02)
    np.testing.assert_allclose(total, total[0], rtol=1e-12)


def test_a_belt_stops_a_body_and_gives_back_what_its_unloading_says() -> None:
    """Loading k x, unloading k x / 4 (met by lines of slope 2 k): from v, back with less.

    Deepest at v √(m/k). The line from (x, k x) meets U at 4/7 x; given back is the area under it
    and under U: a trapezium and a triangle.
    """
    k, speed, errors = 50.0, 2.0, []
    for step in (2e-3, 1e-3):
        of = Spring(
            ("ground", "mass"), at=AT, curve=k, unloading=0.25 * k, hysteresis_slope=2.0 * k
        )
        x, v, states = swing(of, 0.0, speed, step, round(1.2 / step))
        deepest = speed * np.sqrt(MASS / k)
        meet = 4.0 / 7.0 * deepest
        low = 0.25 * k * meet
        given_back = 0.5 * (k * deepest + low) * (deepest - meet) + 0.5 * low * meet
        put_in = 0.5 * MASS * speed**2
        back = -np.sqrt(2.0 * given_back / MASS)
        assert states[-1].force == 0.0
        assert x[-1] < 0.0
        errors.append(
            [
                abs(x.max() / deepest - 1.0),
                abs(v[-1] / back - 1.0),
                abs(states[-1].hysteresis / (put_in - given_back) - 1.0),
                float(np.abs(ledger(v, states, step) / put_in - 1.0).max()),
            ]
        )
    assert np.max(errors) < 2e-3
    assert max(errors[1]) < 5e-4


def test_a_closed_cycle_of_a_belt_loses_the_area_between_its_curves() -> None:
    """Loading 6 x² + x by a fine table, unloading x/2: areas 2 x³ + x²/2 and x²/4.

    The line of hysteresis is so steep that the corner it cuts is nothing.
    """
    x = np.linspace(0.0, 2.0, 2001)
    of = Spring(
        ("ground", "a"),
        at=AT,
        curve=np.column_stack([x, 6.0 * x**2 + x]),
        unloading=0.5,
        hysteresis_slope=1e9,
    )
    still = np.zeros((2, 3))
    state = of.start(AT, still)
    for way in np.concatenate([np.linspace(0, 1.5, 40)[1:], np.linspace(1.5, 0.0, 23)[1:]]):
        state = of.step(state, longer(way), still)
    area = 2.0 * 1.5**3 + 0.5 * 1.5**2 - 0.25 * 1.5**2
    assert state.hysteresis == pytest.approx(area, rel=1e-6)
    assert state.stored == pytest.approx(0.0, abs=1e-12)


def test_two_free_masses_keep_their_momentum_and_swing_with_the_reduced_mass() -> None:
    of = Spring(("a", "b"), at=AT, curve=8.0)
    masses = np.array([[1.0], [3.0]])
    x, v = longer(0.2), np.array([[1.0, 0.5, 0.0], [1.0, 0.5, 0.0]])
    state, step, lengths = of.start(x, v), 0.001, []
    for _ in range(2000):
        for last in (False, True):
            force = np.array([state.pull, -state.pull])
            v = v + 0.5 * step * force / masses
            if not last:
                x = x + step * v
                state = of.step(state, x, v)
        lengths.append(state.length)
    np.testing.assert_allclose((masses * v).sum(axis=0), [4.0, 2.0, 0.0], rtol=1e-13, atol=1e-13)
    t = step * np.arange(1, 2001)
    np.testing.assert_allclose(lengths, 1.0 + 0.2 * np.cos(np.sqrt(8.0 / 0.75) * t), atol=2e-6)
