"""Triangles between polygons, by cutting ears."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.geometry.kernels import ears_nb

pytestmark = pytest.mark.interpreted


def area(xy, triangles):
    a, b, c = (xy[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_a_star_is_cut_into_ears_of_its_area():
    angle = np.arange(10) * np.pi / 5
    xy = np.where(np.arange(10) % 2, 0.4, 1.0)[:, None] * np.stack(
        [np.cos(angle), np.sin(angle)], 1
    )
    actual = ears_nb.ears(xy, ears_nb.one_ring(xy, np.array([0, 10])))
    assert actual.shape == (8, 3)
    signed = area(xy, actual)
    assert (signed > 0.0).all()
    x, y = xy.T
    outline = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    assert signed.sum() == pytest.approx(outline, rel=1e-14)


def test_a_hole_joins_the_ring_and_takes_no_area():
    outer = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    hole = np.array([[1.0, 1], [1, 2], [2, 2], [2, 1]])
    xy = np.concatenate([outer, hole])
    ring = ears_nb.one_ring(xy, np.array([0, 4, 8]))
    assert len(ring) == 10
    # there and back between the two vertices that are nearest to each other: 0 and 4, or 2 and 6
    assert ring.tolist()[:2] == [0, 4]
    assert ring.tolist()[4:7] == [7, 4, 0] or ring.tolist()[4:7] == [5, 4, 0]
    assert sorted(set(ring.tolist())) == list(range(8))
    actual = ears_nb.ears(xy, ring)
    assert area(xy, actual).sum() == pytest.approx(15.0, rel=1e-14)
