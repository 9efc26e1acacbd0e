"""Damping: a share of what is critical, and the part of a force that is due to the rate."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError
from contiga.laws.combined import CombinedLaw
from contiga.laws.force import ForceLaw
from contiga.laws.normal import AdaptiveLaw, PenaltyLaw
from contiga.laws.stress import StressLaw
from contiga.records import LawInput

DEPTH = np.array([0.1, 0.2, 0.2])
RATE = np.array([0.5, -0.5, -90.0])
AREA = np.array([2.0, 0.5, 0.5])
MASS = np.array([3.0, 0.7, 0.7])
INPUT = LawInput(DEPTH, RATE, AREA, None, MASS, 0.1)


@pytest.mark.parametrize(
    ("law", "stiffness"),
    [
        (PenaltyLaw(8.0, damping_ratio=0.3), np.full(3, 8.0)),
        (PenaltyLaw(8.0, per_area=True, damping_ratio=0.3), 8.0 * AREA),
        (StressLaw(8.0, 0.5, damping_ratio=0.3), 8.0 * AREA / 0.5),
    ],
)
def test_the_ratio_damps_a_share_of_twice_the_root_of_stiffness_times_mass(law, stiffness) -> None:
    answer = law.respond(INPUT)
    elastic = stiffness * DEPTH
    force = np.maximum(elastic + 2.0 * 0.3 * np.sqrt(stiffness * MASS) * RATE, 0.0)
    assert law.needs_mass
    assert force[2] == 0.0
    np.testing.assert_allclose(answer.force, force, rtol=1e-14)
    np.testing.assert_allclose(answer.damping, force - elastic, rtol=1e-13)


def test_the_ratio_adds_to_an_absolute_damping() -> None:
    both = PenaltyLaw(8.0, damping=2.0, damping_ratio=0.3).respond(INPUT).force[0]
    one = PenaltyLaw(8.0, damping_ratio=0.3).respond(INPUT).force[0]
    assert both - one == pytest.approx(2.0 * RATE[0])


def test_the_stiffness_of_a_stress_law_is_the_present_one() -> None:
    law = StressLaw([[0, 0], [0.3, 3], [1, 3]], 1.0, damping_ratio=0.5)
    one = np.ones(1)
    for depth, slope in ((0.2, 10.0), (0.6, 0.0)):
        answer = law.respond(LawInput(depth * one, one, one, None, 4.0 * one, 0.1))
        assert answer.damping is not None
        assert answer.damping[0] == pytest.approx(np.sqrt(4.0 * slope))


def test_a_mass_critically_damped_comes_back_as_the_closed_form_says() -> None:
    """x = (x₀ + (v₀ + ω x₀) t) e^(−ω t); here it presses a preloaded spring, and never swings."""
    k, m, dt, x, v = 50.0, 2.0, 1e-5, 0.3, 0.0
    law, one = PenaltyLaw(k, damping_ratio=1.0), np.ones(1)
    omega, offset = np.sqrt(k / m), 1.0
    for _ in range(60000):
        answer = law.respond(LawInput((offset + x) * one, v * one, one, None, m * one, dt))
        v += (k * offset - answer.force[0]) / m * dt
        x += v * dt
    t = 0.6
    assert x == pytest.approx(0.3 * (1.0 + omega * t) * np.exp(-omega * t), rel=1e-4)


@pytest.mark.parametrize(
    "law",
    [
        PenaltyLaw(8.0, damping=0.2),
        StressLaw(8.0, 0.5, damping=0.2),
        CombinedLaw(StressLaw(8.0, 0.5, damping=0.2), StressLaw(8.0, 0.5, damping=0.2)),
    ],
)
def test_what_is_due_to_the_rate_is_the_force_less_that_at_rest(law) -> None:
    rest = law.respond(INPUT._replace(rate=np.zeros(3)))
    moving = law.respond(INPUT)
    assert not law.needs_mass
    assert moving.force[2] == 0.0
    np.testing.assert_allclose(moving.damping, moving.force - rest.force, rtol=1e-13)
    np.testing.assert_array_equal(rest.damping, np.zeros(3))


@pytest.mark.parametrize("law", [ForceLaw(3.0), AdaptiveLaw()])
def test_laws_without_a_rate_tell_that_none_of_the_force_is_due_to_it(law) -> None:
    answer = law.respond(INPUT)
    np.testing.assert_array_equal(answer.damping, np.zeros(3))
    np.testing.assert_array_equal(answer.hysteresis, np.zeros(3))


@pytest.mark.parametrize(
    "law", [PenaltyLaw(8.0, damping_ratio=0.3), StressLaw(8.0, 0.5, damping_ratio=0.3)]
)
def test_a_ratio_without_masses_says_what_to_do(law) -> None:
    with pytest.raises(InputError, match=r"damping_ratio: .*needs nodal masses.*absolute damping"):
        law.respond(INPUT._replace(mass=None))


HELD = {"extrapolation": "constant", "name": "damping_curve"}


@pytest.mark.parametrize(
    ("curve", "told"),
    [
        (-3.0, "is below zero at 1;"),
        ([[-1, 3], [0, 0], [1, 3]], "is above zero at -1"),
        ([[-1, -3], [0, 0], [1, -2]], "is below zero at 1;.*found -2.*zero or above"),
        ([[-1, -3], [1, 4]], r"is above zero at 0;.*found 0.5; allowed: zero\."),
        ([[0, 0], [1, 3], [2, 1]], "is below zero at 2000;.*extrapolation = .linear"),
        (Characteristic([[0.5, 2.0], [1.0, 3.0]], **HELD), "is above zero at 0;"),
        (lambda rate: np.abs(rate), "is above zero at -1"),
        (lambda rate: 1.0 + rate, "is above zero at -"),
    ],
)
def test_a_damping_curve_that_pushes_on_is_refused(curve, told) -> None:
    with pytest.raises(InputError, match=rf"damping_curve: the damping curve {told}"):
        StressLaw(1.0, 1.0, damping_curve=curve)


def test_a_function_is_looked_at_at_the_rates_of_a_run() -> None:
    law = StressLaw(8.0, 0.5, damping_curve=lambda rate: np.where(rate < -10.0, 1.0, rate))
    law.respond(INPUT._replace(rate=np.array([0.5, -0.5, -4.9])))
    with pytest.raises(InputError, match="the damping curve is above zero at -180"):
        law.respond(INPUT)


@pytest.mark.parametrize(
    "curve",
    [
        2.0,
        0.0,
        [[0, 0], [1, 3]],
        [[-1, -3], [0, 0], [1, 5], [2, 5]],
        Characteristic([[0, 0], [1, 3], [2, 1]], **HELD),
        Characteristic([[0.5, 2.0], [1.0, 3.0]], extrapolation="error"),
        [[-0.3, -0.3], [0.1, 0.1]],
        np.arctan,
    ],
)
def test_a_damping_curve_that_resists_is_taken(curve) -> None:
    answer = StressLaw(8.0, 0.5, damping_curve=curve).respond(
        INPUT._replace(rate=np.array([0.3, 0.4, 0.5]))
    )
    assert (answer.damping >= 0.0).all()


@pytest.mark.parametrize("value", [-0.1, np.inf, "much"])
def test_a_wrong_ratio_is_refused(value) -> None:
    for make in (PenaltyLaw, lambda k, **kw: StressLaw(k, 1.0, **kw)):
        with pytest.raises(InputError, match="damping_ratio: must"):
            make(8.0, damping_ratio=value)
