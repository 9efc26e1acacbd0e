"""Whether one branch joins two feet by a crease, asked of scenes where it must not.

As beside trimmed edges (`test_edge_proofs`): no two minima of one point are ever joined, and each
scene breaks one condition of the theorem, and no other.
"""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.folds import at_crease, focal, natural_fold, place

from contiga.search.certify.certify_records import Near
from contiga.search.certify.kernels import crease_nb, joined_nb
from contiga.search.tables import tracking_tables_of

pytestmark = pytest.mark.interpreted


@njit
def over_crease(near, foot, last, path):
    side = crease_nb.crease_beside(near[0], foot, last)
    if side < 0:
        return False
    return crease_nb.over_crease(near, foot, last, side, path, joined_nb.prove_work())


def near(body):
    tables = tracking_tables_of(body)
    return Near(tables.elements, tables.neighbourhoods, tables.trims.trimmed, tables.scale[1])


def joined(body, foot, last, before, after=None):
    """Whether the feet `last` of a point before its motion and `foot` after it are joined."""
    path = (tuple(before), tuple(before if after is None else after))
    return over_crease(near(body), at_crease(body, *foot), at_crease(body, *last), path)


BEND, PAST = 5.0, 5e-4


def test_two_minima_in_the_hollow_of_one_face_are_not_joined():
    """Less than at the crease f is convex in the face."""
    turn, c = 1.6, -0.008
    body = natural_fold(turn, bulge=(BEND, 0.0), middle=(c, 0.0))
    high, d = focal(BEND, PAST)
    p = place(turn, 0, c, high - BEND * c * c)
    assert not joined(body, (0, c + d, 0.0), (0, c - d, 0.0), p)


def test_a_minimum_on_the_crease_and_one_in_the_hollow_of_the_other_face_are_not_joined():
    turn, c = 1.6, 0.0025
    body = natural_fold(turn, bulge=(0.0, BEND), middle=(0.0, c))
    high, d = focal(BEND, PAST)
    p = place(turn, 1, c, high - BEND * c * c)
    assert not joined(body, (0, 0.0, 0.0), (1, c + d, 0.0), p)


def test_two_minima_on_a_hollow_crease_are_not_joined():
    """Its faces fall off so steeply that they are not felt to be hollow."""
    body = natural_fold(2.4, bow=1.0)
    high, d = focal(1.0)
    assert not joined(body, (0, 0.0, -d), (0, 0.0, d), (0.0, 0.0, high))


@pytest.mark.parametrize("turn", [1e-6, 0.01, 0.5])
def test_two_minima_on_the_inner_side_of_a_crease_are_not_joined(turn):
    body = natural_fold(-turn)
    off = np.sin(0.5 * turn)
    assert not joined(body, (0, -off, 0.0), (1, off, 0.0), (0.0, 0.0, 1.0))


def test_what_is_no_foot_is_not_joined():
    """On a roof and its ridge, of a point beside that: f falls from there."""
    body = natural_fold(1.0)
    p = place(1.0, 0, -0.05, 0.2)
    assert joined(body, (0, -0.05, 0.0), (0, -0.02, 0.0), place(1.0, 0, -0.02, 0.2), p)
    assert not joined(body, (0, 0.0, 0.0), (0, -0.02, 0.0), p)


@pytest.mark.parametrize(("way", "fits"), [(0.02, True), (0.05, False), (0.2, False)])
def test_the_ball_is_twice_as_large_as_the_motion(way, fits):
    """Feet on a ridge that is bent down, of points high above it: they go less far than those do.
    Where f is less convex than at the foot, that is not enough, and none of 0.44 fits in beside the
    corner, 0.5 off."""
    bend, y, high = 0.2, 0.5, 3.0
    body = natural_fold(2.0, bow=-bend, bulge=(-bend, -bend))
    e = np.array([0.0, 1.0, -2.0 * bend * y])
    e /= np.linalg.norm(e)
    after = np.array([0.0, y, -bend * y * y]) + high * np.array([0.0, -e[2], e[1]])
    before = after - way * e
    # (before − C(y))·C'(y) = 0
    cubic = [-2.0 * bend**2, 0.0, -1.0 - 2.0 * bend * before[2], before[1]]
    start = next(r.real for r in np.roots(cubic) if abs(r.imag) < 1e-12)
    assert joined(body, (0, 0.0, y), (0, 0.0, start), before, after) == fits


@pytest.mark.parametrize(("wide", "good"), [(1.0, True), (0.05, False)])
def test_nothing_is_proved_where_the_element_ends_on_its_other_side_too(wide, good):
    """The ball about a foot on a ridge, 0.11 large, reaches what lies beyond."""
    body = natural_fold(1.0, wide=wide)
    points = (0.0, 0.0, 0.3), (0.0, 0.05, 0.3)
    assert joined(body, (0, 0.0, 0.05), (0, 0.0, 0.0), *points) == good
