"""Curves and surfaces against geomdl (NURBS-Python), an independent implementation."""

from __future__ import annotations

import numpy as np
import pytest
from geomdl import NURBS, BSpline, operations

from contiga import NurbsCurve, NurbsSurface

DEGREES = [(1, 2), (2, 2), (3, 3), (5, 4), (3, 7)]


def knot_vector(rng, degree, spans):
    inner = np.sort(rng.random(spans - 1)).round(3)
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def both_surfaces(p, q, seed):
    rng = np.random.default_rng(seed)
    U, V = knot_vector(rng, p, 4), knot_vector(rng, q, 3)
    shape = (p + 4, q + 3)
    points, weights = rng.normal(size=(*shape, 3)), rng.uniform(0.2, 4.0, shape)
    other = NURBS.Surface()
    other.degree_u, other.degree_v = p, q
    other.ctrlpts_size_u, other.ctrlpts_size_v = shape
    weighted = np.concatenate([points * weights[..., None], weights[..., None]], axis=-1)
    other.ctrlptsw = weighted.reshape(-1, 4).tolist()
    other.knotvector_u, other.knotvector_v = U.tolist(), V.tolist()
    return NurbsSurface((p, q), (U, V), points, weights), other


@pytest.mark.parametrize(("p", "q"), DEGREES)
def test_rational_derivatives_agree(p, q):
    surface, other = both_surfaces(p, q, seed=p + 10 * q)
    uv = np.random.default_rng(0).random((15, 2))
    D = surface.derivatives(uv, order=3)
    for row, (u, v) in enumerate(uv):
        theirs = other.derivatives(u, v, 3)
        for a in range(4):
            for b in range(4 - a):
                expected = np.array(theirs[a][b])
                scale = 1.0 + np.abs(expected).max()
                np.testing.assert_allclose(D[row, a, b], expected, rtol=0, atol=1e-11 * scale)


@pytest.mark.parametrize(("p", "q"), DEGREES)
def test_normals_agree(p, q):
    surface, other = both_surfaces(p, q, seed=p + 10 * q)
    uv = np.random.default_rng(1).random((15, 2))
    theirs = [operations.normal(other, pair, normalize=True)[1] for pair in uv.tolist()]
    np.testing.assert_allclose(surface.normal(uv), theirs, rtol=0, atol=1e-10)


def test_inserted_knots_give_the_same_control_points():
    rng = np.random.default_rng(3)
    knots, points = knot_vector(rng, 3, 4), rng.normal(size=(7, 3))
    other = BSpline.Curve()
    other.degree, other.ctrlpts, other.knotvector = 3, points.tolist(), knots.tolist()
    operations.insert_knot(other, [0.4321], [2])
    ours = NurbsCurve(3, knots, points).insert_knots([0.4321, 0.4321])
    np.testing.assert_allclose(ours.control_points, other.ctrlpts, rtol=0, atol=1e-13)
    np.testing.assert_allclose(ours.knots, other.knotvector, rtol=0, atol=0)
