"""Sides of points where the search for the closest point gives up."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning
from contiga.search import inside
from contiga.search.track.project import project as closest
from contiga.statuses import Status


@pytest.fixture
def given_up(monkeypatch):
    """The search answers with a foot on the far side, and says that it was given up."""

    def project(body, points):
        feet = closest(body, points)
        feet.status[:] = Status.BUDGET
        feet.gap[:] = 1.0
        return feet

    monkeypatch.setattr(inside, "project", project)


def test_points_on_the_axis_of_a_long_spheroid_are_inside():
    """All feet of such a point lie on a circle, as near as each other."""
    k = 10.0
    body = cg.Body([cg.shapes.ellipsoid(axes=(k, 1.0, 1.0))])
    x = np.array([0.0, 0.2, -0.6, 0.9]) * k
    for off in (0.0, 1e-9):
        p = np.column_stack([x, np.full(4, off), np.zeros(4)])
        feet = body.project(p)
        assert (feet.status == Status.OK).all()
        assert not feet.certified[1:].any()
        near = np.sqrt(1.0 - x * x / (k * k - 1.0))
        assert np.abs(feet.gap + near).max() <= 2.0 * off + 1e-14 * k
        assert body.contains(p).all()
        assert not body.contains(p + np.array([0.0, 1.1, 0.0])).any()


def test_where_the_search_is_given_up_a_way_from_outside_tells(given_up):
    ball = cg.Body([cg.shapes.sphere(radius=2.0)]).translated([5.0, -3.0, 1.0])
    p = np.random.default_rng(1).uniform(-2.5, 2.5, (200, 3))
    p = np.concatenate([p, [[30.0, 40.0, 50.0], [-1e3, 0.0, 0.0]]])
    truth = np.linalg.norm(p, axis=1) < 2.0
    assert (ball.contains(p + np.array([5.0, -3.0, 1.0])) == truth).all()


def test_of_open_bodies_what_is_not_proved_is_told(given_up):
    plane = cg.Body([cg.shapes.plane()])
    with pytest.warns(ContigaWarning, match="the side of 1 points is not proved"):
        plane.contains([[0.0, 0.0, -0.1]])
