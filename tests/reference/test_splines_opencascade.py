"""Rational surfaces up to degree 15 against OpenCASCADE."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contiga import NurbsSurface, shapes


def array1(kind, values):
    out = kind(1, len(values))
    for i, value in enumerate(values, 1):
        out.SetValue(i, value)
    return out


def occ_surface(surface: NurbsSurface) -> Any:
    from OCP.collections import Array1_double, Array1_int, Array2_double, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    n, m = surface.control_points.shape[:2]
    weights = surface.weights if surface.is_rational else np.ones((n, m))
    poles, factors = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
    for i in range(n):
        for j in range(m):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*surface.control_points[i, j].tolist()))
            factors.SetValue(i + 1, j + 1, float(weights[i, j]))
    parts = [np.unique(k, return_counts=True) for k in surface.knots]
    knots = [array1(Array1_double, values.tolist()) for values, _ in parts]
    times = [array1(Array1_int, counts.tolist()) for _, counts in parts]
    return Geom_BSplineSurface(poles, factors, *knots, *times, *surface.degrees, False, False)


def random_surface(p, q):
    rng = np.random.default_rng(p * 31 + q)
    U, V = (np.r_[np.zeros(d + 1), 0.3, 0.6, np.ones(d + 1)] for d in (p, q))
    shape = (p + 3, q + 3)
    return NurbsSurface((p, q), (U, V), rng.normal(size=(*shape, 3)), rng.uniform(0.1, 5, shape))


@pytest.mark.parametrize(("p", "q"), [(1, 1), (2, 3), (5, 5), (8, 3), (15, 2), (15, 15)])
def test_points_and_derivatives_agree(p, q):
    """To nine digits: at degree 15 OpenCASCADE is 8e-11 off the value in exact fractions."""
    surface = random_surface(p, q)
    theirs = occ_surface(surface)
    uv = np.random.default_rng(0).random((25, 2))
    D = surface.derivatives(uv, order=2)
    for row, (u, v) in enumerate(uv.tolist()):
        point = theirs.Value(u, v)
        np.testing.assert_allclose(
            D[row, 0, 0], [point.X(), point.Y(), point.Z()], rtol=0, atol=1e-12
        )
        for a, b in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
            slope = theirs.DN(u, v, a, b)
            expected = np.array([slope.X(), slope.Y(), slope.Z()])
            scale = 1.0 + np.abs(expected).max()
            np.testing.assert_allclose(D[row, a, b], expected, rtol=0, atol=1e-9 * scale)


@pytest.mark.parametrize(("p", "q"), [(2, 3), (5, 5), (14, 9)])
def test_elevation_agrees(p, q):
    surface = random_surface(p, q)
    theirs = occ_surface(surface)
    theirs.IncreaseDegree(p + 1, q + 2)
    ours = surface.elevate(u=1, v=2)
    assert ours.control_points.shape[:2] == (theirs.NbUPoles(), theirs.NbVPoles())
    for i in range(theirs.NbUPoles()):
        for j in range(theirs.NbVPoles()):
            pole = theirs.Pole(i + 1, j + 1)
            expected = [pole.X(), pole.Y(), pole.Z()]
            np.testing.assert_allclose(ours.control_points[i, j], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "surface", [shapes.torus(), shapes.bumpy_plate(), shapes.saddle(), shapes.ellipsoid()]
)
def test_areas_agree(surface):
    """To six digits: OpenCASCADE's own value of the saddle is 4e-7 off the double integral."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    face = BRepBuilderAPI_MakeFace(occ_surface(surface), 1e-7).Face()
    BRepGProp.SurfaceProperties_s(face, properties, 1e-9)
    assert surface.area() == pytest.approx(properties.Mass(), rel=1e-6)
