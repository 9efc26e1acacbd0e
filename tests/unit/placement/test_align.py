"""Boxes meet and principal axes lie where they are asked to."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg
from contiga.placement.sample import extent

TORUS = cg.Body(cg.shapes.torus(major=3.0, minor=1.0))
CORNERS = cg.Slave(
    [[1.0, 2.0, 3.0], [5.0, 10.0, 4.0], [90.0, 0.0, 0.0]], active=[True, True, False]
)


def test_the_box_of_a_body_is_exact_where_its_control_points_are_not() -> None:
    turned = cg.Body(cg.shapes.ellipsoid(axes=[1.0, 2.0, 3.0])).rotated([1.0, 1.0, 0.3], 0.7)
    box, R = extent(turned), _rotation([1.0, 1.0, 0.3], 0.7)
    reach = np.sqrt(np.square(R * [1.0, 2.0, 3.0]).sum(axis=1))
    np.testing.assert_allclose(box, [-reach, reach], rtol=0, atol=1e-9)
    assert np.abs(turned.patches[0].bounds() - box).max() > 0.1


def _rotation(axis: list[float], angle: float) -> np.ndarray:
    return Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix()


def test_centres_lows_and_highs_meet() -> None:
    box = extent(cg.align(TORUS, to=CORNERS, centres="x", lows="y", highs="z"))
    np.testing.assert_allclose(box, [[-1.0, 2.0, 2.0], [7.0, 10.0, 4.0]], rtol=0, atol=1e-9)


def test_without_another_the_origin_counts() -> None:
    moved = cg.align(CORNERS, centres=["x", "y"], lows=["z"])
    np.testing.assert_allclose(moved.points[:2], [[-2, -4, 0], [2, 4, 1]], rtol=0, atol=1e-12)


@pytest.mark.parametrize("open_part", [False, True])
def test_principal_axes_of_a_body_lie_along_the_axes(open_part: bool) -> None:
    shape = cg.shapes.ellipsoid(axes=[1.0, 2.0, 3.0])
    if open_part:
        shape = cg.shapes.plane(width=2.0, length=5.0)
    body = cg.Body(shape).rotated([0.3, -1.0, 0.5], 1.1).translated([7.0, 8.0, 9.0])
    box = extent(cg.align(body, axes="principal"))
    half = [2.5, 1.0, 0.0] if open_part else [3.0, 2.0, 1.0]
    np.testing.assert_allclose(box.mean(axis=0), [7.0, 8.0, 9.0], atol=1e-8)
    np.testing.assert_allclose(np.ptp(box, axis=0), 2.0 * np.array(half), atol=1e-7)


def test_principal_axes_of_points() -> None:
    R = _rotation([1.0, 2.0, 3.0], 0.4)
    points = np.array([[x, y, z] for x in (-3, 3) for y in (-2, 2) for z in (-1, 1)], float)
    laid = cg.align(cg.Slave(points @ R.T), axes="principal").points
    np.testing.assert_allclose(np.abs(laid), np.abs(points), atol=1e-12)


def test_the_turn_is_the_smallest_and_a_ball_is_not_turned() -> None:
    rod = cg.Body(cg.shapes.cylinder(radius=1.0, height=9.0)).rotated("y", np.pi / 2 + 0.1)
    points = cg.align(rod, axes="principal").patches[0].control_points
    np.testing.assert_allclose(points, rod.rotated("y", -0.1).patches[0].control_points, atol=1e-9)
    ball = cg.Body(cg.shapes.sphere(radius=2.0)).rotated([1.0, 2.0, 2.0], 0.3)
    same = cg.align(ball, axes="principal").patches[0].control_points
    np.testing.assert_array_equal(same, ball.patches[0].control_points)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, "says nothing to align"),
        ({"centres": "w"}, "centres: not an axis"),
        ({"centres": "x", "lows": "x"}, "lows: an axis is aligned twice"),
        ({"axes": "main"}, "axes: unknown axes"),
        ({"to": 3, "lows": "z"}, "to: must be a body or a slave"),
    ],
)
def test_wrong_input_is_refused(wrong: dict, said: str) -> None:
    with pytest.raises(cg.errors.InputError, match=said):
        cg.align(TORUS, **wrong)
