"""Areas and lengths against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipe

from contiga import NurbsCurve, NurbsSurface, shapes
from contiga.errors import InputError

PI = math.pi


@pytest.mark.parametrize(
    ("surface", "exact"),
    [
        (shapes.sphere(radius=2.0), 16 * PI),
        (shapes.sphere(radius=1e-6), 4e-12 * PI),
        (shapes.torus(major=3.0, minor=1.0), 12 * PI**2),
        (shapes.cylinder(radius=2.0, height=3.0), 12 * PI),
        (shapes.cone(radius=3.0, height=4.0), 15 * PI),
        (shapes.cone(radius=4.0, height=4.0, top_radius=1.0), 25 * PI),
        (shapes.disc(radius=3.0), 9 * PI),
        (shapes.plane(width=2.0, length=3.0), 6.0),
    ],
)
def test_area_is_the_closed_form_to_ten_digits(surface, exact):
    assert surface.area() == pytest.approx(exact, rel=1e-10)
    far = surface.rotated((1, 2, 3), 0.7).translated((30.0, -20.0, 10.0))
    assert far.area() == pytest.approx(exact, rel=1e-8 if exact < 1e-6 else 1e-10)


@pytest.mark.interpreted
def test_area_of_a_spheroid():
    """Oblate a = a > c: 2πa² (1 + (1 − e²)/e · atanh e)."""
    a, c = 2.0, 1.0
    e = math.sqrt(1 - (c / a) ** 2)
    exact = 2 * PI * a**2 * (1 + (1 - e**2) / e * math.atanh(e))
    assert shapes.ellipsoid(axes=(a, a, c)).area() == pytest.approx(exact, rel=1e-10)


def test_area_of_a_saddle():
    """z = h(ξ² − η²) over [−1, 1]²: ∬ sqrt(1 + 4h²(ξ² + η²)), by an independent quadrature."""
    from scipy.integrate import dblquad

    h = 0.8
    exact = dblquad(lambda y, x: math.sqrt(1 + 4 * h * h * (x * x + y * y)), -1, 1, -1, 1)[0]
    surface = shapes.saddle(width=2.0, length=2.0, height=h)
    assert surface.area() == pytest.approx(exact, rel=1e-9)
    assert surface.insert_knots(u=[0.3, 0.31], v=[0.9]).area() == pytest.approx(exact, rel=1e-9)


def test_area_with_a_fold_line_is_found_by_subdivision():
    """A flat strip that turns back on itself: |N| = |slope of 4u(1 − u)| has a kink at u = 1/2."""
    x = [0.0, 2.0, 0.0]
    points = [[[a, b, 0.0] for b in (0.0, 1.0)] for a in x]
    fold = NurbsSurface((2, 1), ([0, 0, 0, 1, 1, 1], [0, 0, 1, 1]), points)
    assert fold.area() == pytest.approx(2.0, rel=1e-10)
    third = NurbsSurface((2, 1), fold.knots, points, [[1, 1], [2, 2], [1, 1]])
    top = third.evaluate([[0.5, 0.5]])[0, 0]
    assert third.area() == pytest.approx(2.0 * top, rel=1e-9)


def test_lengths_of_conics():
    assert shapes.circle(radius=3.0).length() == pytest.approx(6 * PI, rel=1e-12)
    assert shapes.line((0, 0, 0), (3, 4, 0)).length() == pytest.approx(5.0, rel=1e-15)
    exact = 4 * 3.0 * ellipe(1 - (2 / 3) ** 2)
    assert shapes.ellipse(axes=(3.0, 2.0)).length() == pytest.approx(exact, rel=1e-12)


def test_length_does_not_depend_on_where_the_curve_is():
    curve = shapes.ellipse(axes=(3.0, 2.0))
    far = curve.translated((1e5, 1e5, 0))
    assert far.length() == pytest.approx(curve.length(), rel=1e-10)


def test_looser_tolerance_is_kept():
    surface = shapes.ellipsoid(axes=(10.0, 1.0, 0.1))
    fine = surface.area(1e-12)
    for rtol in (1e-2, 1e-5, 1e-8):
        assert abs(surface.area(rtol) / fine - 1.0) < rtol


@pytest.mark.parametrize("rtol", [0.0, -1e-3, 1.0, math.nan, 1e-20])
def test_tolerances_outside_their_range_are_refused(rtol):
    for shape in (shapes.plane().area, shapes.circle().length):
        with pytest.raises(InputError, match="relative tolerance"):
            shape(rtol)


def test_collapsed_surface_has_no_area():
    flat = NurbsSurface((1, 1), ([0, 0, 1, 1],) * 2, np.zeros((2, 2, 3)))
    assert flat.area() == 0.0


def test_a_surface_without_area_but_for_rounding_is_not_quartered_for_ever():
    torus, half = shapes.torus(major=8.0, minor=1.0), shapes.torus(major=8.0, minor=0.5)
    tube = 2.0 * (torus.control_points - half.control_points)
    thin = torus.control_points - (1.0 - 1e-14) * tube
    ring = NurbsSurface(torus.degrees, torus.knots, thin, torus.weights)
    assert 0.0 <= ring.area(1e-9) < 1e-10
    line = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], [[1e-17, 0.3, 0.1], [0.0, 0.3, 0.1]])
    assert line.length(1e-12) < 1e-15


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_areas_and_lengths_beyond_all_numbers_end():
    far = shapes.plane(width=1e200, length=1e200)
    assert not np.isfinite(far.area(1e-9))
    line = shapes.line((0.0, 0.0, 0.0), (1e200, 1e200, 0.0))
    assert not np.isfinite(line.length(1e-9))
