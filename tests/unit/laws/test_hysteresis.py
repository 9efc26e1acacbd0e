"""Hysteresis against closed forms: where the force goes, what is stored, what is lost."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.laws.characteristic import Characteristic
from contiga.laws.combined import CombinedLaw
from contiga.laws.force import ForceLaw
from contiga.laws.hysteresis import Hysteresis
from contiga.laws.stress import StressLaw
from contiga.records import LawInput, LawOutput

# Loads along x, unloads along x − 1/2 where that is above zero: a set of 1/2. From (1, 1) down the
# line of slope 4 to (5/6, 1/3): stored 1/9 + 1/18.
LOADING, UNLOADING, K = 1.0, [[0, 0], [0.5, 0], [1.5, 1]], 4.0
PAD = Hysteresis(Characteristic(LOADING), Characteristic(UNLOADING), K)
PAD_OF_FUNCTIONS = Hysteresis(
    Characteristic(lambda x: x), Characteristic(lambda x: np.maximum(x - 0.5, 0.0)), K
)


def run(pad: Hysteresis, path) -> list:
    """The steps of one point along `path`, from nothing."""
    x, force, steps = np.zeros(1), np.zeros(1), []
    for value in path:
        moved = pad.move(x, force, np.array([float(value)]))
        x, force = np.array([float(value)]), moved.force
        steps.append(moved)
    return steps


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


@pytest.mark.parametrize("pad", [PAD, PAD_OF_FUNCTIONS], ids=["tables", "functions"])
def test_the_force_goes_up_the_loading_down_the_line_and_the_unloading_and_up_the_line(pad) -> None:
    path = [0.4, 1.0, 0.9, 5 / 6, 0.7, 0.5, 0.2, 0.5, 0.7, 0.72, 0.9, 1.2]
    force = [0.4, 1.0, 0.6, 1 / 3, 0.2, 0.0, 0.0, 0.5, 0.7, 0.72, 0.9, 1.2]
    np.testing.assert_allclose([m.force[0] for m in run(pad, path)], force, rtol=1e-9, atol=1e-9)


def test_what_is_stored_at_the_peak_is_what_the_way_down_gives_back() -> None:
    peak, zero = run(PAD, [1.0, 0.0])
    assert peak.stored[0] == pytest.approx(1 / 9 + 1 / 18, rel=1e-14)
    assert peak.lost[0] == pytest.approx(0.5 - 1 / 6, rel=1e-14)
    assert (zero.stored[0], zero.lost[0], zero.force[0]) == (0.0, 0.0, 0.0)


def test_functions_are_met_and_integrated_to_rounding() -> None:
    """x² and x²/2: the line from (1, 1) meets where s² − 8 s + 6 = 0."""
    pad = Hysteresis(Characteristic(lambda x: x**2), Characteristic(lambda x: 0.5 * x**2), K)
    s = 4.0 - np.sqrt(10.0)
    stored = (1.0 - s) * (1.0 - 0.5 * K * (1.0 - s)) + s**3 / 6.0
    peak, _ = run(pad, [1.0, 0.0])
    assert peak.stored[0] == pytest.approx(stored, rel=1e-13)
    for steps in (1, 7, 50):
        ways = np.linspace(0.0, 1.0, steps + 1), np.linspace(1.0, 0.0, steps + 1)
        lost = sum(m.lost[0] for m in run(pad, np.concatenate([ways[0][1:], ways[1][1:]])))
        assert lost == pytest.approx(1.0 / 3.0 - stored, rel=1e-12)


def test_the_stiffness_is_that_of_the_curve_or_the_line_the_force_is_on() -> None:
    steps = run(PAD, [0.4, 1.0, 0.9, 0.7, 0.3, 0.35, 1.2])
    assert [m.stiffness[0] for m in steps] == [1.0, 1.0, K, 1.0, 0.0, K, 1.0]


def test_where_the_curves_touch_the_stiffness_is_that_of_more_load() -> None:
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [2, 3]]), Characteristic([[0, 0], [1, 1], [2, 2]]), 5.0
    )
    assert [m.stiffness[0] for m in run(pad, [1.0, 1.5, 1.0])] == [2.0, 2.0, 2.0]


@pytest.mark.parametrize("steps", [1, 7, 1000])
def test_a_cycle_loses_the_area_between_the_curves_whatever_the_steps(steps: int) -> None:
    up, down = np.linspace(0.0, 1.0, steps + 1), np.linspace(1.0, 0.0, steps + 1)
    lost = sum(m.lost[0] for m in run(PAD, [*up[1:], *down[1:]]))
    assert lost == pytest.approx(1 / 3, rel=1e-12)


def test_a_small_cycle_inside_loses_its_own_parallelogram() -> None:
    """(0.7, 0.2) up the line to L at 13/15, along L to 0.95, down to U: between two lines."""
    start = 13 / 15
    lost = [m.lost[0] for m in run(PAD, [1.0, 0.7, 0.95, 0.7])]

    def stored(x: float) -> float:
        s = (K * x - x - 0.5) / (K - 1.0)
        return (x - s) * (x - K * (x - s) / 2) + 0.5 * (s - 0.5) ** 2

    work = 0.5 * (0.95**2 - start**2)
    assert lost[2] == pytest.approx(work - stored(0.95) + stored(start), rel=1e-11)
    assert lost[1] == lost[3] == 0.0


def test_a_softening_curve_loses_what_the_force_gives_up() -> None:
    """Up to 1 at 1 and down to 0 at 2: all the work is lost, as nothing is left to give back."""
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [2, 0]]), Characteristic([[0, 0], [2, 0]]), 3.0
    )
    steps = run(pad, np.linspace(0.0, 2.5, 37)[1:])
    assert steps[-1].force[0] == steps[-1].stored[0] == 0.0
    assert sum(m.lost[0] for m in steps) == pytest.approx(1.0, rel=1e-12)
    assert min(m.lost[0] for m in steps) >= -1e-15


def test_an_unloading_that_its_extrapolation_takes_below_zero_counts_as_zero_there() -> None:
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [3, 1]]),
        Characteristic([[0, 0], [1, 0.9], [1.2, 0.1]]),
        5.0,
    )
    assert [m.force[0] for m in run(pad, [3.0, 2.5, 2.81])] == [1.0, 0.0, 1.0]


def test_a_preload_starts_between_the_curves_at_zero() -> None:
    pad = Hysteresis(
        Characteristic([[0, 3.0], [1, 4.0]]), Characteristic([[0, 1.0], [1, 1.0]]), 10.0
    )
    steps = run(pad, [0.1, 1.0, 0.0])
    assert [m.force[0] for m in steps] == pytest.approx([2.0, 4.0, 1.0])
    whole = run(pad, [1.0, 0.0])
    assert sum(m.lost[0] for m in steps) == pytest.approx(sum(m.lost[0] for m in whole))


def test_a_line_as_steep_as_a_curve_is_allowed_and_loses_nothing_on_it() -> None:
    pad = Hysteresis(Characteristic(2.0), Characteristic(2.0), 2.0)
    steps = run(pad, [0.3, 0.1, 0.7, 0.2])
    assert [m.force[0] for m in steps] == pytest.approx([0.6, 0.2, 1.4, 0.4])
    assert max(abs(m.lost[0]) for m in steps) < 1e-15


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
        ((1.0, HALF, np.nan), "hysteresis_slope: must be finite"),
        ((1.0, HALF, 0.0), "hysteresis_slope: must be above zero"),
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
