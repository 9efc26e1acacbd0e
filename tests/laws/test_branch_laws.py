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
