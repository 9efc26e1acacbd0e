"""Curves and surfaces of geomdl, splinepy and scipy: the same points, and the same bits back."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from geomdl import NURBS, BSpline
from scipy import interpolate

import contiga as cg
from contiga.errors import GeometryError, MissingPackageError

RNG = np.random.default_rng(11)
UV = RNG.uniform(size=(40, 2)) * [3.0, 1.0] + [2.0, 0.0]
U3, V2 = [2, 2, 2, 2, 2.5, 4, 5, 5, 5, 5], [0, 0, 0, 0.25, 0.25, 1, 1, 1]
POINTS = RNG.normal(size=(6, 5, 3))
WEIGHTS = RNG.uniform(0.2, 3.0, (6, 5))

SURFACES = [
    cg.NurbsSurface((3, 2), (U3, V2), POINTS),
    cg.NurbsSurface((3, 2), (U3, V2), POINTS, WEIGHTS),
    cg.shapes.sphere(radius=2.0),
]
CURVES = [
    cg.NurbsCurve(3, U3, POINTS[:, 0]),
    cg.NurbsCurve(3, U3, POINTS[:, 0], WEIGHTS[:, 0]),
]


@pytest.fixture
def splinepy() -> ModuleType:
    module: ModuleType = pytest.importorskip("splinepy")
    return module


def parameters(spline: Any, n: int = 30) -> np.ndarray:
    """(n, d) inside the domain."""
    low, high = np.atleast_2d(spline.domain).T
    return low + (high - low) * np.random.default_rng(3).uniform(size=(n, len(low)))


def assert_same_bits(ours: Any, back: Any, but_points: bool = False) -> None:
    assert type(back) is type(ours)
    assert back.is_rational == ours.is_rational
    for name in ("degree", "degrees", "knots", "weights"):
        np.testing.assert_equal(getattr(back, name, None), getattr(ours, name, None))
    ulp = 2.3e-16 if but_points else 0.0
    np.testing.assert_allclose(back.control_points, ours.control_points, rtol=ulp, atol=0.0)


def assert_same_points(ours: Any, theirs: np.ndarray, where: np.ndarray) -> None:
    expected = ours.evaluate(where if where.shape[1] == 2 else where[:, 0])
    scale = np.abs(ours.control_points).max()
    np.testing.assert_allclose(theirs, expected, rtol=0.0, atol=1e-13 * scale)


@pytest.mark.parametrize("ours", [*SURFACES, *CURVES])
def test_geomdl_has_the_same_points_and_gives_the_spline_back(ours: Any) -> None:
    theirs, where = ours.to_geomdl(), parameters(ours)
    assert type(theirs).__module__ == ("geomdl.NURBS" if ours.is_rational else "geomdl.BSpline")
    rows = [theirs.evaluate_single(row.tolist() if len(row) == 2 else row[0]) for row in where]
    assert_same_points(ours, np.array(rows), where)
    # geomdl keeps them multiplied by the weights
    assert_same_bits(ours, type(ours).from_any(theirs), but_points=ours.is_rational)


@pytest.mark.parametrize("ours", [*SURFACES, *CURVES])
def test_splinepy_has_the_same_points_and_gives_the_spline_back(
    ours: Any, splinepy: ModuleType
) -> None:
    theirs, where = ours.to_splinepy(), parameters(ours)
    assert type(theirs) is (splinepy.NURBS if ours.is_rational else splinepy.BSpline)
    assert_same_points(ours, theirs.evaluate(where), where)
    assert_same_bits(ours, type(ours).from_any(theirs))


@pytest.mark.parametrize("kind", ["Bezier", "RationalBezier"])
def test_bezier_patches_of_splinepy_are_read(kind: str, splinepy: ModuleType) -> None:
    rows = RNG.normal(size=(6, 2))
    weights = {"weights": RNG.uniform(0.5, 2.0, 6)} if kind == "RationalBezier" else {}
    theirs = getattr(splinepy, kind)(degrees=[2, 1], control_points=rows, **weights)
    ours = cg.NurbsSurface.from_any(theirs)
    assert ours.degrees == (2, 1)
    assert ours.domain == ((0.0, 1.0), (0.0, 1.0))
    where = parameters(ours)
    plane = np.pad(theirs.evaluate(where), ((0, 0), (0, 1)))
    assert_same_points(ours, plane, where)


def test_splines_of_scipy_are_read() -> None:
    theirs = interpolate.NdBSpline((np.array(U3, float), np.array(V2, float)), POINTS, (3, 2))
    assert_same_bits(SURFACES[0], cg.NurbsSurface.from_any(theirs))
    assert_same_points(SURFACES[0], theirs(UV), UV)
    line = interpolate.BSpline(U3, np.concatenate([POINTS[:, 0], np.ones((4, 3))]), 3)
    assert_same_bits(CURVES[0], cg.NurbsCurve.from_any(line))
    open_knots = interpolate.BSpline(np.arange(10.0), POINTS[:, 0], 3)
    where = np.linspace(3.0, 6.0, 20)[:, None]
    assert_same_points(cg.NurbsCurve.from_any(open_knots), open_knots(where[:, 0]), where)


def test_what_is_ours_comes_back_as_it_is() -> None:
    for ours in (*SURFACES, *CURVES):
        assert type(ours).from_any(ours) is ours


def made_by_geomdl(module: ModuleType, points: list[list[float]]) -> Any:
    surface = module.Surface()
    surface.degree_u = surface.degree_v = 1
    surface.set_ctrlpts(points, 2, 2)
    surface.knotvector_u = surface.knotvector_v = [0, 0, 1, 1]
    return surface


SQUARE = [[0.0, 0.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]]


def test_surfaces_made_by_geomdl_are_read_with_u_first() -> None:
    flat = cg.NurbsSurface.from_any(made_by_geomdl(BSpline, SQUARE))
    np.testing.assert_array_equal(flat.evaluate([1.0, 0.25]), [[2.0, 0.25, 0.0]])
    weighted = made_by_geomdl(NURBS, [[2 * x, 2 * y, 0.0, 2.0] for x, y in SQUARE])
    np.testing.assert_array_equal(
        cg.NurbsSurface.from_any(weighted).evaluate([1.0, 0.25]), [[2.0, 0.25, 0.0]]
    )


@pytest.mark.parametrize(
    "wrong",
    [
        *("ball", None, [[1.0, 2.0, 3.0]], CURVES[0], cg.Body([SURFACES[2]])),
        *(CURVES[0].to_geomdl(), interpolate.BSpline(U3, POINTS[:, 0], 3)),
        interpolate.NdBSpline((np.array(U3, float), np.array(V2, float)), POINTS[..., 0], (3, 2)),
        made_by_geomdl(BSpline, [[x, y, 0.0, 1.0] for x, y in SQUARE]),
    ],
)
def test_what_is_no_surface_is_told_what_is(wrong: object) -> None:
    with pytest.raises(GeometryError, match=r"read as a surface.*geomdl.*splinepy.*NdBSpline"):
        cg.NurbsSurface.from_any(wrong)


def test_what_is_no_curve_is_told_what_is() -> None:
    with pytest.raises(GeometryError, match=r"read as a curve.*found 'geomdl.NURBS.Surface"):
        cg.NurbsCurve.from_any(SURFACES[1].to_geomdl())


def test_surfaces_of_geomdl_without_points_or_with_trims_are_refused() -> None:
    with pytest.raises(GeometryError, match="no control points yet"):
        cg.NurbsSurface.from_any(NURBS.Surface())
    trimmed = made_by_geomdl(BSpline, SQUARE)
    rim = BSpline.Curve()
    rim.degree, rim.ctrlpts = 1, [[0.2, 0.2], [0.8, 0.2], [0.5, 0.8], [0.2, 0.2]]
    rim.knotvector = [0, 0, 0.3, 0.6, 1, 1]
    trimmed.trims = [rim]
    with pytest.raises(GeometryError, match=r"is trimmed.*Body\(patches, trims"):
        cg.NurbsSurface.from_any(trimmed)


@pytest.mark.parametrize("package", ["geomdl", "splinepy"])
def test_a_missing_package_is_named(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (package, "geomdl.NURBS"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingPackageError, match=f"is not installed.*pip install {package}"):
        getattr(SURFACES[1], f"to_{package}")()
