"""f = |S − P|²/2 about a foot, and the step that lowers it."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search import plain

import contiga as cg
from contiga.search.closest.closest_records import Expansion
from contiga.search.closest.kernels import local_nb

pytestmark = pytest.mark.interpreted


@njit
def expand(elements, e, s, t, point, h):
    return local_nb.expand(elements, e, s, t, point, h)


@njit
def newton(q):
    return local_nb.newton(q)


@pytest.fixture(scope="module")
def elements():
    return plain.elements(cg.Body([cg.shapes.bumpy_plate(waves=1)]))


def test_slopes_and_curvatures_are_differences_of_f(elements):
    h, step = np.empty((4, 6)), 1e-4
    point = np.array([0.1, -0.2, 0.4])
    for s, t in np.random.default_rng(0).uniform(-0.4, 0.4, (few(20, 5), 2)):

        def f(ds, dt, s=s, t=t):
            return expand(elements, 0, s + ds * step, t + dt * step, point, h)[0]

        q = expand(elements, 0, s, t, point, h)
        differences = [
            (f(1, 0) - f(-1, 0)) / (2 * step),
            (f(0, 1) - f(0, -1)) / (2 * step),
            (f(1, 0) - 2 * f(0, 0) + f(-1, 0)) / step**2,
            (f(1, 1) - f(1, -1) - f(-1, 1) + f(-1, -1)) / (4 * step**2),
            (f(0, 1) - 2 * f(0, 0) + f(0, -1)) / step**2,
        ]
        np.testing.assert_allclose(q[1:6], differences, rtol=1e-5, atol=1e-6)


def test_steps_lead_down_even_where_f_is_not_convex():
    for g_s, g_t, ss, st, tt in np.random.default_rng(1).normal(size=(200, 5)):
        d = newton(Expansion(0.0, g_s, g_t, ss, st, tt, 1.0, 1.0))
        assert d[0] * g_s + d[1] * g_t < 0.0


def test_a_step_is_newtons_where_f_is_convex():
    d = newton(Expansion(0.0, 0.3, -0.2, 2.0, 0.5, 1.5, 1.0, 1.0))
    np.testing.assert_allclose(
        d, -np.linalg.solve([[2.0, 0.5], [0.5, 1.5]], [0.3, -0.2]), rtol=1e-14
    )
