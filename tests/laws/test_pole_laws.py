"""Feet beside the poles of spheres and ellipsoids of revolution, held against one equation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests import ellipsoids
from tests.sample import FULL

import contiga as cg


@lru_cache
def body_of(height: float, size: float) -> cg.Body:
    return cg.Body([ellipsoids.ellipsoid((size, size, height * size))])


@settings(max_examples=200 if FULL else 60, deadline=None, derandomize=True)
@given(
    height=st.sampled_from((1.0, 0.4, 2.5)),
    size=st.sampled_from((1e-9, 1e-3, 1.0, 50.0, 1e3)),
    off=st.one_of(st.just(0.0), st.floats(-16.0, -1.5).map(lambda x: 10.0**x)),
    angle=st.floats(0.0, 6.3),
    depth=st.floats(-0.5, 30.0),
    before=st.tuples(st.floats(-13.0, -1.5), st.floats(0.0, 6.3)),
    pole=st.sampled_from((-1.0, 1.0)),
)
@example(1.0, 50.0, 1e-6 / 50.0, 1.2, -0.1, (-3.0, 0.0), 1.0)
@example(1.0, 50.0, 0.0, 0.0, -0.1, (-9.0, 0.0), 1.0)
def test_feet_and_normals_beside_a_pole(height, size, off, angle, depth, before, pole):
    axes = (size, size, height * size)
    body = body_of(height, size)
    radius = size / height  # of curvature at the pole
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    point = off * size * way + [0.0, 0.0, pole * (axes[2] + depth * radius)]
    (foot,), (normal,) = ellipsoids.feet(point[None], axes)
    step = 10.0 ** before[0] * size
    there = point + step * np.array([np.cos(before[1]), np.sin(before[1]), 0.0])
    start = body.project([there])
    for feet in (body.project([point]), body.project([point], start=start, mode="track")):
        assert feet.status[0] == cg.Status.OK
        # exact to 1e-12 of the size along the surface, twice that half as deep as it is curved
        assert np.linalg.norm(feet.point[0] - foot) <= 2.5e-12 * body.size
        assert np.linalg.norm(feet.normal[0] - normal) <= 2.5e-12 * body.size / radius
