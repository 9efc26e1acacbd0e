"""Parts of elements, and what a neighbourhood takes over of them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search import plain

import contiga as cg
from contiga.search.certify.kernels import part_nb
from contiga.search.hierarchy.table_types import NEIGHBOURHOOD

pytestmark = pytest.mark.interpreted


@njit
def part_of(s, t):
    return part_nb.part_of(s, t)


@njit
def take(neighbourhood, bend, scale_s, scale_t):
    part_nb.add_curvature(neighbourhood, bend)
    part_nb.add_metric(neighbourhood, bend, scale_s, scale_t)


@njit
def adjoins(elements, e, n, side):
    return part_nb.adjoins(elements, e, n, side), part_nb.is_untrimmed_beyond(elements, e, n)


def test_parts_are_numbered_along_t_first_and_sides_belong_to_the_last():
    assert [part_of(s, t) for s, t in ((-0.5, -0.5), (-0.4, 0.3), (0.1, -0.3), (0.5, 0.5))] == [
        *(0, 3, 8, 15)
    ]
    assert part_of(-0.7, 0.9) == 3


def test_a_neighbourhood_takes_the_largest_curvatures_and_speeds_and_the_least_widths():
    neighbourhood = np.zeros(1, NEIGHBOURHOOD)[0]
    neighbourhood["width"] = np.inf
    take(neighbourhood, np.array([1.0, 0.0, 3.0, 4.0, 2.0, 3.0]), 1.0, 2.0)
    take(neighbourhood, np.array([0.5, 0.7, 1.0, 9.0, 5.0, 0.5]), 2.0, 1.0)
    for name, told in (("curvature", [1.0, 0.7]), ("speed", [3.0, 9.0]), ("width", [2.0, 0.5])):
        np.testing.assert_array_equal(neighbourhood[name], told)


def test_elements_adjoin_within_a_patch_and_not_over_its_seam():
    elements = plain.joined(cg.Body([cg.shapes.torus()])).elements
    table = elements.table
    for e, side in ((0, 1), (0, 0)):
        n = int(table["neighbour"][e, side])
        same, whole = adjoins(elements, e, n, side)
        assert same == (table["box"][n][side ^ 1] == table["box"][e][side])
        assert whole
    assert not adjoins(elements, 0, int(table["neighbour"][0, 0]), 0)[0]
