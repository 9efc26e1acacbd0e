"""Laws of joints: stops, friction and hysteresis by their work; what is refused."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from contiga.dynamics.joint_laws import JointLaw, JointLawState
from contiga.errors import InputError


def driven(law: JointLaw, values: np.ndarray) -> list[JointLawState]:
    """States along a way, at a rate that no law here asks for."""
    states = [law.begin(float(values[0]), 0.0)]
    for value in values[1:]:
        states.append(law.step(states[-1], float(value), 0.0))
    return states


def work_on(states: list[JointLawState]) -> float:
    return sum(0.5 * (a.force + b.force) * (b.value - a.value) for a, b in pairwise(states))


WAY = np.concatenate([np.linspace(0, 0.7, 701), np.linspace(0.7, -0.9, 1601)[1:]])


def test_stops_push_back_by_how_far_they_are_passed() -> None:
    law = JointLaw(stops=(-0.5, 0.25), stop_curve=[[0, 0], [0.1, 2.0], [0.2, 8.0], [0.3, 20.0]])
    for value, force in ((0.2, 0.0), (0.3, 1.0), (0.4, 5.0), (-0.5, 0.0), (-0.65, -5.0)):
        assert law.step(law.begin(0.0, 0.0), value, 0.0).force == pytest.approx(force)
    assert law.stiffness_bound(0.0) == pytest.approx(60.0)  # of the first piece and the next
    assert law.stiffness_bound(0.36) == pytest.approx(120.0)
    assert law.begin(0.0, 0.0).stored == 0.0
    assert law.step(law.begin(0.0, 0.0), 0.4, 0.0).stored == pytest.approx(0.1 + 3.5 * 0.05)


@pytest.mark.parametrize(
    "law",
    [
        JointLaw(3.0, friction=0.4, friction_slope=20.0, stops=(-0.5, 0.5), stop_curve=30.0),
        JointLaw(
            [[0, 0], [0.3, 1.0], [1.0, 5.0]],
            unloading=[[0, 0], [0.3, 0.2], [1.0, 3.0]],
            hysteresis_slope=40.0,
        ),
    ],
    ids=["friction and stops", "hysteresis"],
)
def test_work_is_stored_or_lost(law: JointLaw) -> None:
    states = driven(law, WAY)
    last = states[-1]
    lost = last.hysteresis + last.friction
    assert work_on(states) == pytest.approx(last.stored + lost, rel=1e-3)
    assert lost > 0.1
    assert all(b.friction >= a.friction and b.hysteresis >= a.hysteresis - 1e-15
               for a, b in pairwise(states))  # fmt: skip


def test_friction_slides_at_its_limit_and_takes_force_times_way() -> None:
    states = driven(JointLaw(friction=2.0, friction_slope=100.0), np.linspace(0.0, 1.0, 11))
    assert [state.force for state in states[1:]] == [2.0] * 10
    assert states[-1].friction == pytest.approx(2.0 * (1.0 - 0.02))
    assert states[-1].stored == pytest.approx(0.02)
    back = JointLaw(friction=2.0, friction_slope=100.0).step(states[-1], 0.99, 0.0)
    assert back.force == pytest.approx(1.0)  # it sticks


def test_hysteresis_acts_alike_to_both_sides() -> None:
    law = JointLaw([[0, 0], [1, 4.0]], unloading=[[0, 0], [1, 1.0]], hysteresis_slope=50.0)
    there, back = driven(law, WAY), driven(law, -WAY)
    for one, other in zip(there, back, strict=True):
        assert one.force == -other.force
        assert (one.stored, one.hysteresis) == (other.stored, other.hysteresis)


def test_a_damper_takes_its_force_times_the_way() -> None:
    law = JointLaw(damping=3.0)
    state = law.begin(0.0, 2.0)
    assert (state.force, state.damping) == (6.0, 0.0)
    state = law.step(state, 0.1, 2.0)
    assert (state.force, state.damping) == (6.0, pytest.approx(0.6))


@pytest.mark.parametrize(
    ("options", "where", "what"),
    [
        ({"friction": 1.0}, "friction_slope", "is missing"),
        ({"friction_slope": 1.0}, "friction", "is missing"),
        ({"stops": (0, 1)}, "stop_curve", "is missing"),
        ({"stop_curve": 1.0}, "stops", "is missing"),
        ({"stops": (1, 0), "stop_curve": 1.0}, "stops", "rise"),
        ({"stops": (0, 1), "stop_curve": 1.0, "start": 1.25}, "stops", "0.25 beyond its stop"),
        ({"stops": (0.1, 1), "stop_curve": 1.0}, "stops", "0.1 beyond its stop"),
        ({"unloading": 1.0}, "curve", "is missing"),
        ({"curve": 1.0, "unloading": 1.0}, "hysteresis_slope", "is missing"),
        ({"damping": -1.0}, "damping", "negative"),
    ],
)
def test_laws_that_do_not_go_together_are_refused(
    options: dict[str, Any], where: str, what: str
) -> None:
    with pytest.raises(InputError, match=what) as told:
        JointLaw(**options)
    assert told.value.where == where
