"""The strand of an edge in a cell of a trimmed face."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.search.kernels import strand_nb
from contiga.search.tables import tables_of

pytestmark = pytest.mark.interpreted


@njit
def strand_in(trims, patch, cell):
    work = strand_nb.strand_work()
    edge, n = strand_nb.strand_in(trims, patch, cell, work)
    places = np.empty((n, 3, 2))
    for k in range(n):
        for i in range(3):
            found = strand_nb.place_on(work, k, 0.5 * i)
            places[k, i, 0], places[k, i, 1] = found[0], found[1]
    return edge, n, places


def holed():
    """A unit plate with a round hole that an edge names."""
    patch = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(square)
    )
    hole = cg.shapes.circle(radius=0.25, centre=[0.5, 0.5, 0]).reversed()
    edge = BodyEdge(hole, 1e-9, (EdgeUse(0, 1, 0, False),), (hole.domain,))
    return cg.Body([patch], trims=[(outer, (hole,))], edges=[edge])


def test_a_cell_over_the_rim_of_a_hole_holds_its_strand():
    trims = tables_of(holed()).trims
    cell = (0.72, 0.78, 0.45, 0.55)
    edge, n, places = strand_in(trims, 0, cell)
    assert edge == 0
    assert n >= 1
    # places are by the cell's middle and half sides
    u = 0.75 + 0.03 * places[..., 0]
    v = 0.50 + 0.05 * places[..., 1]
    np.testing.assert_allclose(np.hypot(u - 0.5, v - 0.5), 0.25, atol=1e-9)


def test_a_cell_beside_all_edges_holds_none():
    edge, n, _ = strand_in(tables_of(holed()).trims, 0, (0.8, 0.9, 0.1, 0.2))
    assert (edge, n) == (-1, 0)


def test_a_cell_over_the_whole_hole_holds_no_one_strand():
    assert strand_in(tables_of(holed()).trims, 0, (0.2, 0.8, 0.2, 0.8))[0] == -2
