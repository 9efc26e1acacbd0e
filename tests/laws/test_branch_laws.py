"""What must hold of certified feet, whatever the surface and the step."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import contiga as cg
from contiga.records import Status


def sheet(seed):
    """A random rational bicubic over the unit square, 3 × 2 elements."""
    rng = np.random.default_rng(seed)
    knots = [np.concatenate([np.zeros(4), np.arange(1, n) / n, np.ones(4)]) for n in (3, 2)]
    x, y = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 5), indexing="ij")
    net = np.stack([x, y, 0.1 * rng.normal(size=x.shape)], axis=-1)
    return cg.NurbsSurface((3, 3), knots, net, rng.uniform(0.7, 1.4, x.shape))


@settings(max_examples=25, deadline=None)
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


@settings(max_examples=25, deadline=None)
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
