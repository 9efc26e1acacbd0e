"""The plain formulas experiments are checked against are themselves checked by other codes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, insert

from contiga_validation.thesis.chapter2 import cox_de_boor
from contiga_validation.thesis.chapter2_refine import CUBIC, boehm
from contiga_validation.thesis.chapter5_shapes import TORUS, _off_torus
from contiga_validation.thesis.play import run_scene


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_the_printed_recursion_gives_scipys_basis(degree: int) -> None:
    inner = [0.2, 0.5, 0.5, 0.9] if degree > 1 else [0.2, 0.5, 0.9]
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    u = np.linspace(0.0, 1.0, 301)
    ours = cox_de_boor(knots, degree, u)
    theirs = BSpline.design_matrix(u, knots, degree).toarray()
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14)


@pytest.mark.parametrize("t", [0.1, 0.25, 0.5, 0.9])
def test_boehms_formula_gives_scipys_control_points(t: float) -> None:
    spline = BSpline(CUBIC.knots, CUBIC.control_points, 3)
    theirs = insert(t, (spline.t, spline.c.T, 3))
    ours = boehm(CUBIC, t)
    np.testing.assert_allclose(ours.knots, theirs[0], rtol=0, atol=0)
    count = len(ours.control_points)
    np.testing.assert_allclose(
        ours.control_points, np.asarray(theirs[1]).T[:count], rtol=0, atol=1e-15
    )


def test_weights_as_printed_change_the_curve() -> None:
    u = np.linspace(0.0, 1.0, 101)
    moved = boehm(CUBIC, 0.25, as_printed=True).evaluate(u) - CUBIC.evaluate(u)
    assert np.abs(moved).max() > 0.1


def test_distance_from_the_torus_sees_a_point_beside_it() -> None:
    point = TORUS.evaluate([0.3, 0.4])
    normal = TORUS.normal([0.3, 0.4])
    assert _off_torus(point) < 1e-14
    assert _off_torus(point + 0.01 * normal) == pytest.approx(0.01)


def test_a_played_scene_keeps_every_step() -> None:
    run = run_scene("sideways_sliding")
    assert len(run.states) == len(run.places) == len(run.history["force"]) == 17
    assert [state.n_contact for state in run.states] == run.history["n_contact"].tolist()
    assert run.places[4][0, 2] == pytest.approx(-0.05)
