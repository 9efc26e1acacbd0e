"""Whether one branch joins two feet inside of a face, whatever lies beyond its edges.

Each scene that must not be joined breaks one condition of the theorem, and no other.
"""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import FULL, few
from tests.unit.search.folds import (
    at_crease,
    at_fold,
    bent_fold,
    focal,
    natural_fold,
    over,
    place,
    ring,
    trimmed_fold,
)

import contiga as cg
from contiga.search.certify.kernels import about_edge_nb, edge_nb, edge_segment_nb, within_face_nb
from contiga.search.tables import tracking_tables_of
from contiga.statuses import Feature, Status

pytestmark = pytest.mark.interpreted
MANY = few(2000, 30)


@njit
def stays_in_face(tables, foot, last, path):
    return within_face_nb.stays_in_face(tables, foot, last, path, about_edge_nb.edge_work())


@njit
def over_edge(tables, foot, last, path):
    return edge_nb.over_edge(tables, foot, last, path, about_edge_nb.edge_work())


@njit
def is_between(points, start, end):
    segment = edge_segment_nb.segment_work()
    n = len(points) - 1
    segment.coefs[0, : n + 1] = points
    segment.degree[0] = n
    return within_face_nb._is_between(segment, start, end)


def joined(body, foot, last, before, after=None, at=at_fold):
    """Whether the feet `last` of a point before its motion and `foot` after it are joined."""
    path = (tuple(before), tuple(before if after is None else after))
    feet = (
        (at(body, *foot), at(body, *last))
        if at is at_crease
        else (at_fold(body, *f) for f in (foot, last))
    )
    return stays_in_face(tracking_tables_of(body), *feet, path)


@pytest.mark.parametrize("k", [0, 1])
@pytest.mark.parametrize("depth", [-0.2, 1e-3])
def test_feet_beside_a_sharp_edge_are_joined_from_inside(k, depth):
    """The motion is three times as long as the way to the edge, beyond which there is a minimum
    that is as good."""
    body = bent_fold(1.0)
    out = -1.0 if k == 0 else 1.0
    near, far = 0.01 * out, 0.04 * out
    ends = place(1.0, k, near, depth), place(1.0, k, far, depth) + np.array([0.0, 0.02, 0.0])
    feet = (k, near, 0.0), (k, far, 0.02)
    path = tuple(ends[0]), tuple(ends[1])
    assert joined(body, feet[1], feet[0], *ends)
    assert joined(body, feet[0], feet[1], *ends[::-1])
    if depth < 0.0:
        assert not over_edge(
            tracking_tables_of(body), at_fold(body, *feet[1]), at_fold(body, *feet[0]), path
        )


@pytest.mark.parametrize("k", [0, 1])
def test_feet_beside_a_crease_and_a_corner_are_joined_from_inside(k):
    """In the corner between the crease and the border of a natural face."""
    body = natural_fold(1.0)
    out = -1.0 if k == 0 else 1.0
    ends = [
        place(1.0, k, x * out, -0.2) + np.array([0.0, y, 0.0])
        for x, y in ((0.02, 0.97), (0.05, 0.99))
    ]
    feet = (k, 0.02 * out, 0.97), (k, 0.05 * out, 0.99)
    assert joined(body, feet[1], feet[0], *ends, at=at_crease)
    over_border = ends[0], ends[1] + np.array([0.0, 0.02, 0.0])
    assert not joined(body, (k, 0.05 * out, 1.0), feet[0], *over_border, at=at_crease)


@pytest.mark.parametrize("gap", [0.0, 1e-3])
def test_the_point_is_seen_from_the_edge_before_and_after(gap):
    """By more than twice its width: nearer to it a foot may be one of the other face."""
    body = trimmed_fold(1.0, gap)

    def told(x0, x1):
        ends = place(1.0, 0, x0, -0.2), place(1.0, 0, x1, -0.2)
        return joined(body, (0, x1, 0.0), (0, x0, 0.0), *ends)

    assert told(-0.05, -0.02)
    clear = -2.1 * gap - 1e-7
    assert told(clear, -0.02)
    assert told(-0.02, clear)
    for x in (-0.9 * gap, 0.01):
        assert not told(x, -0.02)
        assert not told(-0.02, x)


def test_two_minima_in_the_hollow_of_a_face_are_not_joined():
    turn, c, bend = 1.2, -0.4, 0.5
    body = bent_fold(turn, bulge=(bend, 0.0), middle=(c, 0.0))
    high, d = focal(bend)
    p = place(turn, 0, c, high - bend * c * c)
    assert not joined(body, (0, c - d, 0.0), (0, c + d, 0.0), p)
    assert not joined(body, (0, c + d, 0.0), (0, c - d, 0.0), p)
    low = [over(turn, bend, c, c + x, 0.05 * high) for x in (-d, d)]
    assert joined(body, (0, c + d, 0.0), (0, c - d, 0.0), *low)


def test_what_is_no_foot_is_not_joined():
    body = bent_fold(1.0)
    p = place(1.0, 0, -0.05, -0.2)
    assert joined(body, (0, -0.05, 0.0), (0, -0.02, 0.0), place(1.0, 0, -0.02, -0.2), p)
    assert not joined(body, (0, -0.04, 0.0), (0, -0.02, 0.0), place(1.0, 0, -0.02, -0.2), p)


def test_two_minima_on_two_faces_are_not_joined():
    """Below a roof, at the same place of either face's element."""
    turn = 1.0
    body = bent_fold(turn)
    p = (0.0, 0.0, -0.25 / np.sin(0.5 * turn))
    feet = (0, -0.25, 0.0), (1, 0.25, 0.0)
    assert at_fold(body, *feet[0])[1:] == at_fold(body, *feet[1])[1:]
    assert joined(body, feet[0], feet[0], p)
    assert joined(body, feet[1], feet[1], p)
    assert not joined(body, feet[0], feet[1], p)


@pytest.mark.parametrize(("y", "good"), [(0.1, True), (0.4, False)])
def test_a_face_is_known_as_far_as_its_element_goes(y, good):
    """A plate of two by two elements: about the second place the ball reaches the next one."""
    knots = [0.0, 0.0, 0.5, 1.0, 1.0]
    u = np.linspace(-1.0, 1.0, 3)
    net = np.stack([*np.meshgrid(u, u, indexing="ij"), np.zeros((3, 3))], axis=-1)
    body = cg.Body([cg.NurbsSurface((1, 1), (knots, knots), net)])
    tables = tracking_tables_of(body)
    foot, last = (0, -0.3, y), (0, -0.3, y - 0.15)
    p = [np.array([s - 0.5, t - 0.5, 0.3]) for _, s, t in (last, foot)]
    told = stays_in_face(tables, foot, last, (tuple(p[0]), tuple(p[1])))
    assert told == good


def plate_with_slot(wide):
    """A plate from −1 to 1 with a hole that runs along y, so wide, from −1/2 to 1/2."""
    plate = cg.shapes.bilinear([-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0])
    x0, x1 = 0.5 - 0.25 * wide, 0.5 + 0.25 * wide
    corners = [[x0, 0.25, 0], [x0, 0.75, 0], [x1, 0.75, 0], [x1, 0.25, 0]]
    hole = [cg.shapes.line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
    return cg.Body([plate], trims=[[ring(0.0, 1.0), hole]])


@pytest.mark.parametrize("wide", [1e-3, 0.1])
def test_a_foot_does_not_go_over_a_slot(wide):
    body = plate_with_slot(wide)

    def told(x0, x1):
        feet = (0, 0.5 * x1, 0.0), (0, 0.5 * x0, 0.0)
        return stays_in_face(tracking_tables_of(body), *feet, ((x0, 0.0, 0.1), (x1, 0.0, 0.1)))

    x = 0.5 * wide
    # Of a narrow slot the other side is in the ball, too.
    assert told(-x - 0.03, -x - 0.01) == (wide > 0.03)
    assert told(x + 0.01, x + 0.03) == (wide > 0.03)
    assert not told(-x - 0.01, x + 0.01)
    assert not told(x + 0.01, -x - 0.01)


def test_a_way_that_crosses_a_stretch_is_seen():
    """Ways about rational curves against finely sampled ones; many that do not cross are let by."""
    rng = np.random.default_rng(0)
    let_by = missed = 0
    for _ in range(few(2000 if FULL else 500, 200)):
        n = rng.integers(1, 5)
        points = np.column_stack([rng.uniform(-1, 1, (n + 1, 2)), rng.uniform(0.5, 2.0, n + 1)])
        start = rng.uniform(-1.0, 1.0, 2)
        end = start + rng.uniform(-0.5, 0.5, 2)
        t = np.linspace(0.0, 1.0, 400)[:, None]
        basis = np.stack([_choose(n, i) * t**i * (1 - t) ** (n - i) for i in range(n + 1)])
        weight = (basis * points[:, None, 2:]).sum(0)
        curve = (basis * points[:, None, 2:] * points[:, None, :2]).sum(0) / weight
        points[:, :2] *= points[:, 2:]
        told = is_between(points, tuple(start), tuple(end))
        if crosses(curve, start, end):
            assert told
        else:
            let_by += not told
            missed += told
    assert let_by > missed


def _choose(n, i):
    return float(np.prod([(n - k) / (k + 1.0) for k in range(i)]))


def crosses(curve, start, end):
    """Whether a polygon meets a straight way."""
    d = end - start
    off = d[0] * (curve[:, 1] - start[1]) - d[1] * (curve[:, 0] - start[0])
    k = np.flatnonzero(off[:-1] * off[1:] <= 0.0)
    share = off[k] / (off[k] - off[k + 1])
    at = curve[k] + share[:, None] * (curve[k + 1] - curve[k])
    along = ((at - start) @ d) / (d @ d)
    return bool(((along >= 0.0) & (along <= 1.0)).any())


@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.1])
def test_feet_inside_of_a_sheet_are_certified_beside_its_border(size):
    body = cg.Body([cg.shapes.saddle()])
    rng = np.random.default_rng(1)
    low, high = body.bounds()
    a = body.project(low + (high - low) * rng.uniform(0.0, 1.0, (MANY, 3)))
    inside = a.feature == Feature.FACE
    a = (a.point + 0.05 * rng.uniform(-1.0, 1.0, (MANY, 1)) * a.normal)[inside]
    way = rng.normal(size=a.shape)
    b = a + size * body.size * way / np.linalg.norm(way, axis=1)[:, None]
    feet = body.project(b, start=body.project(a), mode="track")
    going = (feet.status == Status.OK) & (feet.feature == Feature.FACE)
    assert feet.certified[going].mean() >= 0.999
