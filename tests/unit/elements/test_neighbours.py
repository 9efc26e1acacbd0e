"""Which element lies across each side, and what kind of joint it is."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.codes import BORDER, CREASE, POLE, SMOOTH
from contiga.elements.kernels import sides_nb
from contiga.search.closest.kernels import around_nb
from contiga.search.tables import tables_of


def rows(*patches):
    return tables_of(cg.Body(list(patches))).elements.table


def check_mutual(table):
    for e, row in enumerate(table):
        for side in range(4):
            other = row["neighbour"][side]
            if other >= 0:
                back = row["neighbour_side"][side]
                assert table[other]["neighbour"][back] == e
                assert table[other]["neighbour_side"][back] == side
                assert table[other]["flip"][back] == row["flip"][side]


@pytest.mark.interpreted
def test_a_plane_is_all_border():
    table = rows(cg.shapes.plane())
    assert (table["kind"] == BORDER).all()
    assert (table["neighbour"] == -1).all()


def test_a_torus_is_smooth_everywhere():
    table = rows(cg.shapes.torus())
    assert (table["kind"] == SMOOTH).all()
    check_mutual(table)


def test_a_sphere_has_two_poles_and_a_smooth_seam():
    table = rows(cg.shapes.sphere())
    assert set(np.unique(table["kind"])) == {SMOOTH, POLE}
    assert (table["kind"] == POLE).sum() == 8
    check_mutual(table)
    for start in np.argwhere(table["kind"] == POLE):
        link, length = table[start[0]]["ring"][start[1]], 1
        while link != 4 * start[0] + start[1]:
            link, length = table[link // 4]["ring"][link % 4], length + 1
        assert length == 4


def test_a_pole_is_round_where_the_surface_closes_in_one_tangent_plane():
    ball, cone = cg.shapes.sphere(), cg.shapes.cone()
    quarter = ball.restricted((0.0, 0.25), ball.domain[1])
    corners = np.array([[1.0, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0], [0.3, 0, 1.0]])
    needle = [cg.shapes.bilinear(*corners[[i, j, k, k]]) for i, j, k in ((0, 1, 3), (1, 2, 3))]
    triangles = [*needle, cg.shapes.bilinear(*corners[[2, 0, 3, 3]])]
    for patches, is_round in (
        ([ball], 1),
        ([cone], 0),
        ([quarter], 0),
        (triangles, 0),
        (needle, 0),
    ):
        table = rows(*patches)
        pole = table["kind"] == POLE
        assert pole.any()
        assert (table["round"] == np.where(pole, is_round, 0)).all()


@pytest.mark.parametrize("turn", ["as is", "flipped", "transposed", "both"])
def test_patches_join_however_they_run(turn):
    left, right = cg.shapes.bumpy_plate().split(u=0.5)
    if turn in ("flipped", "both"):
        right = right.flipped()
    if turn in ("transposed", "both"):
        right = right.transposed()
    table = rows(left, right)
    check_mutual(table)
    across_side = table["patch"][table["neighbour"]] != table["patch"][:, None]
    across_side &= table["neighbour"] >= 0
    assert across_side.sum() > 0
    # A patch whose normal is turned over meets the other at a kink: its free side is the other.
    kind = SMOOTH if turn in ("as is", "both") else CREASE
    assert (table["kind"][across_side] == kind).all()
    elements = tables_of(cg.Body([left, right])).elements
    points, _ = sides_nb.sample(elements)
    for e, side in np.argwhere(across_side):
        for x in (-0.5, 0.1):
            s, t = sides_nb.side_point(side, x)
            e2, s2, t2, _ = around_nb.cross(elements, e, side, s, t)
            a, b = (body_point(elements, *place) for place in ((e, s, t), (e2, s2, t2)))
            np.testing.assert_allclose(a, b, atol=1e-12)
    assert len(points) == len(table)


def body_point(elements, e, s, t):
    from contiga.elements.kernels.element_nb import evaluate

    h = np.empty((4, 6))
    evaluate(elements, e, s, t, h)
    return h[:3, 0] + elements.table[e]["origin"]
