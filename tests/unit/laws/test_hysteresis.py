"""Laws with hysteresis: what they remember, share and lose, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError
from contiga.laws.combined import CombinedLaw
from contiga.laws.force import ForceLaw
from contiga.laws.stress import StressLaw
from contiga.records import LawInput, LawOutput

# Loads along x, unloads along x − 1/2 where that is above zero, with lines of slope K between.
LOADING, UNLOADING, K = 1.0, [[0, 0], [0.5, 0], [1.5, 1]], 4.0


def law_input(depth, memory=None, area=1.0, rate=0.0, mass=None) -> LawInput:
    depth = np.atleast_1d(np.asarray(depth, dtype=float))

    def spread(value):
        return np.broadcast_to(np.float64(value), depth.shape).copy()

    memory = np.zeros((0, 0)) if memory is None else memory
    masses = None if mass is None else spread(mass)
    return LawInput(depth, spread(rate), spread(area), None, masses, 0.1, memory)


def follow(law, depths, **given) -> list[LawOutput]:
    answers: list[LawOutput] = []
    for depth in depths:
        memory = answers[-1].memory if answers else None
        answers.append(law.respond(law_input(depth, memory, **given)))
    return answers


def test_the_stress_law_remembers_strain_and_stress_of_each_point() -> None:
    law = StressLaw(1.0, 0.5, unloading=UNLOADING, hysteresis_slope=K)
    assert law.n_memory == 2
    up, down = follow(law, [[0.5, 0.25], [0.45, 0.3]], area=3.0)
    np.testing.assert_allclose(up.memory, [[1.0, 1.0], [0.5, 0.5]])
    np.testing.assert_allclose(down.force, [3 * 0.6, 3 * 0.6])
    np.testing.assert_allclose(down.stiffness, [3 * K / 0.5, 3 * 1.0 / 0.5])
    np.testing.assert_allclose(up.hysteresis[0], 3 * 0.5 / 3, rtol=1e-14)
    np.testing.assert_allclose(up.stored[0], 3 * 0.5 / 6, rtol=1e-14)


def test_the_force_law_remembers_the_whole_in_every_row() -> None:
    law = ForceLaw(1.0, unloading=UNLOADING, hysteresis_slope=K)
    first = law.respond(law_input([0.2, 1.0], area=2.0))
    np.testing.assert_array_equal(first.memory, [[1.0, 1.0], [1.0, 1.0]])
    # The deepest point has left and a new one has come: the other one still knows.
    kept = np.vstack([first.memory[:1], [[0.0, 0.0]]])
    then = law.respond(law_input([0.9, 0.1], kept))
    assert then.force.sum() == pytest.approx(0.6)
    assert first.hysteresis.sum() == pytest.approx(1 / 3)
    assert then.hysteresis.sum() == 0.0
    fresh = law.respond(law_input([0.9, 0.1], 0.0 * kept))
    assert fresh.force.sum() == pytest.approx(0.9)


def test_the_deepest_point_carries_all() -> None:
    answer = ForceLaw(2.0).respond(law_input([0.1, 0.4, 0.3], area=[5.0, 1.0, 1.0]))
    np.testing.assert_allclose(answer.force, [0.0, 0.8, 0.0], rtol=1e-15)
    np.testing.assert_allclose(answer.stiffness, [0.0, 2.0, 0.0], rtol=1e-15)
    assert answer.stored == pytest.approx([0.0, 0.16, 0.0])


def test_a_law_without_unloading_remembers_and_loses_nothing() -> None:
    for law in (StressLaw(2.0, 1.0), ForceLaw(2.0), CombinedLaw(*[StressLaw(2.0, 1.0)] * 2)):
        answer = law.respond(law_input([0.1, 0.2]))
        assert law.n_memory == 0
        assert answer.memory.shape == (2, 0)
        np.testing.assert_array_equal(answer.hysteresis, [0.0, 0.0])


def test_damping_acts_on_the_stress_of_the_hysteresis() -> None:
    law = StressLaw(1.0, 1.0, damping=0.5, unloading=UNLOADING, hysteresis_slope=K)
    first = law.respond(law_input(1.0))
    answer = law.respond(law_input(0.9, first.memory, rate=-0.4))
    assert answer.force[0] == pytest.approx(0.6 - 0.2)
    assert answer.damping[0] == pytest.approx(-0.2)
    np.testing.assert_allclose(answer.memory, [[0.9, 0.6]])


HALF = [[0, 0], [1, 0.5]]
FAR = Characteristic([[0.2, 0.1], [1, 0.5]], extrapolation="error", name="far")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((1.0, HALF, None), "hysteresis_slope: is missing: unloading was given"),
        ((1.0, None, 3.0), "unloading: is missing: hysteresis_slope was given"),
        ((1.0, HALF, np.nan), "hysteresis_slope: must be positive"),
        ((1.0, HALF, 0.0), "hysteresis_slope: must be positive"),
        ((1.0, HALF, 0.9), "steepest slope of the curve '(curve|elastic)'.*found 0.9.*1 or above"),
        (([[0, 0], [2, 9]], [[0, 0], [1, 0], [2, 6], [3, 6]], 5.0), "curve 'unloading'.* 6 "),
        ((1.0, [[0, 0], [1, 1.1]], 3.0), "unloading: .*above the loading curve at 1; found 1.1"),
        (([[0, 0], [1, 1]], [[0, 0], [0.4, 0.5], [1, 0.6]], 3.0), "above the loading curve at 0.4"),
        (([[0, 0], [1, 5]], [[0, 0], [1, 0], [2, 9]], 9.0), "rises above .* beyond"),
        ((1.0, [[0.1, 0], [1, 0.5]], 3.0), "unloading: .*below zero at 0;.*row of zero"),
        ((1.0, [[0, 0], [0.5, -0.1], [1, 0.5]], 3.0), "below zero at 0.5"),
        ((1.0, FAR, 3.0), "far: hysteresis needs a table that starts at zero"),
        ((1.0, lambda x: 2.0 * x, 3.0), "unloading: .*above the loading curve"),
        ((1.0, lambda x: 0.5 * x, 0.7), "hysteresis_slope: .*steepest"),
    ],
)
def test_curves_that_do_not_fit_are_refused(given, message: str) -> None:
    curve, unloading, slope = given
    for make in (lambda c, **kw: StressLaw(c, 1.0, **kw), ForceLaw):
        with pytest.raises(InputError, match=message):
            make(curve, unloading=unloading, hysteresis_slope=slope)


def test_a_callable_that_crosses_later_stops_where_it_does() -> None:
    law = StressLaw(1.0, 1.0, unloading=lambda x: x**2, hysteresis_slope=10.0)
    assert law.respond(law_input(0.5)).force[0] == 0.5
    with pytest.raises(InputError, match=r"above the loading curve at 1\."):
        law.respond(law_input(1.5))
    steep = StressLaw(lambda x: x**3, 1.0, unloading=0.0, hysteresis_slope=3.0)
    assert steep.respond(law_input(0.9)).force[0] == pytest.approx(0.9**3)
    with pytest.raises(InputError, match="hysteresis_slope: must not be below the steepest"):
        steep.respond(law_input(1.5))


def test_a_memory_of_another_law_and_a_share_that_is_none_are_refused() -> None:
    law = StressLaw(1.0, 1.0, unloading=HALF, hysteresis_slope=K)
    with pytest.raises(InputError, match=r"memory: the memory is of another law; found \(1, 3\)"):
        law.respond(law_input(0.5, np.ones((1, 3))))
    with pytest.raises(InputError, match="share: the share is not known; found 'all'"):
        ForceLaw(1.0, share="all")  # type: ignore[arg-type]


def test_combined_contact_refuses_unloading_and_a_share_of_critical_damping() -> None:
    plain, slow = StressLaw(1.0, 1.0), StressLaw(1.0, 1.0, damping_ratio=0.1)
    soft = StressLaw(1.0, 1.0, unloading=HALF, hysteresis_slope=K)
    with pytest.raises(InputError, match=r"law\.unloading: .*the split .* is not unique"):
        CombinedLaw(soft, plain)
    with pytest.raises(InputError, match=r"master_law\.unloading"):
        CombinedLaw(plain, soft)
    with pytest.raises(InputError, match=r"law\.damping_ratio: .*absolute damping"):
        CombinedLaw(slow, plain)
