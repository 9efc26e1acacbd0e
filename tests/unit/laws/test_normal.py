"""Force laws against their formulas worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.laws.normal import AdaptiveLaw, ForceLaw, PenaltyLaw, StressLaw
from contiga.laws.share import share
from contiga.records import LawInput


def law_input(penetration, rate=0.0, area=1.0, thickness=None, mass=None, dt=0.1) -> LawInput:
    """A `LawInput` with scalars spread over all points."""
    depth = np.asarray(penetration, dtype=float)

    def spread(value):
        return None if value is None else np.broadcast_to(np.float64(value), depth.shape).copy()

    return LawInput(depth, spread(rate), spread(area), spread(thickness), spread(mass), dt)


def test_force_law_gives_the_curve_at_the_greatest_penetration() -> None:
    force = ForceLaw([[0, 0], [1, 0.5]]).respond(law_input([0.1, 0.4, 0.2], area=0.1)).force
    np.testing.assert_allclose(force, [0.0, 0.2, 0.0], rtol=1e-15)


def test_force_law_of_the_thesis_shares_the_curve_by_penetration() -> None:
    law = ForceLaw([[0, 0], [1, 0.5]], share="penetration")
    force = law.respond(law_input([0.1, 0.4, 0.2], area=0.1)).force
    assert force.sum() == pytest.approx(0.2, rel=1e-15)
    np.testing.assert_allclose(force, 0.2 * np.array([1, 4, 2]) / 7, rtol=1e-15)


def test_force_law_weighs_by_area() -> None:
    force = ForceLaw(6.0, share="penetration").respond(law_input([1.0, 1.0], area=[1.0, 2.0])).force
    np.testing.assert_allclose(force, [2.0, 4.0], rtol=1e-15)


def test_force_law_total_depends_neither_on_number_nor_area() -> None:
    for law, close in ((ForceLaw(3.0, share="penetration"), 1e-15), (ForceLaw(3.0), 0.0101)):
        for n in (1, 7, 100):
            force = law.respond(law_input(np.full(n, 0.5), area=1 / n)).force
            assert force.sum() == pytest.approx(1.5, rel=close)


@pytest.mark.parametrize(
    "law", [ForceLaw(1.0), StressLaw(1.0, 0.1), PenaltyLaw(1.0), AdaptiveLaw()]
)
def test_no_points_in_contact_give_no_forces(law) -> None:
    assert law.respond(law_input(np.zeros(0), thickness=1.0, mass=1.0)).force.shape == (0,)


def test_one_point_gets_all() -> None:
    assert ForceLaw(2.0).respond(law_input([0.25], area=1e-9)).force == pytest.approx([0.5])


def test_touching_points_feel_nothing_from_a_curve_through_the_origin() -> None:
    np.testing.assert_array_equal(ForceLaw(5.0).respond(law_input([0.0, 0.0])).force, [0.0, 0.0])


def test_a_preload_on_touching_points_is_shared_by_area() -> None:
    law = ForceLaw([[0, 8.0], [1, 9.0]], share="penetration")
    np.testing.assert_allclose(
        law.respond(law_input([0.0, 0.0], area=[1.0, 3.0])).force, [2.0, 6.0]
    )


@pytest.mark.parametrize(
    ("depth", "area", "expected"),
    [
        ([1.0, 3.0], [0.0, 0.0], [1.0, 3.0]),
        ([0.0, 0.0], [0.0, 0.0], [2.0, 2.0]),
        ([0.0, 2.0], [1.0, 0.0], [0.0, 4.0]),
    ],
)
def test_the_share_is_defined_where_no_point_has_depth_and_area(depth, area, expected) -> None:
    np.testing.assert_allclose(share(4.0, np.array(depth), np.array(area)), expected)


def test_the_share_survives_numbers_whose_product_underflows() -> None:
    tiny = np.array([1e-200, 3e-200])
    np.testing.assert_allclose(share(4.0, tiny, tiny[::-1]), [2.0, 2.0], rtol=1e-14)


def test_a_falling_curve_never_pulls() -> None:
    law = ForceLaw([[0, 0], [1, 1], [2, 0]])
    assert law.respond(law_input([3.0])).force == [0.0]
    assert StressLaw([[0.5, 0], [1, 1]], 1.0).respond(law_input([0.1])).force == [0.0]


def test_stress_law_is_equation_3_4() -> None:
    law = StressLaw(
        [[0, 0], [1, 10]],
        0.1,
        damping=0.2,
        damping_curve=[[-1, -3], [1, 3]],
        amplification=[[0, 1], [10, 2]],
    )
    depth, rate, area = 0.05, 0.02, 0.3
    elastic = 10 * depth / 0.1
    expected = area * (elastic + (0.2 * rate / 0.1 + 3 * rate / 0.1) * (1 + elastic / 10))
    force = law.respond(law_input([depth], rate=rate, area=area)).force
    assert force == pytest.approx([expected], rel=1e-14)


def test_stress_law_takes_the_nodes_own_thickness_where_it_has_none() -> None:
    law = StressLaw(2.0)
    assert law.needs_thickness
    force = law.respond(law_input([1.0, 1.0], thickness=[0.5, 4.0], area=3.0)).force
    np.testing.assert_allclose(force, [12.0, 1.5])


def test_damping_does_not_pull_while_a_contact_opens() -> None:
    law = StressLaw(1.0, 1.0, damping=5.0)
    np.testing.assert_allclose(
        law.respond(law_input([0.5, 0.5], rate=[-1.0, -0.05])).force, [0.0, 0.25]
    )


def test_stress_law_without_any_thickness_says_what_to_do() -> None:
    with pytest.raises(InputError, match=r"no thickness.*Give StressLaw a thickness"):
        StressLaw(1.0).respond(law_input([1.0]))
    with pytest.raises(InputError, match=r"1 points .* no thickness; found 0\.0"):
        StressLaw(1.0).respond(law_input([1.0, 1.0], thickness=[0.0, 1.0]))


def test_penalty_is_a_spring_and_a_damper_on_each_point() -> None:
    given = law_input([0.1, 0.2], rate=[1.0, -1.0], area=0.5)
    np.testing.assert_allclose(PenaltyLaw(100.0, damping=30.0).respond(given).force, [40.0, 0.0])
    np.testing.assert_allclose(PenaltyLaw(100.0, per_area=True).respond(given).force, [5.0, 10.0])


def test_adaptive_stiffness_is_scale_mass_over_step_squared() -> None:
    force = AdaptiveLaw(0.2).respond(law_input([0.5, 0.5], mass=[1.0, 3.0], dt=0.1)).force
    np.testing.assert_allclose(force, [10.0, 30.0])


def test_an_adaptive_spring_stays_stable_up_to_scale_four() -> None:
    def farthest(scale: float) -> float:
        law, dt, x, v, far = AdaptiveLaw(scale), 0.1, -1.0, 0.0, 1.0
        for _ in range(400):
            force = np.sign(-x) * law.respond(law_input([abs(x)], mass=2.0, dt=dt)).force[0]
            v += force / 2.0 * dt
            x += v * dt
            far = max(far, abs(x))
        return far

    assert farthest(3.9) < 50.0
    assert farthest(4.1) > 1e6


def test_adaptive_gives_no_force_at_the_start_and_refuses_a_slave_without_mass() -> None:
    np.testing.assert_array_equal(
        AdaptiveLaw().respond(law_input([1.0], mass=1.0, dt=0.0)).force, [0.0]
    )
    with pytest.raises(InputError, match="needs nodal masses"):
        AdaptiveLaw().respond(law_input([1.0]))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: StressLaw(1.0, 0.0), "thickness: must be positive; found 0.0"),
        (lambda: StressLaw(1.0, -1.0), "thickness: must be positive"),
        (lambda: StressLaw(1.0, np.nan), "thickness: must be positive"),
        (lambda: StressLaw(1.0, "thick"), "thickness: must be a number"),
        (lambda: StressLaw(1.0, 1.0, damping=-1), "damping: must not be negative"),
        (lambda: StressLaw([[1, 0], [0, 1]], 1.0), "elastic: the values of x go back"),
        (lambda: StressLaw(1.0, 1.0, damping_curve=[[0, 0]]), "damping_curve: .*at least 2 rows"),
        (lambda: StressLaw(1.0, 1.0, amplification=[[0, 0]]), "amplification: .*at least 2 rows"),
        (lambda: PenaltyLaw(0.0), "stiffness: must be positive"),
        (lambda: AdaptiveLaw(-0.1), "scale: must be positive"),
    ],
)
def test_a_wrong_option_is_refused_by_name(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
