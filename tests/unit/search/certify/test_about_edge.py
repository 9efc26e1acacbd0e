"""The fold next to a foot: both faces of a trimmed edge, seen from one of them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import config, njit
from tests.sample import few
from tests.unit.search.folds import (
    at_fold,
    bent_fold,
    natural_fold,
    plates_along_parabola,
    trimmed_fold,
)

import contiga as cg
from contiga.elements.extraction import elements_of
from contiga.search.certify.certify_records import Bending, Cells
from contiga.search.certify.kernels import about_edge_nb, bend_nb, edge_segment_nb
from contiga.search.tables import tracking_tables_of

pytestmark = pytest.mark.interpreted


@njit
def fold_about(tables, foot, r):
    """Whether a fold is known, the frame of its first face and of its second, the way to it."""
    found = about_edge_nb.fold_about(tables, foot, r, about_edge_nb.edge_work())
    return found[0], found[1], found[2], found[3]


def place(body, point):
    """The element of a roof's face that a point lies on, and where in it."""
    foot = body.project([point])
    tables = tracking_tables_of(body)
    for e, row in enumerate(tables.elements.table):
        u0, u1, v0, v1 = row["box"]
        u, v = foot.uv[0]
        if row["patch"] == foot.patch[0] and u0 <= u <= u1 and v0 <= v <= v1:
            return e, (u - u0) / (u1 - u0) - 0.5, (v - v0) / (v1 - v0) - 0.5
    raise AssertionError("no element there")


@pytest.mark.parametrize("turn", [0.1, 1.0])
@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_both_faces_of_a_fold_are_known_with_their_frames(turn, sense):
    body = trimmed_fold(turn)
    half = 0.5 * turn
    away = 0.05
    foot = place(body, [sense * away * np.cos(half), 0.2, -away * np.sin(half)])
    known, first, second, way = fold_about(tracking_tables_of(body), foot, 0.3)
    assert known
    assert way == pytest.approx(away, rel=1e-6)
    for frame, own in ((first, sense), (second, -sense)):
        point, tangent, b, normal = (np.array(v) for v in frame[:4])
        np.testing.assert_allclose(point[[0, 2]], 0.0, atol=1e-6)
        np.testing.assert_allclose(np.abs(tangent), [0.0, 1.0, 0.0], atol=1e-6)
        np.testing.assert_allclose(b, [own * np.cos(half), 0.0, -np.sin(half)], atol=1e-6)
        np.testing.assert_allclose(np.abs(normal), [np.sin(half), 0.0, np.cos(half)], atol=1e-6)


def test_far_from_the_edge_there_is_no_fold():
    body = trimmed_fold(1.0)
    assert not fold_about(tracking_tables_of(body), place(body, [0.4, 0.0, -0.2]), 0.05)[0]


def known(body, foot, r):
    return fold_about(tracking_tables_of(body), foot, r)[0]


def test_no_fold_is_known_beside_a_corner():
    """At 0.5 off: a ball that reaches it holds more than two faces."""
    body = bent_fold(1.0)
    for foot in (at_fold(body, 0, -0.02, 0.5), at_fold(body, 1, 0.02, -0.5)):
        assert known(body, foot, 0.2)
        assert not any(known(body, foot, r) for r in (0.5, 0.6, 0.7))


def test_no_fold_is_known_where_the_face_beyond_ends():
    """It is 0.04 wide there; the ball would have to be 0.05 into it."""
    body = bent_fold(1.0, far=0.04)
    assert not known(body, at_fold(body, 0, -0.05, 0.0), 0.1)
    assert known(body, at_fold(body, 0, -0.01, 0.0), 0.01)


def test_no_fold_is_known_where_its_edge_may_turn_by_more_than_a_radian():
    body = plates_along_parabola(5.0)
    for k, x in ((0, -1e-4), (1, 1e-4)):
        assert known(body, (k, 0.5 * x, 0.0), 0.02)
        # 1.56 r either way it turns by 10 a length; somewhat farther on, its bounds end
        assert not any(known(body, (k, 0.5 * x, 0.0), r) for r in np.linspace(0.055, 0.065, 11))


def test_no_fold_is_known_where_the_element_of_the_foot_ends():
    """At a knot line 0.08 off: what lies beyond may bend otherwise."""
    fold = bent_fold(1.0)
    left, right = fold.patches
    parts = [left.insert_knots(u=[0.9 / 1.5]), right]
    body = cg.Body(parts, trims=fold.trims, edges=fold.edges)
    foot = (1, 0.08 / 0.6 - 0.5, 0.0)
    assert tracking_tables_of(body).elements.table[1]["box"].tolist() == [0.9 / 1.5, 1.0, 0.0, 1.0]
    assert known(body, foot, 0.03)
    assert not any(known(body, foot, r) for r in (0.08, 0.1, 0.12))


@pytest.mark.parametrize("y", [0.95, -0.95])
def test_no_fold_is_known_beside_the_end_of_a_crease(y):
    """The crease is one of the sides of its elements near the foot, and another one is 0.05 off."""
    body = natural_fold(1.0)
    for foot in ((0, 0.0, 0.5 - 0.03), (1, 0.0, 0.03 - 0.5)):
        assert known(body, foot, 0.06)
        assert not known(body, (foot[0], 0.5 * y, foot[2]), 0.06)


@njit
def slip_of(tables, foot, r):
    return about_edge_nb.fold_about(tables, foot, r, about_edge_nb.edge_work()).joint.slip


def test_tangents_that_leave_the_second_face_at_the_foot_itself_slip():
    """Whatever was measured elsewhere along the edge."""
    tables = tracking_tables_of(bent_fold(1.0, tilt=1e-4))
    edges = np.array(tables.joints.edges)
    edges["slip"] = 0.0
    tables = tables._replace(joints=tables.joints._replace(edges=edges))
    foot = (0, 0.999 / 1.5 - 0.5, 0.0)
    assert slip_of(tables, foot, 0.1) == pytest.approx(1e-4, rel=1e-3)


def uneven(rng):
    """A flat sheet whose parameters run unevenly, and some askew."""
    askew = rng.integers(0, 2)
    x = np.array([0.0, 0.5 + rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 0.22), 1.0])
    y = np.array([0.0, 0.5 + askew * rng.uniform(-0.1, 0.1), 1.0])
    x, y = np.meshgrid(x, rng.uniform(1.0, 3.0) * y, indexing="ij")
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    net = np.stack([x + askew * rng.uniform(-0.3, 0.3) * y, y, 0.0 * x], axis=-1)
    return cg.NurbsSurface((2, 2), (knots, knots), net)


@njit
def cell_of(tables, foot, reach, bend, bending):
    return about_edge_nb.cell_of(tables, foot, reach, bend, bending)


def test_no_way_as_long_as_the_reach_leaves_the_cell_about_a_foot():
    rng = np.random.default_rng(0)
    edge = np.linspace(0.0, 1.0, 41)
    tables = tracking_tables_of(natural_fold(0.0))
    told = 0
    for _ in range(few(8, 2)):
        patch = uneven(rng)
        body = cg.Body([patch])
        tables = tables._replace(elements=elements_of(body, body.trim_tables)[0])
        for _ in range(30):
            s, t = rng.uniform(-0.5, 0.5, 2)
            if rng.random() < 0.5:  # next to a rim
                s = np.copysign(0.5 - 0.05 * abs(s), s)
            reach = rng.choice([10.0 ** rng.uniform(-1.5, 0.0), rng.uniform(0.7, 1.1)])
            cell = cell_of(tables, (0, s, t), reach, np.empty(6), bend_nb.bend_work())
            if cell[1] == cell[0]:
                continue
            told += 1
            foot = patch.evaluate([[s + 0.5, t + 0.5]])
            for side, end in enumerate(cell):
                if abs(end) == 0.5:
                    continue
                other = cell[2:] if side < 2 else cell[:2]
                way = other[0] + edge * (other[1] - other[0])
                rim = np.column_stack([0.0 * way + end, way][:: 1 if side < 2 else -1]) + 0.5
                assert np.linalg.norm(patch.evaluate(rim) - foot, axis=1).min() >= reach
    assert told > few(60, 15)


@njit
def along(coefs, foot, cell, bending):
    work = edge_segment_nb.segment_work()
    work.coefs[0, : len(coefs)] = coefs
    work.degree[0] = len(coefs) - 1
    return about_edge_nb.along(work, 1, foot, cell, bending)


@pytest.mark.skipif(not config.DISABLE_JIT, reason="compiles for ten seconds: run interpreted")
def test_a_edge_segment_is_no_longer_either_way_than_told():
    """A straight one across a square sheet, from the place next to the foot."""
    body = cg.Body([cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])])
    elements, bending = tracking_tables_of(body).elements, bend_nb.bend_work()
    cell = (-0.2, 0.2, -0.1, 0.1)
    assert bend_nb.bend_bounds(elements, 0, cell, np.empty(6), bending)
    rng = np.random.default_rng(1)
    half = np.array([0.2, 0.1])
    for _ in range(few(50, 10)):
        ends = rng.uniform(-1.0, 1.0, (2, 2))
        foot = rng.uniform(-1.0, 1.0, 2) * half
        coefs = np.column_stack([ends, np.ones(2)])
        at, slope, (arc, bent) = along(coefs, (0, *foot), cell, bending)
        a, b = ends * half
        share = np.clip((foot - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        np.testing.assert_allclose(at, a + share * (b - a), atol=1e-9)
        assert slope[0] * (b - a)[1] == pytest.approx(slope[1] * (b - a)[0], abs=1e-12)
        length = np.linalg.norm(b - a)
        assert max(share, 1.0 - share) * length <= arc * (1 + 1e-9)
        assert bent <= 1e-9


@njit
def way_to(foot, last, there, way, cells):
    return about_edge_nb.way_to(foot, last, there, way, cells)


def test_a_way_leads_from_the_foot_to_the_edge_and_on():
    bends = (np.array([0.0, 0.0, 2.0, 3.0, 0.0, 0.0]), np.array([0.0, 0.0, 5.0, 7.0, 0.0, 0.0]))
    bending = Bending(np.empty((4, 6)), np.empty((2, 5)))
    cells = Cells(*bends, np.empty((4, 6)), bending, bending, np.empty((2, 5)))
    foot, there = (0, 0.1, 0.2), (4, -0.5, 0.3)
    assert way_to(foot, (0, 0.3, 0.1), there, 0.6, cells) == pytest.approx(0.4 + 0.3)
    assert way_to(foot, (4, -0.4, 0.1), there, 0.6, cells) == pytest.approx(0.6 + 0.5 + 1.4)
    assert way_to(foot, (3, -0.4, 0.1), there, 0.6, cells) == np.inf
