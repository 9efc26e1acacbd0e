"""Facets that contact touches, and the numbers of their corners."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.area.kernels import touch_nb

pytestmark = pytest.mark.interpreted


FACETS = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [6, 7, 8]], np.int32)


def test_every_facet_is_listed_at_its_corners():
    first, incident = touch_nb.incidence(FACETS, 10)
    for i in range(10):
        own = incident[first[i] : first[i + 1]]
        assert own.tolist() == [f for f, facet in enumerate(FACETS.tolist()) if i in facet]


def test_corners_of_cut_facets_are_numbered_those_in_contact_first():
    # Points 1, 2 and 6 touch; facet 3 has no part in it.
    place = np.full(9, -1, np.int32)
    place[[1, 2, 6]] = [0, 1, 2]
    points = np.array([[k, k * k % 5, 0.0] for k in range(9)])
    part = np.array([0, 1, 2, 4], np.int32)
    found, corner, inner, free, start = touch_nb.around(FACETS, part, points, place)
    assert found.tolist() == [0, 1, 2, 4]
    assert inner.tolist() == [0, 1, 2]
    nodes = np.concatenate([np.array([1, 2, 6])[inner], free])
    assert np.array_equal(nodes[corner], FACETS[found])
    # Each free corner starts from its nearest neighbour in contact.
    for f, s in zip(free, start, strict=True):
        mates = {int(c) for t in FACETS[found] if f in t for c in t if place[c] >= 0}
        nearest = min(mates, key=lambda c: np.linalg.norm(points[c] - points[f]))
        assert [1, 2, 6][inner[s]] == nearest


def test_facets_with_a_corner_that_is_nowhere_are_left_out():
    place = np.full(9, -1, np.int32)
    place[2] = 0
    points = np.zeros((9, 3))
    points[1] = np.nan
    found, *_ = touch_nb.around(FACETS, np.array([0, 1, 2], np.int32), points, place)
    assert found.tolist() == [2]
