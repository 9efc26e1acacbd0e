"""Affine maps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga import shapes
from contiga.errors import GeometryError
from contiga.rigid import transform


@pytest.mark.parametrize(
    ("axis", "start", "end"), [("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y")]
)
def test_quarter_turns_are_exact_and_right_handed(axis, start, end):
    matrix = transform.rotation(axis, 0.5 * math.pi)
    turned = transform.apply(matrix, transform.unit_axis(start)[None, :])
    np.testing.assert_array_equal(turned[0], transform.unit_axis(end))


def test_rotation_leaves_its_axis_line_and_lengths():
    axis, origin = (1.0, -2.0, 0.5), np.array([3.0, 1.0, -4.0])
    matrix = transform.rotation(axis, 1.234, origin)
    on_line = origin + np.outer([-2.0, 0.0, 7.0], axis)
    np.testing.assert_allclose(transform.apply(matrix, on_line), on_line, rtol=0, atol=1e-14)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-15)


def test_turns_add_up():
    third = transform.rotation((1, 1, 1), 2 * math.pi / 3)
    np.testing.assert_allclose(third[:3, :3], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], rtol=0, atol=1e-15)


def test_scaling_is_about_its_origin():
    surface = shapes.plane().scaled((2.0, 3.0, 1.0), origin=(0.5, 0.5, 0.0))
    np.testing.assert_allclose(
        surface.bounds(), [[-1.5, -2.5, 0], [0.5, 0.5, 0]], rtol=0, atol=1e-15
    )


def test_moves_agree_with_their_matrices():
    surface, uv = shapes.torus(), np.random.default_rng(0).random((9, 2))
    matrix = transform.translation((1, 2, 3)) @ transform.rotation("x", 0.4)
    chained = surface.rotated("x", 0.4).translated((1, 2, 3))
    np.testing.assert_allclose(
        chained.evaluate(uv), surface.transformed(matrix).evaluate(uv), rtol=0, atol=1e-15
    )


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 1e-9, 0), (1, 2, 3)])
def test_frame_is_a_rotation_that_takes_z_to_the_axis(direction):
    matrix = transform.frame(direction, (1, 2, 3))
    np.testing.assert_allclose(matrix[:3, 2], transform.unit_axis(direction), rtol=0, atol=1e-15)
    np.testing.assert_allclose(matrix[:3, :3].T @ matrix[:3, :3], np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.det(matrix[:3, :3]) > 0.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.scaled(0.0), "must be positive"),
        (lambda s: s.scaled((1.0, -1.0, 1.0)), "must be positive"),
        (lambda s: s.translated((1.0, 2.0)), "three finite numbers"),
        (lambda s: s.translated((1.0, 2.0, math.nan)), "three finite numbers"),
        (lambda s: s.rotated("q", 1.0), "not an axis"),
        (lambda s: s.rotated("z", math.inf), "angle must be finite"),
        (lambda s: s.transformed(np.eye(3)), r"\(4, 4\)"),
        (lambda s: s.transformed(np.diag([1.0, 1.0, 0.0, 1.0])), "singular"),
        (lambda s: s.transformed(np.diag([1.0, 1.0, 1.0, 2.0])), "last row"),
    ],
)
def test_moves_that_make_no_sense_are_refused(call, message):
    for thing in (shapes.sphere(), shapes.circle(), shapes.sphere().tessellate(0.2)):
        with pytest.raises(GeometryError, match=message):
            call(thing)
