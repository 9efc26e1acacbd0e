"""Basis functions of patches against those of geometry, and against the surfaces themselves."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter.iga.shells import crooked, plate

from contiga.geometry.knots import basis
from contiga.patches.basis import ORDERS, basis_at, elements_of, spans_at

KNOTS = np.array([0.0, 0, 0, 0, 0.2, 0.5, 0.5, 0.9, 2, 2, 2, 2])


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_values_and_derivatives_of_splines(degree: int) -> None:
    inner = KNOTS[4:8] if degree > 1 else KNOTS[[4, 5, 7]]
    knots = np.r_[np.zeros(degree + 1), inner, np.full(degree + 1, 2.0)]
    t = np.r_[np.random.default_rng(0).uniform(0.0, 2.0, 20), 0.0, 0.2, 0.5, 2.0]
    found = spans_at(knots, degree, t)
    whole = np.zeros((len(t), 3, len(knots) - degree - 1))
    for k, first in enumerate(found.first):
        whole[k, :, first : first + degree + 1] = found.values[k]
    np.testing.assert_allclose(whole, basis(knots, degree, t, 2), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("make", [crooked, lambda p, n: plate(p, n, (2.0, 1.0))])
def test_they_say_where_a_surface_is_and_how_it_leads_on(make, degree: int) -> None:  # type: ignore[no-untyped-def]
    surface = make(degree, (3, 2))
    (a, b), (c, d) = surface.domain
    uv = np.random.default_rng(1).uniform([a, c], [b, d], (30, 2))
    at = basis_at(surface, uv)
    net = surface.control_points.reshape(-1, 3)
    exact = surface.derivatives(uv, 2)
    for k, (i, j) in enumerate(ORDERS):
        np.testing.assert_allclose(at.of(k, net), exact[:, i, j], atol=1e-12, rtol=1e-12)
    np.testing.assert_allclose(at.values[:, 0].sum(axis=1), 1.0, rtol=1e-14)


def test_elements_lie_between_different_knots() -> None:
    assert elements_of(KNOTS).tolist() == [[0, 0.2], [0.2, 0.5], [0.5, 0.9], [0.9, 2.0]]
