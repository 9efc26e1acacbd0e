"""The certificate of feet on and beside creases and at vertices."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.statuses import Feature, Status

TURNS = [1e-5, 1e-3, 0.1, 1.0, np.pi / 2, 2.5, 2.96]


def fold(turn, bow=0.0, sway=0.0, bulge=0.0, twist=0.0):
    """A sheet with a crease along y at x = 0, bent down by `turn`; two elements.

    The crease rises by bow y² and runs sideways by sway y²; the faces bulge, and the turn grows by
    `twist` along the crease.
    """
    net = np.empty((5, 3, 3))
    for j, (y, a) in enumerate(((-1.0, 1.0), (0.0, -1.0), (1.0, 1.0))):
        half = 0.5 * (turn + twist * y)
        for i, x in enumerate((-1.0, -0.5, 0.0, 0.5, 1.0)):
            down = [np.cos(half) * x, 0.0, -np.sin(half) * abs(x)]
            out = [np.sin(half) * np.sign(x), 0.0, np.cos(half)]
            lift = bulge if i in (1, 3) else 0.0
            net[i, j] = np.add(down, [sway * a, y, bow * a]) + lift * np.array(out)
    knots = [0, 0, 0, 0.5, 0.5, 1, 1, 1], [0, 0, 0, 1, 1, 1]
    return cg.Body([cg.NurbsSurface((2, 2), knots, net)])


def foot_on_roof(p, turn):
    """Feet on the flat fold, of points above it."""
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)
    down = np.maximum(c * np.abs(p[:, 0]) - s * p[:, 2], 0.0)
    return np.column_stack([c * down * np.sign(p[:, 0]), p[:, 1], -s * down])


def above_roof(n, turn, rng):
    """Points above the flat fold, near its crease: a third over it, a third over either face."""
    height = rng.uniform(0.02, 0.2, n)
    angle = rng.uniform(-0.5, 0.5, n) * turn
    p = np.column_stack([height * np.sin(angle), rng.uniform(-0.5, 0.5, n), height * np.cos(angle)])
    aside = np.where(rng.random(n) < 0.67, rng.uniform(0.0, 0.1, n), 0.0)
    side = rng.choice([-1.0, 1.0], n)
    half = 0.5 * turn
    out = np.column_stack([side * np.sin(half), 0.0 * height, np.full(n, np.cos(half))])
    down = np.column_stack([side * np.cos(half), 0.0 * height, np.full(n, -np.sin(half))])
    over = aside > 0.0
    p[over] = (aside[:, None] * down + height[:, None] * out + [0.0, 1.0, 0.0] * p)[over]
    return p, height


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.1, 0.4])
def test_feet_over_the_outer_side_of_a_crease_are_certified(turn, size):
    """On a face or on the crease, from one to the other, along it: steps to 0.4 of the height."""
    rng = np.random.default_rng(1)
    body = fold(turn)
    a, height = above_roof(600, turn, rng)
    way = rng.normal(size=a.shape)
    b = a + size * height[:, None] * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    np.testing.assert_allclose(feet.point, foot_on_roof(b, turn), atol=1e-10)
    assert (feet.status == Status.OK).all()
    assert feet.certified.mean() >= 0.995
    if turn > 0.5:
        assert (start.feature == Feature.EDGE).sum() > 50


FOLDS = {
    "flat": (1.2, {}),
    "crease bent down": (1.0, {"bow": -0.5}),
    "crease bent up": (1.0, {"bow": 0.7}),
    "crease bent aside": (0.8, {"sway": 0.6}),
    "hollow faces": (1.5, {"bulge": -0.15}),
    "full faces": (1.5, {"bulge": 0.15}),
    "turn grows from nothing": (0.3, {"twist": 0.3}),
    "inner and outer": (0.0, {"twist": 0.8}),
    "sharp": (2.4, {"bow": 0.9, "sway": 0.2}),
    "nearly smooth": (1e-4, {"bow": 0.5, "sway": 0.3}),
}
JUMP = 100.0
"""A foot that goes so many times as far as its point has jumped."""


def continued(body, start, a, b, steps=400):
    """Feet after many tiny steps, and which of them never jumped."""
    feet, stays = start, np.ones(len(a), bool)
    for k in range(1, steps + 1):
        new = body.project(a + k / steps * (b - a), start=feet, mode="track")
        way = np.linalg.norm(new.point - feet.point, axis=1)
        stays &= way <= JUMP / steps * np.linalg.norm(b - a, axis=1) + 1e-9
        stays &= new.status != Status.BRANCH_EVENT
        feet = new
    return feet.point, stays


def about_crease(body, n, rng):
    """Points on both sides of a fold, up to 0.8 away from its crease or a face beside that."""
    u = np.where(rng.random(n) < 0.4, 0.5, 0.5 + rng.uniform(-0.1, 0.1, n))
    at = body.patches[0].evaluate(np.column_stack([u, rng.uniform(0.25, 0.75, n)]))
    out = rng.normal(size=(n, 3)) * [0.6, 0.2, 1.0]
    return at + rng.uniform(0.01, 0.8, (n, 1)) * out / np.linalg.norm(out, axis=1)[:, None]


@pytest.mark.parametrize("name", FOLDS)
@pytest.mark.parametrize("size", [0.01, 0.1, 0.6])
def test_what_is_certified_beside_a_crease_is_where_tiny_steps_lead(name, size):
    turn, shape = FOLDS[name]
    body = fold(turn, **shape)
    rng = np.random.default_rng(3)
    a = about_crease(body, 500, rng)
    way = rng.normal(size=a.shape)
    b = a + size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    point, stays = continued(body, start, a, b)
    proved = (feet.certified == 1) & (feet.status == Status.OK) & (start.status == Status.OK)
    assert proved.sum() > 25
    assert stays[proved].all()
    np.testing.assert_allclose(feet.point[proved], point[proved], atol=1e-7)


@pytest.mark.parametrize("steps", [1, 8, 100])
def test_a_foot_that_runs_into_a_crease_from_the_inner_side_is_not_certified_to_go_on(steps):
    """From below one face of a roof towards the other: over there its foot is 0.1 farther in."""
    turn = np.pi / 2
    body = fold(turn)
    down, below = np.array([0.5, 0.0, -0.5]) * 2**0.5, np.array([-0.5, 0.0, -0.5]) * 2**0.5
    path = [0.3 * down + 0.1 * below, -0.05 * down + 0.1 * below]
    feet = body.project(path[0][None])
    np.testing.assert_allclose(feet.point, [0.3 * down], atol=1e-10)
    proved = []
    for t in np.linspace(0.0, 1.0, steps + 1)[1:]:
        p = path[0] + t * (path[1] - path[0])
        feet = body.project(p[None], start=feet, mode="track")
        proved.append(feet.certified[0])
    over = int(np.ceil(0.3 / 0.35 * steps)) - 1
    assert [k for k in range(steps) if proved[k] == 0] == [over]
    np.testing.assert_allclose(feet.point, [0.1 * below], atol=1e-10)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_foot_that_jumps_along_a_crease_is_not_certified(side):
    """Over the crease z = y² points at height 0.52 are past its focal points: 2 y³ − 0.04 y = Y.

    The minimum at y = 0.18 ends where Y = −0.002; the faces fall off too steeply to be felt.
    """
    body = fold(2.4, bow=1.0)
    a, b = np.array([[0.0, 0.01, 0.52]]), np.array([[0.0, -0.01, 0.52]])
    start = body.project(side * a * [1.0, 1.0, side])
    assert start.feature.tolist() == [Feature.EDGE]
    assert side * start.point[0, 1] > 0.18
    feet = body.project(side * b * [1.0, 1.0, side], start=start, mode="track")
    assert side * feet.point[0, 1] < -0.18
    assert feet.certified.tolist() == [0]


def tent():
    """A pyramid of bilinear patches over the square [-1, 1]², its top at height one."""
    x = np.linspace(-1.0, 1.0, 3)
    net = np.empty((3, 3, 3))
    net[..., 0], net[..., 1] = np.meshgrid(x, x, indexing="ij")
    net[..., 2] = 1.0 - np.maximum(np.abs(net[..., 0]), np.abs(net[..., 1]))
    return cg.Body([cg.NurbsSurface((1, 1), ([0, 0, 0.5, 1, 1],) * 2, net)])


def test_a_foot_that_stays_at_a_vertex_is_certified():
    body = tent()
    rng = np.random.default_rng(0)
    a, b = (rng.uniform(-0.05, 0.05, (200, 3)) + np.array([0.0, 0.0, 1.2]) for _ in "ab")
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    stays = (start.feature == Feature.VERTEX) & (feet.feature == Feature.VERTEX)
    assert stays.sum() > 100
    np.testing.assert_array_equal(feet.point[stays], np.tile([[0.0, 0.0, 1.0]], (stays.sum(), 1)))
    assert (feet.certified[stays] == 1).all()


def test_a_foot_that_leaves_a_vertex_and_comes_back_another_way_is_not_certified_to_stay():
    """A vertex that is a minimum at the start, and none where the motion ends."""
    body = tent()
    start = body.project([[0.0, 0.0, 1.1]])
    assert start.feature.tolist() == [Feature.VERTEX]
    feet = body.project([[0.5, 0.1, 1.1]], start=start, mode="track")
    assert feet.feature.tolist() != [Feature.VERTEX]
    same = body.project([[0.0, 0.0, 1.3]], start=start, mode="track")
    assert same.certified.tolist() == [1]


def test_a_start_that_is_no_foot_proves_nothing():
    """On the crease, of a point whose foot is 0.1 off it."""
    body = fold(1.0)
    p = np.array([[0.1, 0.1, 0.1]])
    start = body.project(p)
    moved = start._replace(
        uv=np.array([[0.5, start.uv[0, 1]]]),
        point=np.array([[0.0, 0.1, 0.0]]),
        normal=p - [[0.0, 0.1, 0.0]],
        gap=np.ones(1),
        feature=np.array([Feature.EDGE], np.int8),
    )
    feet = body.project(p + 1e-6, start=moved, mode="track")
    assert feet.certified.tolist() == [0]
