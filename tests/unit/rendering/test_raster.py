"""Pixels drawn against plain geometry."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.rendering.kernels.raster_nb import draw_balls, draw_lines, draw_triangles, empty_buffer

pytestmark = pytest.mark.interpreted
FIRST = np.array([[0, 1, 2]], dtype=np.int32)


def test_triangle_covers_exactly_the_pixels_inside_it() -> None:
    screen = np.array([[2.5, 1.5, 1.0], [17.2, 4.1, 1.0], [6.3, 15.7, 1.0]])
    buffer = empty_buffer(20, 20)
    draw_triangles(screen, FIRST, buffer)
    rows, columns = np.mgrid[0:20, 0:20]
    inside = np.ones((20, 20), dtype=bool)
    for k in range(3):
        p, q = screen[k, :2], screen[(k + 1) % 3, :2]
        inside &= (q[0] - p[0]) * (rows - p[1]) - (q[1] - p[1]) * (columns - p[0]) >= 0.0
    np.testing.assert_array_equal(buffer.owner >= 0, inside)
    assert inside.sum() > 80


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_nearer_triangle_hides_the_farther_in_either_order(order: tuple[int, int]) -> None:
    corners = np.array([[-1.0, -1.0], [30.0, -1.0], [-1.0, 30.0]])
    screen = np.vstack([np.c_[corners, [5.0, 5, 5]], np.c_[corners, [3.0, 3, 3]]])
    triangles = np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32)[list(order)]
    buffer = empty_buffer(8, 8)
    draw_triangles(screen, triangles, buffer)
    np.testing.assert_array_equal(buffer.owner, order.index(1))
    np.testing.assert_allclose(buffer.depth, 3.0, rtol=1e-14)


def test_depth_is_that_of_the_plane() -> None:
    screen = np.array([[0.0, 0.0, 2.0], [40.0, 0.0, 6.0], [0.0, 40.0, 10.0]])
    buffer = empty_buffer(10, 10)
    draw_triangles(screen, FIRST, buffer)
    rows, columns = np.mgrid[0:10, 0:10]
    inverse = 1 / 2 + columns / 40 * (1 / 6 - 1 / 2) + rows / 40 * (1 / 10 - 1 / 2)
    np.testing.assert_allclose(1.0 / buffer.depth, inverse, rtol=1e-13)


def test_points_that_are_not_finite_draw_nothing() -> None:
    screen = np.array([[np.nan, 1.0, 1.0], [5.0, np.inf, 1.0], [1.0, 5.0, np.nan]])
    buffer = empty_buffer(8, 8)
    draw_triangles(screen, FIRST, buffer)
    draw_balls(screen, 2.0, 1.0, buffer)
    assert (buffer.owner < 0).all()


def test_ball_is_a_disc_bulging_to_the_eye() -> None:
    buffer = empty_buffer(21, 21)
    draw_balls(np.array([[10.0, 10.0, 50.0]]), 6.0, 0.5, buffer)
    rows, columns = np.mgrid[0:21, 0:21]
    distance = np.hypot(rows - 10.0, columns - 10.0)
    np.testing.assert_array_equal(buffer.owner >= 0, distance <= 6.0)
    assert buffer.depth[10, 10] == 50.0 - 0.5 * 6.0


def test_line_is_hidden_by_what_is_nearer_only() -> None:
    screen = np.array([[0.0, 4.0, 2.0], [9.0, 4.0, 2.0]])
    depth = np.full((9, 10), np.inf)
    depth[:, :5] = 1.0
    ink = np.zeros((9, 10), dtype=bool)
    draw_lines(screen, np.array([[0, 1]], dtype=np.int32), depth, 0.1, ink)
    assert ink[4].tolist() == [False] * 5 + [True] * 5
    assert ink.sum() == 5
