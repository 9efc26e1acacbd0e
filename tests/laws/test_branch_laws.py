"""What must hold of certified feet, whatever the surface and the step."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sample import FULL

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.statuses import Status


def sheet(seed):
    """A random rational bicubic over the unit square, 3 × 2 elements."""
    rng = np.random.default_rng(seed)
    knots = [np.concatenate([np.zeros(4), np.arange(1, n) / n, np.ones(4)]) for n in (3, 2)]
    x, y = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 5), indexing="ij")
    net = np.stack([x, y, 0.1 * rng.normal(size=x.shape)], axis=-1)
    return cg.NurbsSurface((3, 3), knots, net, rng.uniform(0.7, 1.4, x.shape))


@settings(max_examples=25 if FULL else 12, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.floats(-6.0, 0.0), depth=st.floats(0.0, 0.1))
def test_one_certified_step_ends_where_sixteen_do(seed, size, depth):
    body = cg.Body([sheet(seed)])
    rng = np.random.default_rng(seed)
    patch = body.patches[0]
    uv = rng.uniform(0.1, 0.9, (60, 2))
    a = patch.evaluate(uv) + depth * rng.uniform(-1, 1, (60, 1)) * patch.normal(uv)
    way = rng.normal(size=(60, 3))
    b = a + 10**size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    once = body.project(b, start=start, mode="track")
    feet, proved = start, once.certified == 1
    for k in range(1, 17):
        feet = body.project(a + k / 16 * (b - a), start=feet, mode="track")
        proved &= (feet.certified == 1) & (feet.status == Status.OK)
    proved &= once.status == Status.OK
    np.testing.assert_allclose(once.point[proved], feet.point[proved], rtol=0, atol=1e-8)


def creased(seed, turn):
    """A random biquadratic sheet of two elements, bent by about `turn` where they meet."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 3), indexing="ij")
    net = np.stack([x, y, -np.tan(0.5 * turn) * np.abs(x)], axis=-1)
    net += 0.1 * rng.normal(size=net.shape)
    knots = [0, 0, 0, 0.5, 0.5, 1, 1, 1], [0, 0, 0, 1, 1, 1]
    return cg.NurbsSurface((2, 2), knots, net, rng.uniform(0.8, 1.25, x.shape))


@settings(max_examples=25 if FULL else 12, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    size=st.floats(-6.0, -0.3),
    turn=st.floats(-2.5, 2.5),
    depth=st.floats(0.001, 0.5),
)
def test_one_certified_step_over_a_crease_ends_where_many_do(seed, size, turn, depth):
    """Feet on and beside a crease, of points on both sides of it."""
    body = cg.Body([creased(seed, turn)])
    rng = np.random.default_rng(seed)
    u = 0.5 + np.where(rng.random(60) < 0.5, 0.0, rng.uniform(-0.05, 0.05, 60))
    at = body.patches[0].evaluate(np.column_stack([u, rng.uniform(0.3, 0.7, 60)]))
    off, way = rng.normal(size=(2, 60, 3))
    a = at + depth * off / np.linalg.norm(off, axis=1)[:, None]
    b = a + 10**size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    once = body.project(b, start=start, mode="track")
    proved = (once.certified == 1) & (once.status == Status.OK) & (start.status == Status.OK)
    feet = start
    for k in range(1, 129):
        feet = body.project(a + k / 128 * (b - a), start=feet, mode="track")
    np.testing.assert_allclose(once.point[proved], feet.point[proved], rtol=0, atol=1e-7)


def trimmed(turn, gap):
    """Two planes that reach over the edge where they meet, cut back to half of `gap` from it."""
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)
    sheets, loops = [], []
    cut = (1.0 - 0.5 * gap) / 1.5
    for k, (first, last) in enumerate(((-1.0, 0.5), (-0.5, 1.0))):
        rise = s if k == 0 else -s
        a, b = ([[x * c, y, x * rise] for y in (-1.0, 1.0)] for x in (first, last))
        sheets.append(cg.shapes.bilinear(a[0], b[0], a[1], b[1]))
        low, high = (0.0, cut) if k == 0 else (1.0 - cut, 1.0)
        corners = [[low, 0, 0], [high, 0, 0], [high, 1, 0], [low, 1, 0], [low, 0, 0]]
        loops.append([[cg.shapes.line(*ends) for ends in pairwise(corners)]])
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    curve = cg.shapes.line([0, -1, 0], [0, 1, 0])
    edge = BodyEdge(curve, 0.5 * gap, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body(sheets, trims=loops, edges=[edge])


@settings(max_examples=25 if FULL else 12, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    size=st.floats(-6.0, -0.3),
    turn=st.floats(-2.5, 2.5),
    gap=st.sampled_from([0.0, 1e-8, 1e-5]),
    depth=st.floats(0.001, 0.3),
)
def test_one_certified_step_beside_a_trimmed_edge_ends_where_many_do(seed, size, turn, gap, depth):
    """Feet on and beside the edge, of points on both sides; a branch that ends has none."""
    body = trimmed(turn, gap)
    rng = np.random.default_rng(seed)
    x, y = (
        np.where(rng.random(60) < 0.5, 0.0, rng.uniform(-0.05, 0.05, 60)),
        rng.uniform(-0.4, 0.4, 60),
    )
    at = np.column_stack([x * np.cos(0.5 * turn), y, -np.abs(x) * np.sin(0.5 * turn)])
    off, way = rng.normal(size=(2, 60, 3))
    a = at + depth * off / np.linalg.norm(off, axis=1)[:, None]
    b = a + 10**size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    once = body.project(b, start=start, mode="track")
    proved = (once.certified == 1) & (once.status == Status.OK) & (start.status == Status.OK)
    feet = start
    for k in range(1, 129):
        feet = body.project(a + k / 128 * (b - a), start=feet, mode="track")
    slack = 2e-6 * body.size + 8.0 * gap
    np.testing.assert_allclose(once.point[proved], feet.point[proved], rtol=0, atol=slack)
