"""Triangles between polygons with holes: area, border and sides as they should be."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import contiga as cg


def plate(holes):
    curves = [cg.shapes.circle(radius=r, centre=[x, y, 0.0]).reversed() for x, y, r in holes]
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(corners)
    )
    patch = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    return cg.Body([patch], trims=[(outer, *((curve,) for curve in curves))])


HOLES = [(0.25, 0.25, 0.15), (0.7, 0.3, 0.1), (0.5, 0.72, 0.2)]


@pytest.mark.parametrize("count", [0, 1, 3])
def test_holes_are_left_out_and_nothing_else(count):
    holes = HOLES[:count]
    mesh = plate(holes).tessellate(1e-4)
    true = 1.0 - math.pi * sum(r * r for _, _, r in holes)
    # chords of a circle of radius r cut off less than their height all round
    assert mesh.area() == pytest.approx(true, abs=2 * math.pi * 1e-4 * 0.45 * max(1, count))
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    for x, y, r in holes:
        assert (np.hypot(middles[:, 0] - x, middles[:, 1] - y) > 0.9 * r).all()


def test_every_inner_side_is_between_two_triangles_and_the_border_is_closed():
    mesh = plate(HOLES).tessellate(1e-3)
    pairs = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(pairs, axis=0, return_counts=True)
    assert set(count.tolist()) == {1, 2}
    border = mesh.open_edges()
    assert (np.bincount(border.ravel())[np.unique(border)] == 2).all()
    # Euler: one face with three holes
    assert len(mesh.vertices) - len(count) + len(mesh.triangles) == 1 - 3
