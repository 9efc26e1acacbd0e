"""Whether one branch joins two feet by an edge, or ends there: asked of scenes where it must not.

A point that does not move has minima of its own: no two of them are ever joined. Each scene breaks
one condition of the theorem, and no other.
"""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.folds import at_fold, bent_fold, focal, over, place, trimmed_fold

from contiga.search.certify.kernels import about_edge_nb, edge_nb
from contiga.search.tables import tracking_tables_of

pytestmark = pytest.mark.interpreted


@njit
def over_edge(tables, foot, last, path):
    return edge_nb.over_edge(tables, foot, last, path, about_edge_nb.edge_work())


@njit
def runs_into_fold(tables, last, path):
    return edge_nb.runs_into_fold(tables, last, path, about_edge_nb.edge_work())


def joined(body, foot, last, before, after=None):
    """Whether the feet `last` of a point before its motion and `foot` after it are joined."""
    path = (tuple(before), tuple(before if after is None else after))
    return over_edge(tracking_tables_of(body), at_fold(body, *foot), at_fold(body, *last), path)


def test_two_minima_in_the_hollow_of_one_face_are_not_joined():
    turn, c, bend = 1.2, -0.05, 0.5
    body = bent_fold(turn, bulge=(bend, 0.0), middle=(c, 0.0))
    high, d = focal(bend)
    p = place(turn, 0, c, high - bend * c * c)
    assert not joined(body, (0, c - d, 0.0), (0, c + d, 0.0), p)
    assert not joined(body, (0, c + d, 0.0), (0, c - d, 0.0), p)
    low = [over(turn, bend, c, c + x, 0.3 * high) for x in (-d, d)]
    assert joined(body, (0, c + d, 0.0), (0, c - d, 0.0), *low)


def test_a_minimum_on_the_edge_and_one_in_the_hollow_of_the_other_face_are_not_joined():
    turn, c, bend = 1.2, 0.01, 0.5
    body = bent_fold(turn, bulge=(0.0, bend), middle=(0.0, c))
    high, d = focal(bend)
    p = place(turn, 1, c, high - bend * c * c)
    assert not joined(body, (0, 0.0, 0.0), (1, c + d, 0.0), p)


def test_two_minima_on_a_hollow_edge_are_not_joined():
    """Its faces fall off so steeply that they are not felt to be hollow."""
    body = bent_fold(2.4, bow=1.0)
    high, d = focal(1.0)
    assert not joined(body, (0, 0.0, -d), (0, 0.0, d), (0.0, 0.0, high))
    assert joined(body, (0, 0.0, 0.0), (0, 0.0, 0.0), (0.0, 0.0, 0.8 * high))


@pytest.mark.parametrize("turn", [5e-4, 0.01, 0.5])
def test_two_minima_on_the_inner_side_of_a_fold_are_not_joined(turn):
    """Nor those that are so near to each other that it may be meant to be smooth."""
    body = bent_fold(-turn)
    off = np.sin(0.5 * turn)
    assert not joined(body, (0, -off, 0.0), (1, off, 0.0), (0.0, 0.0, 1.0))


def test_minima_on_two_walls_close_by_are_not_joined():
    """Between them f is known to be convex about each, and the way from one to the other is long:
    round the bottom of a trough that is 0.1 wide and 1.4 deep."""
    turn, c, bend = -1.25, -0.06, 400.0
    body = bent_fold(turn, bulge=(bend, 0.0), middle=(c, 0.0))
    d = np.sqrt((-0.15 + bend * c * c - 0.5 / bend) / bend)
    p = place(turn, 0, c, -0.15)
    assert not joined(body, (0, c + d, 0.0), (0, c - d, 0.0), p)
    near = over(turn, bend, c, c + d - 0.002, d)
    assert joined(body, (0, c + d, 0.0), (0, c + d - 0.002, 0.0), near, p)


def test_what_is_no_foot_is_not_joined():
    """On a roof and its ridge, of a point beside that: f falls from there."""
    body = bent_fold(1.0)
    p = place(1.0, 0, -0.05, 0.2)
    assert joined(body, (0, -0.05, 0.0), (0, -0.02, 0.0), place(1.0, 0, -0.02, 0.2), p)
    assert not joined(body, (0, 0.0, 0.0), (0, -0.02, 0.0), p)
    assert not joined(body, (0, -0.1, 0.0), (0, -0.05, 0.0), p)


@pytest.mark.parametrize(("way", "fits"), [(0.05, True), (0.15, False)])
def test_the_ball_is_twice_as_large_as_the_motion(way, fits):
    """Feet on a ridge that is bent down, of points high above it: they go less far than those do.
    A ball of the feet's size does fit in beside the corner, 0.5 off."""
    bend, y, high = 0.2, 0.5, 3.0
    body = bent_fold(2.0, bow=-bend, bulge=(-bend, -bend))
    e = np.array([0.0, 1.0, -2.0 * bend * y])
    e /= np.linalg.norm(e)
    after = np.array([0.0, y, -bend * y * y]) + high * np.array([0.0, -e[2], e[1]])
    before = after - way * e
    # (before − C(y))·C'(y) = 0
    cubic = [-2.0 * bend**2, 0.0, -1.0 - 2.0 * bend * before[2], before[1]]
    start = next(r.real for r in np.roots(cubic) if abs(r.imag) < 1e-12)
    assert joined(body, (0, 0.0, y), (0, 0.0, start), before, after) == fits


def ends(body, last, before, after):
    return runs_into_fold(
        tracking_tables_of(body), at_fold(body, *last), (tuple(before), tuple(after))
    )


@pytest.mark.parametrize("turn", [1.0, 0.1, -0.1, -1.0])
def test_a_branch_ends_on_the_inner_side_of_a_fold_only(turn):
    body = bent_fold(turn)
    before, short, past = (place(turn, 0, x, 0.2) for x in (-1e-3, -2e-4, 2e-3))
    assert ends(body, (0, -1e-3, 0.0), before, past) == (turn < 0.0)
    assert not ends(body, (0, -1e-3, 0.0), before, short)


@pytest.mark.parametrize(("past", "sure"), [(1e-5, False), (2e-4, True)])
def test_a_branch_ends_where_the_point_is_past_the_edge_by_more_than_its_width(past, sure):
    turn = -1.0
    body = trimmed_fold(turn, 1e-4)
    before, after = place(turn, 0, -1e-3, 0.2), place(turn, 0, past, 0.2)
    assert ends(body, (0, -1e-3, 0.0), before, after) == sure
