"""Edges have width: faces that meet within a tolerance let nothing through, borders keep theirs."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.search.tables import tables_of


def roof(gap, tolerance, *, lift=0.0, angle=0.5):
    """Two faces that meet along y at the ridge x = 0, `gap` apart there, and their edge."""
    left = cg.shapes.bilinear(
        [-1, -1, -angle], [-gap / 2, -1, 0], [-1, 1, -angle], [-gap / 2, 1, 0]
    )
    right = cg.shapes.bilinear(
        [gap / 2, -1, lift], [1, -1, lift - angle], [gap / 2, 1, lift], [1, 1, lift - angle]
    )
    curve = cg.shapes.line([0, -1, 0], [0, 1, 0])
    uses = (EdgeUse(0, -1, 1, False), EdgeUse(1, -1, 0, False))
    edge = BodyEdge(curve, tolerance, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body([left, right], edges=[edge] if tolerance else [])


def trimmed_roof(gap, tolerance):
    """The same with faces that are cut back to the ridge by trimming curves."""
    left = cg.shapes.bilinear([-1, -1, -0.5], [0.5, -1, 0.25], [-1, 1, -0.5], [0.5, 1, 0.25])
    right = cg.shapes.bilinear([-0.5, -1, 0.25], [1, -1, -0.5], [-0.5, 1, 0.25], [1, 1, -0.5])
    loops = []
    for first, last in ((0.0, (1 - gap / 2) / 1.5), ((0.5 + gap / 2) / 1.5, 1.0)):
        corners = [[first, 0, 0], [last, 0, 0], [last, 1, 0], [first, 1, 0]]
        ends = zip(corners, corners[1:] + corners[:1], strict=True)
        loops.append([[cg.shapes.line(a, b) for a, b in ends]])
    curve = cg.shapes.line([0, -1, 0], [0, 1, 0])
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    edge = BodyEdge(curve, tolerance, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body([left, right], trims=loops, edges=[edge])


def aimed(gap, n=4000, seed=0, steep=0.3):
    """Segments from above through the gap between the faces."""
    rng = np.random.default_rng(seed)
    x = np.column_stack([rng.uniform(-0.5, 0.5, n) * gap, rng.uniform(-0.9, 0.9, n), np.zeros(n)])
    d = np.column_stack([*(steep * rng.normal(size=(2, n))), -np.ones(n)])
    d *= 10 ** rng.uniform(-4, -0.5, (n, 1)) / np.linalg.norm(d, axis=1, keepdims=True)
    return x - d, x + d


@pytest.mark.parametrize("make", [roof, trimmed_roof])
@pytest.mark.parametrize("gap", [1e-12, 1e-8, 6e-6])
def test_a_gap_within_the_tolerance_lets_nothing_through(make, gap):
    body = make(gap, 0.5 * gap)
    a, b = aimed(gap)
    hit = body.first_hit(a, b)
    assert (hit.patch >= 0).all()
    assert np.abs(hit.point[:, 0]).max() < 2.0  # a foot to start from
    _, sense = body.surface.last_crossings(a, b, np.arange(len(a), dtype=np.int32))
    assert (sense == 1).all()


def test_a_step_between_two_faces_within_the_tolerance_lets_nothing_through():
    """One face lies 3e-6 above the other where they join smoothly: the riser is no hole."""
    body = roof(0.0, 3e-6, lift=3e-6, angle=0.0)
    rng = np.random.default_rng(1)
    n = 2000
    x = np.column_stack([np.zeros(n), rng.uniform(-0.9, 0.9, n), rng.uniform(0, 3e-6, n)])
    d = np.tile([0.5, 0.0, -0.05], (n, 1))
    hit = body.first_hit(x - d, x + d)
    assert (hit.patch >= 0).all()


def bent_step(lift, radius):
    """Two sheets bent down along x, cut at x = 0 where the right one lies `lift` above the left."""
    ends, middle = -0.5 / radius, 0.5 / radius
    sheets, loops = [], []
    for k in range(2):
        points = [
            [[x, y, z + k * lift] for y in (-1, 1)] for x, z in ((-1, ends), (0, middle), (1, ends))
        ]
        knots = ([0, 0, 0, 1, 1, 1], [0, 0, 1, 1])
        sheets.append(cg.NurbsSurface((2, 1), knots, points))
        corners = [[k / 2, 0, 0], [(k + 1) / 2, 0, 0], [(k + 1) / 2, 1, 0], [k / 2, 1, 0]]
        sides = zip(corners, corners[1:] + corners[:1], strict=True)
        loops.append([[cg.shapes.line(a, b) for a, b in sides]])
    curve = cg.shapes.line([0, -1, lift / 2], [0, 1, lift / 2])
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    edge = BodyEdge(curve, lift / 2, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body(sheets, trims=loops, edges=[edge])


def test_a_path_that_grazes_a_step_between_bent_faces_does_not_slip_through():
    """It meets the carrier far beyond the edge, where that has bent away from its tangent plane."""
    lift, radius, n = 2e-4, 0.6, 500
    body = bent_step(lift, radius)
    rng = np.random.default_rng(1)
    # Over the edge it passes the middle of the riser; it ends below the right sheet.
    z, y = lift * rng.uniform(0.02, 0.9, n), rng.uniform(-0.8, 0.8, n)
    deep = lift * rng.uniform(0.05, 0.3, n)
    end = np.column_stack([np.full(n, 0.015), y, lift - 0.015**2 / (2 * radius) - deep])
    a = np.column_stack([np.zeros(n), y + rng.uniform(-0.005, 0.005, n), z])
    a -= 2.0 * (end - a)
    hit = body.first_hit(a, end)
    assert (hit.patch >= 0).all()
    assert (np.abs(hit.point[:, 0]) < 1e-6).mean() > 0.5  # on the edge
    _, sense = body.surface.last_crossings(a, end, np.arange(n, dtype=np.int32))
    assert (sense == 1).all()


def test_without_an_edge_there_a_gap_stays_open_unless_the_sides_match():
    assert (roof(6e-6, 0.0).first_hit(*aimed(3e-6, steep=0.0)).patch < 0).any()
    assert (roof(1e-8, 0.0).first_hit(*aimed(1e-8)).patch >= 0).all()  # joined by place


@pytest.mark.parametrize("make", [roof, trimmed_roof])
def test_borders_have_no_width(make):
    """Beside the outer borders of the same faces nothing is hit."""
    body = make(6e-6, 3e-6)
    y = np.linspace(-0.9, 0.9, 50)
    for x in (-1 - 1e-7, 1 + 1e-7):
        a = np.column_stack([np.full(50, x), y, np.full(50, 1.0)])
        assert (body.first_hit(a, a - [0, 0, 3]).patch < 0).all()


@pytest.mark.parametrize("make", [roof, trimmed_roof])
def test_widths_are_twice_the_tolerance_where_a_second_face_joins(make):
    body = make(6e-6, 3e-6)
    tables = tables_of(body)
    (tolerance,) = {edge.tolerance for edge in body.edges if len(edge.uses) > 1}
    assert tolerance >= 3e-6  # never below what is measured
    expected = 2.0 * tolerance + 4 * np.finfo(float).eps * body.size
    table = tables.elements.table
    np.testing.assert_allclose(table["edge_tolerance"], expected, rtol=1e-12)
    if make is trimmed_roof:
        shared = tables.trims.piece_edge >= 0
        np.testing.assert_allclose(tables.piece_width[shared], expected, rtol=1e-12)
        assert (tables.piece_width[~shared] == 0.0).all()
    else:
        np.testing.assert_allclose(
            table["width"], [[0, expected, 0, 0], [expected, 0, 0, 0]], rtol=1e-12
        )


def loop_of(*corners):
    points = [[*corner, 0.0] for corner in corners]
    return [cg.shapes.line(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]


def test_a_short_wide_piece_at_a_corner_does_not_widen_the_side_it_comes_in_to():
    """The side keeps its own width: a path under it that never leaves meets nothing."""
    wide, short = 1e-4, 4e-4
    squares = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]  # two more beyond the upper and the right side
    sheets = [
        cg.shapes.bilinear(*([x + a, y + b, 0] for b in (0, 1) for a in (0, 1))) for x, y in squares
    ]
    loops = [
        [loop_of((0, 0), (1, 0), (1, 1), (1 - short, 1), (0, 1))],
        [loop_of((0, 0), (1 - short, 0), (1, 0), (1, 1), (0, 1))],
        [loop_of((0, 0), (1, 0), (1, 1), (0, 1))],
    ]
    meets = [
        ([1, 1], [1 - short, 1], wide, (0, 2), (1, 1)),
        ([1 - short, 1], [0, 1], wide, (0, 3), (1, 0)),
        ([1, 0], [1, 1], 1e-12, (0, 1), (2, 3)),
    ]
    edges = [
        BodyEdge(
            cg.shapes.line([*a, 0], [*b, 0]),
            tolerance,
            tuple(EdgeUse(patch, 0, index, False) for patch, index in uses),
            ((0.0, 1.0), (0.0, 1.0)),
        )
        for a, b, tolerance, *uses in meets
    ]
    body = cg.Body(sheets, trims=loops, edges=edges)
    table = tables_of(body).elements.table
    row = np.flatnonzero(table["patch"] == 0)
    np.testing.assert_allclose(table["width"][row, 3], 2.0 * wide, rtol=1e-9)
    assert table["width"][row, 1].max() < 1e-11
    start, end = np.array([[0.9999, 0.5, -5e-5]]), np.array([[1.0001, 0.5, -5e-5]])
    assert body.first_hit(start, end).status == cg.Status.NO_HIT


def test_a_path_past_a_convex_edge_within_its_width_does_not_end_inside():
    """It may touch; but what it crosses last must not put a far end on the wrong side."""
    p = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    shift = 2e-6 * np.random.default_rng(2).normal(size=(6, 1, 3))
    faces = [
        cg.shapes.bilinear(*(p[[a, b, d, c]] + s))
        for (a, b, c, d), s in zip(quads, shift, strict=True)
    ]
    edges = []
    for i in range(6):
        for j in range(i):
            common = sorted(set(quads[i]) & set(quads[j]))
            if len(common) == 2:
                uses = []
                for k in (j, i):
                    corner = [quads[k][m] for m in (0, 1, 3, 2)]  # (0,0), (1,0), (0,1), (1,1)
                    pair = sorted(corner.index(c) for c in common)
                    side = {(0, 2): 0, (1, 3): 1, (0, 1): 2, (2, 3): 3}[tuple(pair)]
                    uses.append(EdgeUse(k, -1, side, False))
                curve = cg.shapes.line(p[common[0]], p[common[1]])
                edges.append(BodyEdge(curve, 1e-5, tuple(uses), ((0.0, 1.0), (0.0, 1.0))))
    body = cg.Body(faces, edges=edges)
    rng = np.random.default_rng(3)
    n = 4000
    ends = rng.choice([-1.0, 1.0], (n, 3))
    ends[np.arange(n), rng.integers(0, 3, n)] = rng.uniform(-0.9, 0.9, n)
    c = ends + 1e-5 * rng.normal(size=(n, 3))
    d = rng.normal(size=(n, 3))
    d *= 0.3 / np.linalg.norm(d, axis=1, keepdims=True)
    a, b = c - d, c + d
    gap_a, gap_b = (np.abs(x).max(axis=1) - 1.0 for x in (a, b))
    clear = (np.abs(gap_a) > 1e-3) & (np.abs(gap_b) > 1e-3)
    _, sense = body.surface.last_crossings(a, b, np.arange(n, dtype=np.int32))
    inside = np.where(sense == 0, gap_a < 0, sense == 1)
    np.testing.assert_array_equal(inside[clear], gap_b[clear] < 0)
