"""Trim tables: exact classification, boxes, loops that do not close."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

from contiga.arrays.codes import CUT, IN, OUT
from contiga.errors import GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.geometry.kernels import trim_area_nb
from contiga.geometry.kernels import trim_build_nb as build_nb
from contiga.geometry.kernels import trim_nb as nb
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import loop_pieces
from contiga.geometry.trim_area import patch_areas
from contiga.masters.body import Body


def plate(width: float = 1.0, height: float = 1.0, at: tuple[float, float] = (0.0, 0.0)):
    """A flat patch whose (u, v) are its (x, y)."""
    (a, b), (c, d) = at, (at[0] + width, at[1] + height)
    net = [[[a, b, 0], [a, d, 0]], [[c, b, 0], [c, d, 0]]]
    return NurbsSurface((1, 1), ([a, a, c, c], [b, b, d, d]), net)


def circle(x: float, y: float, radius: float, turn: float = 0.0) -> tuple[NurbsCurve, ...]:
    angle = turn + np.arange(9) * math.pi / 4
    stretch = np.where(np.arange(9) % 2, math.sqrt(2.0), 1.0)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (radius * stretch)[:, None]
    knots = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]) / 4
    return (NurbsCurve(2, knots, points + np.array([x, y]), 1.0 / stretch),)


def polygon(*corners: tuple[float, float]) -> tuple[NurbsCurve, ...]:
    p = np.array(corners, dtype=float)
    return tuple(NurbsCurve(1, [0, 0, 1, 1], p[[i, (i + 1) % len(p)]]) for i in range(len(p)))


def annulus(turn: float = 0.0) -> Body:
    return Body(plate(4, 4), trims=[[circle(2, 2, 1.5, turn), circle(2, 2, 0.5, turn)]])


def in_annulus(uv: np.ndarray, slack: float = 0.0) -> np.ndarray:
    r = np.hypot(uv[:, 0] - 2, uv[:, 1] - 2)
    return (r <= 1.5 + slack) & (r >= 0.5 - slack)


@pytest.mark.parametrize("turn", [0.0, 0.1, math.pi / 4, 1.0])
def test_annulus_is_classified_without_a_miss(turn):
    tables = annulus(turn).trim_tables
    uv = 4.0 * np.random.default_rng(0).random((50_000, 2))
    assert np.array_equal(nb.points_in_trim(tables, 0, uv), in_annulus(uv))


@pytest.mark.parametrize("turn", [0.0, 0.1, math.pi / 4])
@pytest.mark.parametrize("away", [1e-10, 1e-7])
def test_points_close_to_a_trim_fall_on_their_side(turn, away):
    tables = annulus(turn).trim_tables
    angle = np.random.default_rng(1).random(20_000) * 2 * math.pi
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert nb.points_in_trim(tables, 0, 2 + (1.5 - away) * ring).all()
    assert not nb.points_in_trim(tables, 0, 2 + (1.5 + away) * ring).any()
    assert nb.points_in_trim(tables, 0, 2 + (0.5 + away) * ring).all()
    assert not nb.points_in_trim(tables, 0, 2 + (0.5 - away) * ring).any()


def test_points_on_a_trim_are_inside():
    tables = annulus(0.3).trim_tables
    angle = np.random.default_rng(2).random(20_000) * 2 * math.pi
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert nb.points_in_trim(tables, 0, 2 + 1.5 * ring).all()
    assert nb.points_in_trim(tables, 0, 2 + 0.5 * ring).all()


def test_rays_through_corners_turning_points_and_level_sides_count_right():
    # Levels are those of corners, of turning points and of whole sides of the loops.
    star = polygon((0, 0), (2, 0), (2, 1), (3, 1), (3, 0), (4, 0), (4, 4), (2, 2), (0, 4))
    tables = Body(plate(4, 4), trims=[[star]]).trim_tables
    levels = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5])
    x, y = np.meshgrid(np.linspace(0.01, 3.99, 200), levels)
    uv = np.stack([x.ravel(), y.ravel()], axis=1)
    u, v = uv.T
    notch = (u > 2) & (u < 3) & (v < 1)
    valley = v > np.abs(u - 2) + 2
    on = np.isclose(v, 1) & (u > 2) & (u < 3)
    expected = ~(notch & ~on) & ~valley
    assert np.array_equal(nb.points_in_trim(tables, 0, uv), expected)
    ring = annulus().trim_tables
    uv = np.array([[a, b] for b in (0.5, 1.5, 2.0, 2.5, 3.5) for a in np.linspace(0, 4, 401)])
    assert np.array_equal(nb.points_in_trim(ring, 0, uv), in_annulus(uv, 1e-13))


@pytest.mark.interpreted
def test_the_border_of_any_domain_is_out_beside_the_corner_that_touches_it():
    rng = np.random.default_rng(11)
    for _ in range(60):
        patch = plate(*rng.uniform(0.3, 15.0, 2), at=tuple(rng.uniform(-3.0, 3.0, 2)))
        (u0, u1), (v0, v1) = patch.domain
        width, height = u1 - u0, v1 - v0
        # A rectangle turned a little: its corners touch the four borders.
        turn = rng.uniform(0.05, 0.25)
        top, bottom = u0 + turn * width, u1 - turn * width
        left, right = v0 + 0.02 * height, v1 - 0.02 * height
        tilted = polygon((u0, left), (bottom, v0), (u1, right), (top, v1))
        tables = Body([patch], trims=[[tilted]]).trim_tables
        share = np.linspace(0.0, 0.95, 7)
        above = np.column_stack([u0 + share * (top - u0), np.full(7, v1)])
        below = np.column_stack([u1 - share * (u1 - bottom), np.full(7, v0)])
        assert not nb.points_in_trim(tables, 0, above).any()
        assert not nb.points_in_trim(tables, 0, below).any()
        assert nb.point_in_trim(tables, 0, top, v1) == IN


def test_arc_that_turns_exactly_in_its_middle_is_split_there():
    # One quadratic from (0, 1) to (0, −1) through (1, 0): u turns at t = ½ to the bit.
    bow = NurbsCurve(2, [0, 0, 0, 1, 1, 1], [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0]])
    back = NurbsCurve(1, [0, 0, 1, 1], [[0.0, -1.0], [0.0, 1.0]])
    body = Body(plate(2, 2, at=(-1.0, -1.0)), trims=[[(bow, back)]])
    tables = body.trim_tables
    assert len(tables.piece_degree) == 3
    uv = np.random.default_rng(0).uniform(-1, 1, (20_000, 2))
    # The parabola u = (1 − v²) / 2.
    expected = (uv[:, 0] >= 0) & (uv[:, 0] <= 0.5 * (1 - uv[:, 1] ** 2))
    assert np.array_equal(nb.points_in_trim(tables, 0, uv), expected)
    assert body.area() == pytest.approx(2.0 / 3.0, rel=1e-13)


@pytest.mark.parametrize("degree", [3, 7, 15])
@pytest.mark.parametrize("rational", [False, True])
def test_grid_agrees_with_every_piece_tested_on_wild_loops(degree, rational):
    rng = np.random.default_rng(degree)
    for _ in range(4):
        points = rng.random((degree + 1, 2))
        weights = rng.uniform(0.2, 5.0, degree + 1) if rational else None
        knots = np.repeat([0.0, 1.0], degree + 1)
        wild = NurbsCurve(degree, knots, points, weights)
        back = NurbsCurve(1, [0, 0, 1, 1], points[[-1, 0]])
        tables = Body(plate(), trims=[[(wild, back)]]).trim_tables
        uv = rng.random((3000, 2))
        plain = [plain_point_in_trim(tables, 0, *row) == 1 for row in uv]
        assert np.array_equal(nb.points_in_trim(tables, 0, uv), plain)
        line = wild.evaluate(np.linspace(0, 1, 4001))[:, :2]
        assert np.array_equal(plain, winding_parity(np.vstack([line, line[:1]]), uv))


@njit
def plain_point_in_trim(tables, patch, u, v):
    """The rival without a grid: every piece of the patch against the ray (no on-curve rule)."""
    parity = 0
    for p in range(tables.patch_start[patch], tables.patch_start[patch + 1]):
        if nb._crosses_right(tables, p, u, v):
            parity ^= 1
    return parity


def winding_parity(line: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Even-odd rule on a fine polygon, which misses its curve by less than any point does here."""
    a, b = line[:-1], line[1:]
    inside = np.empty(len(uv), dtype=bool)
    for i, (u, v) in enumerate(uv):
        counted = (a[:, 1] <= v) != (b[:, 1] <= v)
        share = (v - a[counted, 1]) / (b[counted, 1] - a[counted, 1])
        inside[i] = np.count_nonzero(a[counted, 0] + share * (b - a)[counted, 0] > u) % 2
    return inside


def test_a_thousand_holes_are_classified_and_subtracted():
    n, radius = 32, 0.3
    holes = [circle(i + 0.5, j + 0.5, radius, 0.1) for i in range(n) for j in range(n)]
    frame = polygon((0, 0), (n, 0), (n, n), (0, n))
    body = Body(plate(n, n), trims=[[frame, *holes]])
    tables = body.trim_tables
    uv = n * np.random.default_rng(0).random((50_000, 2))
    outside = np.hypot(*(uv % 1.0 - 0.5).T) > radius
    assert np.array_equal(nb.points_in_trim(tables, 0, uv), outside)
    assert body.area() == pytest.approx(n * n * (1.0 - math.pi * radius**2), rel=1e-12)


def test_boxes_that_are_in_or_out_hold_no_point_of_the_other_side():
    tables = annulus(0.2).trim_tables
    rng = np.random.default_rng(3)
    counts = {IN: 0, OUT: 0, CUT: 0}
    for _ in range(1500):
        centre, half = 4 * rng.random(2), 10.0 ** rng.uniform(-3, -0.2, 2)
        low, high = np.maximum(centre - half, 0), np.minimum(centre + half, 4)
        state = nb.box_state(tables, 0, low[0], high[0], low[1], high[1])
        counts[state] += 1
        inside = nb.points_in_trim(tables, 0, low + rng.random((100, 2)) * (high - low))
        if state != CUT:
            assert inside.all() if state == IN else not inside.any()
    assert min(counts.values()) > 200


@pytest.mark.interpreted
def test_boxes_that_a_trim_crosses_by_a_hair_are_cut_and_others_are_not():
    tables = Body(plate(4, 4), trims=[[circle(2, 2, 1.0)]]).trim_tables
    assert nb.box_state(tables, 0, 3.0 - 1e-9, 3.5, 1.9, 2.1) == CUT
    assert nb.box_state(tables, 0, 3.0 + 1e-9, 3.5, 1.9, 2.1) == OUT
    assert nb.box_state(tables, 0, 1.5, 2.5, 1.5, 2.5) == IN
    # The chord's box of this corner is clear of the arc although its own box is not.
    assert nb.box_state(tables, 0, 2.0, 2.0 + 0.70, 2.0, 2.0 + 0.70) == IN
    assert nb.box_state(tables, 0, 2.0, 2.0 + 0.71, 2.0, 2.0 + 0.71) == CUT


@pytest.mark.interpreted
def test_untrimmed_patches_are_inside_everywhere_beside_trimmed_ones():
    body = Body([plate(), plate(4, 4)], trims=[None, [circle(2, 2, 1.0)]])
    tables = body.trim_tables
    assert nb.point_in_trim(tables, 0, 0.3, 0.3) == 1
    assert nb.box_state(tables, 0, 0.0, 1.0, 0.0, 1.0) == IN
    assert nb.point_in_trim(tables, 1, 2.0, 2.0) == 1
    assert nb.point_in_trim(tables, 1, 0.1, 0.1) == 0
    boxes = np.array([[0.0, 1.0, 0.0, 1.0], [1.9, 2.1, 1.9, 2.1], [0.0, 0.1, 0.0, 0.1]])
    patches = np.array([0, 1, 1], dtype=np.int32)
    wider = boxes + np.array([0.0, 1.5, 0.0, 1.5])
    assert nb.box_states(tables, patches, boxes).tolist() == [IN, IN, OUT]
    assert nb.box_states(tables, patches, wider).tolist() == [IN, CUT, CUT]


def test_direction_and_order_of_loops_do_not_matter():
    outer, inner = circle(2, 2, 1.5), circle(2, 2, 0.5)
    turned = tuple(curve.reversed() for curve in outer)
    uv = 4.0 * np.random.default_rng(0).random((2000, 2))
    for loops in ([outer, inner], [inner, outer], [turned, inner], [inner, turned]):
        body = Body(plate(4, 4), trims=[loops])
        assert np.array_equal(nb.points_in_trim(body.trim_tables, 0, uv), in_annulus(uv))
        assert body.area() == pytest.approx(2 * math.pi, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_size_and_place_of_the_parameters_do_not_matter(scale):
    at = (1e3 * scale, -2e3 * scale)
    loop = circle(at[0] + 2 * scale, at[1] + 2 * scale, scale, 0.3)
    body = Body(plate(4 * scale, 4 * scale, at), trims=[[loop]])
    uv = np.random.default_rng(0).random((5000, 2)) * 4
    inside = np.hypot(uv[:, 0] - 2, uv[:, 1] - 2) <= 1.0
    actual = nb.points_in_trim(body.trim_tables, 0, uv * scale + at)
    assert np.array_equal(actual, inside)
    assert body.area() == pytest.approx(math.pi * scale**2, rel=1e-9)


@pytest.mark.interpreted
def test_small_gaps_are_closed_straight_and_large_ones_are_errors():
    corners = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]
    sides = list(polygon(*corners))
    sides[0] = NurbsCurve(1, [0, 0, 1, 1], [(0.2, 0.2), (0.8 - 5e-4, 0.2)])
    body = Body(plate(), trims=[[sides]])
    assert len(body.trim_tables.piece_degree) == 5
    assert body.area() == pytest.approx(0.36, rel=1e-12)
    sides[0] = NurbsCurve(1, [0, 0, 1, 1], [(0.2, 0.2), (0.7, 0.2)])
    with pytest.raises(GeometryError, match=r"patch 0, loop 0, after p-curve 0.*head to tail"):
        Body(plate(), trims=[[sides]])


@pytest.mark.parametrize("outside", [1e-6, 1e-3, 5e-3])
def test_what_a_loop_reaches_over_the_rectangle_is_cut_off(outside):
    low, high = -outside, 1.0 + outside
    outer = polygon((low, low), (high, low), (high, high), (low, high))
    body = Body(plate(), trims=[[outer, circle(0.5, 0.5, 0.2)]])
    assert body.area() == pytest.approx(1.0 - math.pi * 0.04, rel=1e-9)
    sides = [
        trim_area_nb.side_of_loop(body.trim_tables, pieces)
        for pieces in loop_pieces(body.trim_tables, 0)
    ]
    assert sides == [1, -1]


@pytest.mark.parametrize("turns", range(4))
def test_a_face_lies_on_one_side_of_loops_that_touch(turns):
    """A hole that touches the outer loop and another hole, wherever its first corner is."""
    first = circle(0.3, 0.5, 0.3, turns * math.pi / 2)
    outer = polygon((0.0, 0.0), (0.9, 0.0), (0.9, 1.0), (0.0, 1.0))
    tables = Body(plate(), trims=[[outer, first, circle(0.75, 0.5, 0.15)]]).trim_tables
    sides = [trim_area_nb.side_of_loop(tables, pieces) for pieces in loop_pieces(tables, 0)]
    assert sides == [1, -1, -1]


def test_loops_outside_the_rectangle_are_errors():
    with pytest.raises(GeometryError, match="rectangle"):
        Body(plate(), trims=[[circle(0.5, 0.5, 0.6)]])


@pytest.mark.interpreted
def test_pieces_know_their_edge_and_loop():
    outer, inner = circle(2, 2, 1.5), circle(2, 2, 0.5)
    edge = BodyEdge(inner[0], 0.0, (EdgeUse(0, 1, 0, False),))
    tables = Body(plate(4, 4), trims=[[outer, inner]], edges=[edge]).trim_tables
    assert set(tables.piece_edge[tables.piece_loop[:, 0] == 1]) == {0}
    assert set(tables.piece_edge[tables.piece_loop[:, 0] == 0]) == {-1}
    # Head to tail, bit by bit.
    first = tables.piece_ends[tables.piece_loop[:, 0] == 0]
    assert np.array_equal(first[:, 2:], np.roll(first[:, :2], -1, axis=0))


def test_area_of_a_trimmed_sphere_cap_is_that_of_the_closed_form():
    from contiga.geometry import shapes

    ball = shapes.sphere(radius=2.0)
    (u0, u1), (v0, v1) = ball.domain
    level = v0 + 0.7 * (v1 - v0)
    cap = Body(ball, trims=[[polygon((u0, level), (u1, level), (u1, v1), (u0, v1))]])
    height = 2.0 - ball.evaluate([[u0, level]])[0, 2]
    assert patch_areas(cap)[0] == pytest.approx(2 * math.pi * 2.0 * height, rel=1e-9)


@pytest.mark.interpreted
def test_roots_at_halves_and_double_roots_are_found():
    # (t − ½)(t − ¼) and (t − ⅓)², in Bernstein form of degree 2.
    actual = build_nb.roots_inside(np.array([0.125, -0.25, 0.375]))
    assert np.allclose(actual, [0.25, 0.5], atol=1e-13)
    double = build_nb.roots_inside(np.array([1.0 / 9.0, -2.0 / 9.0, 4.0 / 9.0]))
    assert double.size == 0 or np.allclose(double, 1.0 / 3.0, atol=1e-6)
