"""Combined contact: the intermediate surface against closed forms and balance of stresses."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError, RunError
from contiga.laws.combined import CombinedLaw, forces_in_series
from contiga.laws.normal import ForceLaw, StressLaw
from contiga.records import LawInput

FOAM = [[0, 0], [0.2, 1], [0.6, 1], [0.8, 4]]
PAD = [[0, 0], [0.1, 1], [0.3, 1], [0.5, 9]]


def law_input(depth, rate=0.0, thickness=None) -> LawInput:
    depth = np.asarray(depth, dtype=float)
    rates = np.broadcast_to(np.float64(rate), depth.shape)
    nodal = None if thickness is None else np.broadcast_to(np.float64(thickness), depth.shape)
    return LawInput(depth, rates, np.ones(depth.shape), nodal, None, 0.1)


def test_two_linear_sides_are_springs_in_series() -> None:
    k_s, t_s, k_m, t_m = 3.0, 0.5, 8.0, 2.0
    law = CombinedLaw(StressLaw(k_s, t_s), StressLaw(k_m, t_m))
    depth = np.array([0.0, 0.1, 7.0])
    series = 1.0 / (t_s / k_s + t_m / k_m)
    split = law.split(law_input(depth))
    np.testing.assert_allclose(split.stress, series * depth, rtol=1e-14)
    np.testing.assert_allclose(split.slave, series * depth * t_s / k_s, rtol=1e-14)
    np.testing.assert_allclose(law.respond(law_input(depth)).force, series * depth, rtol=1e-14)


def test_a_far_stiffer_master_gives_the_slave_law_alone() -> None:
    law = CombinedLaw(StressLaw(FOAM, 0.5), StressLaw(1e12, 0.5))
    depth = np.array([0.05, 0.11, 0.35, 0.6])
    # A plateau turns a tiny shift of the strain into none of the stress.
    np.testing.assert_allclose(
        law.respond(law_input(depth)).force,
        StressLaw(FOAM, 0.5).respond(law_input(depth)).force,
        rtol=1e-10,
    )


def test_stresses_balance_through_plateaus_with_nodal_thickness() -> None:
    depth = np.linspace(0.0, 2.0, 801)
    thickness = 0.1 + np.abs(np.sin(np.arange(801)))
    law = CombinedLaw(StressLaw(FOAM), StressLaw(PAD, 0.5))
    split = law.split(law_input(depth, thickness=thickness))
    np.testing.assert_allclose(split.slave + split.master, depth, rtol=1e-14)
    np.testing.assert_allclose(Characteristic(FOAM)(split.slave / thickness), split.stress, 1e-12)
    np.testing.assert_allclose(Characteristic(PAD)(split.master / 0.5), split.stress, rtol=1e-12)


def test_two_equal_plateaus_share_in_proportion_to_their_lengths() -> None:
    law = CombinedLaw(StressLaw(FOAM, 1.0), StressLaw(PAD, 1.0))
    split = law.split(law_input([0.3 + 0.5 * 0.6]))
    np.testing.assert_allclose([split.slave, split.master], [[0.4], [0.2]], rtol=1e-14)


def test_the_bracketed_solution_of_callables_is_that_of_their_table() -> None:
    rising_foam, rising_pad = [[0, 0], [0.2, 1], [0.6, 2], [0.8, 4]], [[0, 0], [0.3, 1], [0.5, 9]]
    depth = np.linspace(0.0, 1.2, 101)
    exact = CombinedLaw(StressLaw(rising_foam, 1.0), StressLaw(rising_pad, 0.4))
    curve = Characteristic(rising_foam)
    result = CombinedLaw(StressLaw(lambda x: curve(x), 1.0), StressLaw(rising_pad, 0.4))
    for a, b in zip(exact.split(law_input(depth)), result.split(law_input(depth)), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-14)


def test_a_cubic_against_a_line_solves_its_equation() -> None:
    law = CombinedLaw(StressLaw(lambda x: x**3, 1.0), StressLaw(2.0, 1.0))
    split = law.split(law_input([1.5, 6.0]))
    np.testing.assert_allclose(split.slave, [1.0, 2.0], rtol=1e-13)
    np.testing.assert_allclose(split.stress, [1.0, 8.0], rtol=1e-13)


def test_a_side_with_a_preload_does_not_move_below_it() -> None:
    table = CombinedLaw(StressLaw([[0, 5], [1, 6]], 1.0), StressLaw(10.0, 1.0))
    function = CombinedLaw(StressLaw(lambda x: 5.0 + x, 1.0), StressLaw(10.0, 1.0))
    for law in (table, function):
        split = law.split(law_input([0.2, 0.5, 0.5 + 0.11]))
        np.testing.assert_allclose(split.slave, [0.0, 0.0, 0.1], atol=1e-14)
        np.testing.assert_allclose(split.stress, [2.0, 5.0, 5.1], rtol=1e-13)


def test_a_side_held_constant_beyond_its_table_caps_the_stress() -> None:
    capped = Characteristic([[0, 0], [1, 4]], extrapolation="constant")
    law = CombinedLaw(StressLaw(capped, 1.0), StressLaw(8.0, 1.0))
    split = law.split(law_input([1.5, 9.0]))
    np.testing.assert_allclose(split.stress, [4.0, 4.0])
    np.testing.assert_allclose(split.master, [0.5, 0.5])


def test_tables_that_may_not_be_left_stop_the_run_beyond_both() -> None:
    short = Characteristic([[0, 0], [1, 4]], extrapolation="error")
    law = CombinedLaw(StressLaw(short, 1.0), StressLaw(8.0, 1.0))
    assert law.respond(law_input([1.5])).force == pytest.approx([4.0])
    with pytest.raises(RunError, match=r"penetration of 1\.6 goes beyond"):
        law.respond(law_input([1.6]))


def test_damping_of_equal_sides_is_that_of_dampers_in_series() -> None:
    side = StressLaw(1.0, 0.5, damping=3.0)
    given = law_input([0.2], rate=2.0)
    without = CombinedLaw(StressLaw(1.0, 0.5), StressLaw(1.0, 0.5)).respond(given).force
    series = 3.0 / 0.5 * 2.0 / 2.0
    np.testing.assert_allclose(CombinedLaw(side, side).respond(given).force - without, [series])


def test_damping_of_one_side_is_kept_and_never_pulls() -> None:
    law = CombinedLaw(StressLaw(1.0, 1.0, damping=4.0), StressLaw(1.0, 1.0))
    np.testing.assert_allclose(
        law.respond(law_input([1.0, 1.0], rate=[1.0, -9.0])).force, [1.5, 0.0]
    )


def test_the_rate_of_touching_points_is_shared_equally() -> None:
    law = CombinedLaw(StressLaw(1.0, 1.0, damping=4.0), StressLaw(9.0, 1.0))
    np.testing.assert_allclose(law.respond(law_input([0.0], rate=1.0)).force, [1.0])


def test_no_points_and_no_depth_give_no_force() -> None:
    for elastic in (2.0, np.square):
        law = CombinedLaw(StressLaw(elastic, 1.0), StressLaw(2.0, 1.0))
        assert law.respond(law_input([])).force.shape == (0,)
        np.testing.assert_array_equal(law.respond(law_input([0.0, 0.0])).force, [0.0, 0.0])


@pytest.mark.parametrize(
    ("slave", "master", "message"),
    [
        (ForceLaw(1.0), StressLaw(1.0, 1.0), "law: .*found 'ForceLaw'; allowed: StressLaw"),
        (StressLaw(1.0, 1.0), ForceLaw(1.0), "master_law: .*'ForceLaw'"),
        (StressLaw(1.0, 1.0), StressLaw(1.0), "master's stress law needs a thickness"),
        (StressLaw([[0, 0], [1, 2], [2, 1]], 1), StressLaw(1.0, 1), "law.elastic: .*not decrease"),
        (StressLaw(-1.0, 1), StressLaw(1.0, 1), "not decrease"),
    ],
)
def test_sides_that_cannot_be_balanced_are_refused(slave, master, message: str) -> None:
    with pytest.raises(InputError, match=message):
        CombinedLaw(slave, master)


def test_a_callable_that_falls_is_refused_when_it_is_used() -> None:
    law = CombinedLaw(StressLaw(np.sin, 1.0), StressLaw(1.0, 1.0))
    law.respond(law_input([1.0]))
    with pytest.raises(InputError, match="falls near"):
        law.respond(law_input([3.0]))


def test_two_force_laws_in_series_carry_one_force() -> None:
    slave, master = [[0, 0], [10, 3], [60, 5]], [[0, 0], [4, 2], [20, 8]]
    both = forces_in_series(ForceLaw(slave), ForceLaw(master))
    for force in (0.0, 1.5, 2.0, 3.0, 4.0, 8.0, 12.0):
        # Each side's way by its own curve, continued straight on.
        depth = sum(
            np.interp(force, f, x) + max(force - f[-1], 0.0) * (x[-1] - x[-2]) / (f[-1] - f[-2])
            for x, f in (np.array(slave).T, np.array(master).T)
        )
        assert both.curve(depth) == pytest.approx(force, rel=1e-12)


def test_a_side_with_a_plateau_is_the_ceiling_of_both() -> None:
    crush = Characteristic([[0, 0], [1, 2]], extrapolation="constant")
    both = forces_in_series(ForceLaw(1.0), ForceLaw(crush))
    assert both.curve([1.5, 3.0, 50.0]) == pytest.approx([1.0, 2.0, 2.0])
    ends = Characteristic([[0, 0], [1, 2]], extrapolation="error")
    with pytest.raises(RunError, match="outside its table"):
        forces_in_series(ForceLaw(ends), ForceLaw(ends)).curve(2.5)


@pytest.mark.parametrize(
    "other",
    [
        ForceLaw(1.0, unloading=0.5, hysteresis_slope=2.0),
        ForceLaw(lambda x: x**2),
        ForceLaw(1.0, share="penetration"),
    ],
)
def test_forces_in_series_without_an_answer_are_refused(other: ForceLaw) -> None:
    with pytest.raises(InputError, match=r"master_law: .*tables without unloading, and one share"):
        forces_in_series(ForceLaw(2.0), other)
