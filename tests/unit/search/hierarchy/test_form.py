"""The closest point of an element by a formula, against samples of it."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search.plain import elements

import contiga as cg
from contiga.arrays.codes import NO_FORM
from contiga.elements.kernels import element_nb
from contiga.search.hierarchy.forms import forms_of
from contiga.search.hierarchy.kernels import form_nb
from contiga.search.hierarchy.kernels.form_nb import LAST, NEAREST

pytestmark = pytest.mark.interpreted


@njit
def closest_on_form(forms, e, point, which):
    return form_nb.closest_on_form(forms[e], point, which)


@njit
def evaluate(elements, e, s, t, h):
    element_nb.evaluate(elements, e, s, t, h)


def arcs() -> cg.NurbsSurface:
    """Part of a torus, its parameters neither even nor the usual way round."""
    whole = cg.shapes.torus(major=2.0, minor=0.7)
    (u0, u1), (v0, v1) = ((knots[0], knots[knots > knots[0]][0]) for knots in whole.knots)
    patch = whole.restricted((u0, 0.3 * u0 + 0.7 * u1), (0.6 * v0 + 0.4 * v1, v1))
    weights = patch.weights * np.array([[1.0], [2.0], [4.0]]) * np.array([1.0, 0.3, 0.09])
    other = cg.NurbsSurface(patch.degrees, patch.knots, patch.control_points, weights)
    return other.transposed()


SHAPES = {
    "plane": cg.shapes.bilinear([0, 0, 0], [2, 1, 0], [0.5, 1, 1], [2.5, 2, 1]),
    "cylinder": cg.shapes.cylinder(radius=0.3),
    "cone": cg.shapes.cone(),
    "disc": cg.shapes.disc(),
    "sphere": cg.shapes.sphere(),
    "torus": cg.shapes.torus(),
    "uneven part of a torus": arcs(),
}


def samples(own, e, n):
    x = np.linspace(-0.5, 0.5, n)
    st = np.stack(np.meshgrid(x, x, indexing="ij"), -1).reshape(-1, 2)
    return st, np.array([place(own, e, s, t) for s, t in st])


def place(own, e, s, t):
    h = np.zeros((4, 6))
    evaluate(own, e, s, t, h)
    return own.table["origin"][e] + h[:3, 0]


@pytest.mark.parametrize("name", SHAPES)
def test_it_is_on_the_element_and_no_sample_is_nearer(name: str) -> None:
    body = cg.Body([SHAPES[name]]).rotated([1.0, 2.0, 3.0], 0.8).translated([5.0, 0.0, 0.0])
    own = elements(body)
    forms = forms_of(own, body.trim_tables, 1e-12 * body.size)
    rng = np.random.default_rng(3)
    for e in range(few(len(own.table), 1)):
        assert forms["kind"][e] != NO_FORM
        _, surface = samples(own, e, few(60, 8))
        for point in 5.0 * np.array([1.0, 0, 0]) + rng.normal(size=(few(40, 5), 3)) * 1.5:
            on = closest_on_form(forms, e, tuple(point), NEAREST)
            assert max(abs(on.s), abs(on.t)) <= 0.5
            away = np.linalg.norm(place(own, e, on.s, on.t) - point)
            assert on.distance == pytest.approx(away, rel=1e-12, abs=1e-12)
            assert on.distance <= np.linalg.norm(surface - point, axis=1).min() + 1e-12


def local_minima(distance):
    """Places of a grid (n, n) that no neighbour is below."""
    n = len(distance)
    padded = np.full((n + 2, n + 2), np.inf)
    padded[1:-1, 1:-1] = distance
    around = [padded[i : i + n, j : j + n] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.argwhere(distance < np.min(around, axis=0))


@pytest.mark.parametrize("name", ["cylinder", "cone", "sphere", "torus"])
def test_all_local_minima_are_among_the_four(name: str) -> None:
    body = cg.Body([SHAPES[name]])
    own = elements(body)
    forms = forms_of(own, body.trim_tables, 1e-12 * body.size)
    n = few(41, 15)
    st, surface = samples(own, 0, n)
    rng = np.random.default_rng(4)
    several = 0
    for point in rng.normal(size=(few(200, 12), 3)):
        distance = np.linalg.norm(surface - point, axis=1).reshape(n, n)
        seen = st.reshape(n, n, 2)[tuple(local_minima(distance).T)]
        found = [closest_on_form(forms, 0, tuple(point), which) for which in range(LAST + 1)]
        there = np.array([(on.s, on.t) for on in found if np.isfinite(on.distance)])
        several += len(there) > 1
        for minimum in seen:
            assert np.abs(there - minimum).max(axis=1).min() <= 1.5 / (n - 1)
    assert several > 0


@pytest.mark.parametrize("name", ["cylinder", "sphere", "torus"])
def test_of_a_point_on_the_axis_all_turns_are_as_near(name: str) -> None:
    body = cg.Body([SHAPES[name]])
    own = elements(body)
    forms = forms_of(own, body.trim_tables, 1e-12 * body.size)
    point = (0.0, 0.0, 0.125)
    for e in range(few(len(own.table), 2)):
        on = closest_on_form(forms, e, point, NEAREST)
        _, surface = samples(own, e, 9)
        assert on.distance <= np.linalg.norm(surface - point, axis=1).min() + 1e-12
        away = np.linalg.norm(place(own, e, on.s, on.t) - point)
        assert on.distance == pytest.approx(away, rel=1e-12)
