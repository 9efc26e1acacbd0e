"""Even motions between poses: exact about fixed axes, wherever those are."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.rigid import pose
from contiga.rigid.screw import screw_between

RNG = np.random.default_rng(12)


def _far(size: float) -> np.ndarray:
    turn = pose.rotation(RNG.normal(size=3), RNG.uniform(0.0, 3.0))
    return pose.compose(pose.translation(size * RNG.normal(size=3)), turn)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-4, 0.3, 2.0, np.pi - 1e-6, np.pi])
@pytest.mark.parametrize("size", [1.0, 1e3])
def test_ends_are_met_and_halves_are_equal(angle: float, size: float) -> None:
    for _ in range(20):
        X_WA = _far(size)
        way = pose.translation(RNG.normal(size=3))
        turn = pose.rotation(RNG.normal(size=3), angle, size * RNG.normal(size=3))
        X_WB = pose.compose(X_WA, way, turn)
        screw = screw_between(X_WA, X_WB)
        assert np.linalg.norm(screw.turn) == pytest.approx(angle, abs=1e-14)
        ends = pose.compose(X_WA, screw.pose(0.0)), pose.compose(X_WA, screw.pose(1.0))
        for end, expected in zip(ends, (X_WA, X_WB), strict=True):
            np.testing.assert_allclose(end, expected, rtol=0, atol=2e-13 * size)
        half = screw.pose(0.5)
        np.testing.assert_allclose(
            pose.compose(half, half), screw.pose(1.0), rtol=0, atol=2e-13 * size
        )


def test_a_turn_about_a_fixed_axis_stays_one() -> None:
    axis, centre = [0.3, -0.2, 1.0], [40.0, 3.0, -7.0]
    X_WA, X_WB = (pose.rotation(axis, angle, centre) for angle in (0.4, 1.9))
    screw = screw_between(X_WA, X_WB)
    for s in np.linspace(0.0, 1.0, 11):
        expected = pose.rotation(axis, 0.4 + 1.5 * s, centre)
        np.testing.assert_allclose(pose.compose(X_WA, screw.pose(s)), expected, rtol=0, atol=1e-13)


def test_without_turning_it_is_a_straight_way() -> None:
    screw = screw_between(pose.translation([1.0, 2.0, 3.0]), pose.translation([1.0, 0.0, 4.0]))
    assert screw.turn.tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_array_equal(screw.pose(0.25), pose.translation([0.0, -0.5, 0.25]))


def test_the_field_is_the_speed_at_the_start() -> None:
    screw = screw_between(_far(1.0), _far(1.0))
    points = RNG.normal(size=(5, 3))
    h = 1e-6
    moved = [pose.apply(screw.pose(s), points) for s in (h, -h)]
    np.testing.assert_allclose(
        screw.field(points), (moved[0] - moved[1]) / (2.0 * h), rtol=0, atol=1e-8
    )
