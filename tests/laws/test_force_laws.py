"""Properties of the force laws, for any input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.curves.characteristic import Characteristic
from contiga.laws.combined import CombinedLaw
from contiga.laws.normal import AdaptiveLaw, ForceLaw, Law, PenaltyLaw, StressLaw
from contiga.laws.share import share
from contiga.records import LawInput

positive = st.floats(1e-6, 1e6)
depths = st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30).map(np.array)


@st.composite
def rising_tables(draw) -> list[list[float]]:
    n = draw(st.integers(2, 6))
    steps = draw(st.lists(st.floats(0.01, 2.0), min_size=n - 1, max_size=n - 1))
    rises = draw(st.lists(st.sampled_from([0.0, 0.5, 3.0, 40.0]), min_size=n - 1, max_size=n - 1))
    x, y = np.append(0.0, np.cumsum(steps)), np.append(0.0, np.cumsum(rises))
    return np.column_stack([x, y]).tolist()


def law_input(depth, area, rate=None) -> LawInput:
    rate = np.zeros(depth.shape) if rate is None else rate
    return LawInput(depth, rate, area, None, None, 0.1)


@given(depths, st.integers(0, 2**32 - 1), positive)
def test_the_shares_add_up_to_the_total(depth, seed, total) -> None:
    area = np.random.default_rng(seed).random(depth.size)
    forces = share(total, depth, area)
    assert (forces >= 0.0).all()
    np.testing.assert_allclose(forces.sum(), total, rtol=1e-13)


@given(depths, st.integers(0, 2**32 - 1))
def test_the_order_of_the_points_does_not_matter(depth, seed) -> None:
    rng = np.random.default_rng(seed)
    area, order = rng.random(depth.size) + 0.1, rng.permutation(depth.size)
    for law in (ForceLaw(2.0), StressLaw(2.0, 0.3), PenaltyLaw(2.0)):
        mixed = law.respond(law_input(depth[order], area[order])).force
        np.testing.assert_allclose(
            mixed, law.respond(law_input(depth, area)).force[order], rtol=1e-12
        )


@given(depths, st.floats(-1e3, 1e3), st.floats(0.0, 10.0))
def test_no_law_ever_pulls(depth, speed, damping) -> None:
    rate, area = np.full(depth.size, speed), np.ones(depth.size)
    side = StressLaw([[0, 0], [1, 5], [2, 1]], 0.7, damping=damping)
    rising = StressLaw(3.0, 0.2, damping=damping)
    for law in (ForceLaw([[0, 0], [1, 1], [2, 0]]), side, CombinedLaw(rising, rising)):
        assert (law.respond(law_input(depth, area, rate)).force >= 0.0).all()


@settings(deadline=None)
@given(rising_tables(), rising_tables(), depths, st.floats(0.05, 5.0), st.floats(0.05, 5.0))
def test_combined_contact_balances_both_stresses(slave, master, depth, t_s, t_m) -> None:
    law = CombinedLaw(StressLaw(slave, t_s), StressLaw(master, t_m))
    split = law.split(law_input(depth, np.ones(depth.size)))
    scale = 1e-11 * (1.0 + split.stress)
    np.testing.assert_allclose(split.slave + split.master, depth, rtol=1e-12, atol=1e-300)
    # A side's stress is known as well as its strain: within a rounding of the strain.
    for curve, part, t in ((slave, split.slave, t_s), (master, split.master, t_m)):
        error = np.abs(Characteristic(curve)(part / t) - split.stress)
        assert (error <= scale + 4000.0 * 1e-12 * part / t).all()


@settings(deadline=None)
@given(rising_tables(), rising_tables(), st.floats(0.05, 5.0))
def test_combined_contact_is_softer_than_either_side_and_rises(slave, master, t) -> None:
    depth = np.linspace(0.0, 4.0, 50)
    given_depth = law_input(depth, np.ones(50))
    force = CombinedLaw(StressLaw(slave, t), StressLaw(master, 1.0)).respond(given_depth).force
    alone = [
        StressLaw(slave, t).respond(given_depth).force,
        StressLaw(master, 1.0).respond(given_depth).force,
    ]
    assert (np.diff(force) >= -1e-10 * (1.0 + force[:-1])).all()
    assert (force <= np.minimum(*alone) * (1.0 + 1e-10) + 1e-10).all()


@settings(deadline=None)
@given(rising_tables(), rising_tables(), depths)
def test_swapping_the_sides_swaps_the_split(slave, master, depth) -> None:
    a = CombinedLaw(StressLaw(slave, 1.0), StressLaw(master, 2.0))
    b = CombinedLaw(StressLaw(master, 2.0), StressLaw(slave, 1.0))
    points = law_input(depth, np.ones(depth.size))
    np.testing.assert_allclose(a.split(points).slave, b.split(points).master, 1e-10, 1e-12)


SMOOTH = {
    "force": ForceLaw(lambda x: 5.0 * x**2),
    "stress": StressLaw([[0, 0], [0.4, 1], [0.8, 6]], 0.7),
    "stress of a function": StressLaw(lambda x: x**1.5, 2.0),
    "penalty": PenaltyLaw(30.0),
    "penalty by area": PenaltyLaw(30.0, per_area=True),
    "adaptive": AdaptiveLaw(0.2),
    "combined": CombinedLaw(
        StressLaw([[0, 0], [0.1, 1], [0.5, 1.5]], 0.6), StressLaw([[0, 0], [0.2, 1.2], [1, 9]], 0.9)
    ),
    "combined functions": CombinedLaw(
        StressLaw(lambda x: x**2, 0.6), StressLaw(lambda x: 3.0 * x, 0.9)
    ),
}


@pytest.mark.parametrize("law", SMOOTH.values(), ids=SMOOTH)
@given(depth=st.floats(0.02, 0.9), area=st.floats(0.1, 3.0))
def test_without_damping_the_force_is_the_slope_of_the_energy_and_the_stiffness_its_own(
    law: Law, depth: float, area: float
) -> None:
    """By differences over a short way that holds no kink of a table, or little of one."""
    step = 1e-5

    def at(x: float) -> tuple[float, float, float]:
        one = np.ones(1)
        inp = LawInput(x * one, 0.0 * one, area * one, None, 2.0 * one, 0.1)
        out = law.respond(inp)
        return float(out.force[0]), float(out.stiffness[0]), float(out.stored[0])

    (low, _, before), (force, soft, _), (high, stiff, after) = (
        at(depth + k * step) for k in (-1, 0, 1)
    )
    assert (after - before) / (2 * step) == pytest.approx(force, rel=2e-4, abs=1e-9)
    bounds = sorted([soft, stiff, at(depth - step)[1]])
    slope = (high - low) / (2 * step)
    assert bounds[0] * (1 - 1e-3) - 1e-6 <= slope <= bounds[2] * (1 + 1e-3) + 1e-6
