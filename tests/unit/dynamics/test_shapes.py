"""Control points that follow a table."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

REST = cg.Body([cg.shapes.sphere(radius=1.0)]).net.points
TIMES = [0.0, 1.0, 1.5, 3.0]
TABLE = [REST, 1.2 * REST, REST + 0.1, 0.9 * REST]


def test_rows_are_met_and_shapes_outside_are_held() -> None:
    motion = cg.motion.ControlPoints(TIMES, TABLE)
    for time, points in zip(TIMES, TABLE, strict=True):
        np.testing.assert_allclose(motion.control_points(time), points, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(motion.control_points(-1.0), REST)
    np.testing.assert_array_equal(motion.control_points(9.0), TABLE[-1])
    assert not motion.control_velocity(-1.0).any()
    assert not motion.control_velocity(3.0).any()


def test_velocities_are_derivatives_and_continuous_everywhere() -> None:
    motion, h = cg.motion.ControlPoints(TIMES, TABLE), 1e-6
    for t in (0.2, 0.999, 1.0, 1.3, 2.9):
        central = (motion.control_points(t + h) - motion.control_points(t - h)) / (2.0 * h)
        np.testing.assert_allclose(motion.control_velocity(t), central, rtol=0, atol=1e-8)
    for t in TIMES:
        before, after = (motion.control_velocity(t + s * 1e-9) for s in (-1.0, 1.0))
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-7)


def test_one_row_is_a_shape_that_stays() -> None:
    motion = cg.motion.ControlPoints([1.0], [REST])
    np.testing.assert_array_equal(motion.control_points(2.0), REST)
    assert not motion.control_velocity(1.0).any()


@pytest.mark.parametrize(
    ("times", "points", "told"),
    [
        ([0.0, 0.0], [REST, REST], "the times go back or repeat at row 1"),
        ([0.0, 1.0, 2.0], [REST, REST], "times"),
        ([0.0], [REST[:, :2]], r"control points at each time.*\(k, m, 3\)"),
        ([0.0, 1.0], [REST, REST[:3]], "as many control points at each time"),
        ([0.0], [REST * np.nan], r"points\[0\]: must be finite"),
    ],
)
def test_tables_that_are_none_are_refused(times: object, points: object, told: str) -> None:
    with pytest.raises(InputError, match=told):
        cg.motion.ControlPoints(times, points)
