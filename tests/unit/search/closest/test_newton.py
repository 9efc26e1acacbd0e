"""A round of Newton's method on one point, and the record of its foot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

from contiga.search.closest.kernels import newton_nb
from contiga.search.closest.kernels.newton_nb import ACTIVE, DONE, LEFT, REJECTED

TOLERANCE = 1e-24


def called(inlined):
    """A kernel that only kernels call, for calls from Python."""
    return njit(lambda *given: inlined(*given), error_model="numpy")


AT = {way: called(getattr(newton_nb, f"{way}_at")) for way in ("polynomial", "rational")}
newton_step, foot_record = called(newton_nb.newton_step), called(newton_nb.foot_record)
local_place = called(newton_nb.local_place)


def bowl(weight=1.0):
    """Coefficients of z = (x² + y²)/2 over the square of side one; its centre of curvature at the
    bottom is at height 1."""
    k = np.zeros(64)
    k[4] = k[17] = weight
    k[34] = k[40] = 0.5 * weight
    k[48] = weight
    return k


def rounds(at, k, p, place, most=newton_nb.ROUNDS):
    """States round by round, and where the last one led."""
    s, t = place
    best, state, seen = math.inf, ACTIVE, []
    while state == ACTIVE and len(seen) < most:
        x, y, z = at(k, 0, 1, s, t)
        s, t, best, state = newton_step((s, t), (best, state), p, x, y, z, TOLERANCE)
        seen.append(state)
    return seen, (s, t), best


@pytest.mark.interpreted
@pytest.mark.parametrize("way", AT)
def test_rounds_lead_to_the_foot_and_its_record(way):
    """The foot of the point above (0.3, 0) by 0.2 along the normal; weights that are equal do
    nothing."""
    at = AT[way]
    k = bowl(1.0 if way == "polynomial" else 0.7)
    n = np.array([-0.3, 0.0, 1.0]) / math.sqrt(1.09)
    p = tuple(np.array([0.3, 0.0, 0.045]) + 0.2 * n)
    seen, (s, t), best = rounds(at, k, p, (0.25, 0.1))
    assert seen == [ACTIVE] * (len(seen) - 1) + [DONE]
    np.testing.assert_allclose((s, t), (0.3, 0.0), rtol=0, atol=1e-13)
    assert best >= 0.04 * (1.0 - 1e-12)
    x, y, z, gap, state = foot_record(p, DONE, *at(k, 0, 1, s, t), TOLERANCE)
    np.testing.assert_allclose((x, y, z, gap), (*n, 0.2), rtol=0, atol=1e-13)
    assert state == DONE


@pytest.mark.interpreted
def test_a_point_beyond_the_centre_of_curvature_is_given_back():
    (state,), place, _ = rounds(AT["polynomial"], bowl(), (0.0, 0.0, 1.5), (0.01, 0.0))
    assert state == REJECTED
    assert place == (0.01, 0.0)


@pytest.mark.interpreted
def test_a_foot_beyond_the_element_is_left_for():
    (*_, state), (s, _), _ = rounds(AT["polynomial"], bowl(), (0.8, 0.0, 0.3), (0.4, 0.0))
    assert state == LEFT
    assert s > 0.5


@pytest.mark.interpreted
def test_what_is_no_nearer_than_allowed_is_given_back():
    at = AT["polynomial"]
    x, y, z = at(bowl(), 0, 1, 0.2, 0.0)
    p, place = (0.1, 0.0, 0.5), (0.2, 0.0)
    f = 0.1**2 + 0.48**2
    for best, wanted in ((f * (1.0 + 1e-9), ACTIVE), (f * (1.0 - 1e-9), REJECTED)):
        state = newton_step(place, (best, ACTIVE), p, x, y, z, TOLERANCE)[3]
        assert state == wanted


@pytest.mark.interpreted
def test_a_record_beside_the_foot_is_given_back():
    derivatives = AT["polynomial"](bowl(), 0, 1, 1e-9, 0.0)
    p = (0.0, 0.0, 0.5)
    assert foot_record(p, DONE, *derivatives, TOLERANCE)[4] == REJECTED
    assert foot_record(p, DONE, *derivatives, 1e-17)[4] == DONE
    assert foot_record(p, LEFT, *derivatives, TOLERANCE)[4] == LEFT


@pytest.mark.interpreted
def test_a_parameter_has_a_place_in_its_element_and_none_beyond():
    assert local_place(2.5, 2.0, 1.0) == 0.0
    assert local_place(9.0, 2.0, 0.25) == 0.5
    assert local_place(1.0, 2.0, 0.25) == -0.5
