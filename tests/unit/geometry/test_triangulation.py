"""Turns and products whose signs are exact, and walks in a triangulation."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from numba import njit

from contiga.geometry.kernels import triangulation_nb

pytestmark = pytest.mark.interpreted


@njit
def product(a, b):
    return triangulation_nb.two_product(a, b)


@njit
def cross(ax, ay, bx, by):
    return triangulation_nb.cross(ax, ay, bx, by)


@njit
def cross_sum(xy, m):
    return triangulation_nb.cross_sum(xy, 0, 1, 2, 3, m)


def test_a_product_and_its_remainder_are_exact():
    for a, b in np.random.default_rng(0).normal(size=(50, 2)):
        p, rest = product(a, b)
        assert p == a * b
        assert Fraction(p) + Fraction(rest) == Fraction(a) * Fraction(b)


def test_signs_are_exact_on_the_grid():
    grid = triangulation_nb.GRID
    for k in np.random.default_rng(1).integers(-(2**18), 2**18, (200, 2)):
        a = (1.0 + k[0] * grid, 1.0 + k[1] * grid)
        b = (a[0] + grid, a[1] + grid)
        exact = Fraction(a[0]) * Fraction(b[1]) - Fraction(a[1]) * Fraction(b[0])
        assert np.sign(cross(*a, *b)) == np.sign(exact)


def test_points_in_the_circle_are_told_from_those_outside():
    """In the metric (4, 0, 1) the circle is an ellipse, half as wide as high."""
    ring = np.array([[math.cos(t), math.sin(t)] for t in (0.0, 1.5, 4.0)])
    for x, y in np.random.default_rng(2).uniform(-1.5, 1.5, (200, 2)):
        if abs(x * x + y * y - 1.0) < 1e-6:
            continue
        # d lies across the side bc from a: turned so that this is so
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            side = ring[c] - ring[b]
            off = side[0] * (y - ring[b, 1]) - side[1] * (x - ring[b, 0])
            if off < -1e-6:
                xy = np.array([ring[a], ring[b], ring[c], [x, y]])
                inside = x * x + y * y < 1.0
                assert (cross_sum(xy, (1.0, 0.0, 1.0)) < 0.0) == inside
                assert (cross_sum(xy * [0.5, 1.0], (4.0, 0.0, 1.0)) < 0.0) == inside
