"""The smooth greatest penetration: bounds, closed forms, and a gradient that is one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.laws.deepest import WIDTH, deepest

# Clusters near the greatest depth, where points share, and others far above.
depths = st.lists(
    st.one_of(st.floats(0.0, 1.0), st.floats(1.0 - 2.0 * WIDTH, 1.0)),
    min_size=1,
    max_size=40,
).map(np.array)


@given(depths, st.floats(1e-100, 1e100))
def test_it_is_between_the_greatest_and_half_a_per_cent_more_in_any_unit(depth, unit) -> None:
    found, most = deepest(depth * unit), float(depth.max()) * unit
    assert most * (1.0 - 1e-14) <= found.depth <= most / (1.0 - WIDTH) * (1.0 + 1e-14)
    assert (found.weight >= 0.0).all()
    assert 1.0 - 1e-12 <= found.weight.sum() <= 1.0 / (1.0 - WIDTH) + 1e-12
    if most > 0.0:  # of degree one (Euler)
        assert found.weight @ (depth * unit) == pytest.approx(found.depth, rel=1e-12)


@pytest.mark.parametrize("n", [1, 2, 30, 100_000])
def test_of_equals_it_is_known_in_closed_form(n) -> None:
    actual = deepest(np.full(n, 3.0))
    assert actual.depth == pytest.approx(3.0 / (1.0 - WIDTH * (1.0 - n**-0.5)), rel=1e-13)
    np.testing.assert_allclose(actual.weight, actual.depth / (3.0 * n), rtol=1e-12)


def test_it_is_the_deepest_point_where_that_is_alone() -> None:
    actual = deepest(np.array([2.0, 5.0, 5.0 * (1.0 - WIDTH), 0.0]))
    assert actual.depth == 5.0
    assert actual.weight.tolist() == [0.0, 1.0, 0.0, 0.0]


def test_of_none_that_are_deep_all_weigh_alike() -> None:
    actual = deepest(np.zeros(4))
    assert actual.depth == 0.0
    assert actual.weight.tolist() == [0.25] * 4


@given(depths, st.integers(0, 39))
def test_weights_are_its_gradient(depth, at) -> None:
    depth, at = np.append(depth, 1.0), at % len(depth)
    step = np.zeros(len(depth))
    step[at] = 1e-7
    up, down = deepest(depth + step), deepest(np.maximum(depth - step, 0.0))
    way = min(depth[at], 1e-7) + 1e-7
    low, high = sorted((down.weight[at], up.weight[at]))
    # Of a convex function: between the slopes at both ends.
    assert low - 1e-7 <= (up.depth - down.depth) / way <= high + 1e-7
    # And no jump: the slope has a slope, less than 1/η.
    assert high - low <= way * 1.1 / WIDTH


@given(depths, st.floats(0.0, 1.0))
def test_a_point_more_never_makes_it_less(depth, more) -> None:
    assert deepest(np.append(depth, more)).depth >= deepest(depth).depth * (1.0 - 1e-14)


CONFIGURATIONS = {
    "alone": [1.0, 0.994, 0.2],
    "two alike": [1.0, 1.0, 0.3],
    "two": [1.0, 0.9952],
    "nearly alone": [1.0, 0.99501],
    "many alike": [3.0] * 30,
    "some": [1.0, 0.999, 0.998, 0.9971, 0.9],
}


@pytest.mark.parametrize("name", CONFIGURATIONS)
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
def test_its_curvature_is_the_steepest_slope_of_the_gradient(name: str, unit: float) -> None:
    depth = unit * np.array(CONFIGURATIONS[name])
    step = 1e-8 * depth.max()
    slopes = [
        (deepest(depth + step * axis).weight - deepest(depth - step * axis).weight) / (2.0 * step)
        for axis in np.eye(len(depth))
    ]
    steepest = np.linalg.eigvalsh(np.array(slopes) * unit).max()
    assert deepest(depth).curvature * unit == pytest.approx(steepest, rel=1e-4, abs=1e-4)
