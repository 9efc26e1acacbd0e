"""The kernels of the areas, one by one, compiled and interpreted."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area.kernels import facet_area_nb, image_nb
from contiga.records import Projection

pytestmark = pytest.mark.interpreted


def test_cuts_are_where_the_gap_between_their_ends_is_zero():
    # Corner 0 is in contact, 0.2 deep; 1 is 0.6 above, 2 inside without contact, 3 has left.
    gap = np.array([-0.2, 0.6, -0.1, 0.3])
    status = np.array([0, 0, 0, 1], np.int8)
    feet = Projection(
        np.zeros(4, np.int32), np.zeros((4, 2)), np.zeros((4, 3)), np.zeros((4, 3)), gap,
        np.zeros(4, np.int8), status, np.zeros(4, np.int8),
    )  # fmt: skip
    corner = np.array([[0, 1, 2], [1, 0, 3]], np.int32)
    fraction = np.empty((2, 3))
    border = facet_area_nb.cuts(corner, feet, 1, fraction)
    assert border.tolist() == [4]  # of the second facet the edge from 0 to 3
    assert fraction[0].tolist() == pytest.approx([0.25, 1.0, 0.5])
    assert fraction[1, 0] == pytest.approx(0.25)


def bowl():
    """A rational bicubic without inner knots."""
    rng = np.random.default_rng(5)
    x = np.linspace(0.0, 1.0, 4)
    net = np.stack([*np.meshgrid(x, x, indexing="ij"), 0.3 * rng.normal(size=(4, 4))], axis=-1)
    knots = np.array([0, 0, 0, 0, 1, 1, 1, 1.0])
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.7, 1.4, (4, 4)))


def feet_at(surface, uv, patch=0):
    n = len(uv)
    return Projection(
        np.full(n, patch, np.int32), uv, surface.evaluate(uv), surface.normal(uv), np.zeros(n),
        np.zeros(n, np.int8), np.zeros(n, np.int8), np.zeros(n, np.int8),
    )  # fmt: skip


CORNER = np.array([[0, 1, 2]], np.int32)


def whole(feet):
    """Shares of one facet with corners 0, 1, 2, all in contact."""
    share = np.empty((1, 3))
    image_nb.image_whole(CORNER, feet.point, feet.normal, share, 0, 1)
    return share[0]


def pieces(feet, n_c, fraction, row=(-1, -1, -1)):
    """Shares of one facet with corners 0, 1, 2."""
    share = np.empty((1, 3))
    image_nb.image_pieces(
        CORNER, feet, n_c, np.array([row], np.int32),
        np.array([fraction], dtype=float), share, 0, 1,
    )  # fmt: skip
    return share[0]


def test_a_whole_facet_is_shared_as_one_of_which_nothing_is_cut_off():
    surface = bowl()
    uv = np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]])
    feet = feet_at(surface, uv)
    share = whole(feet)
    assert pieces(feet, 3, (1, 1, 1)) == pytest.approx(share, rel=1e-12)


def test_corners_are_given_the_integrals_of_their_shape_functions():
    uv = np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]])
    share = whole(feet_at(cg.shapes.plane(), uv))
    assert share == pytest.approx(np.full(3, share[0]), rel=1e-12)
    # A bowl's are not alike: more of the area lies where it is steep.
    feet = feet_at(bowl(), np.array([[0.1, 0.1], [0.5, 0.15], [0.15, 0.5]]))
    steep = whole(feet)
    assert np.ptp(steep) > 0.01 * steep.mean()
    turned = feet._replace(point=feet.point[[1, 2, 0]], normal=feet.normal[[1, 2, 0]])
    assert whole(turned) == pytest.approx(steep[[1, 2, 0]], rel=1e-12)


def test_a_facet_whose_image_is_torn_is_measured_by_the_plane_triangle_of_its_feet():
    surface = bowl()
    feet = feet_at(surface, np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]]))
    feet.normal[1] *= -1.0
    a, b, c = feet.point
    flat = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
    assert whole(feet) == pytest.approx(np.full(3, flat / 3.0), rel=1e-12)
    # Normals that cancel, at a corner and at cuts.
    feet.normal[1] = -feet.normal[0]
    feet.normal[2] = -feet.normal[0]
    assert whole(feet) == pytest.approx(np.full(3, flat / 3.0), rel=1e-12)
    assert pieces(feet, 1, (0.5, 1, 0.5)) == pytest.approx([flat / 4.0, 0.0, 0.0], rel=1e-12)
    feet = feet_at(surface, np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]]))
    feet.normal[1] *= -1.0
    # With a corner cut off halfway: a quarter of it. One cut is on an edge that is not torn.
    cut = pieces(feet, 1, (0.5, 1, 0.5))
    assert cut == pytest.approx([flat / 4.0, 0.0, 0.0], rel=1e-4)


def test_a_cut_on_a_border_is_where_the_foot_left():
    surface = bowl()
    # Rows 3 and 4 are the feet at the ends of the edges; corners 1 and 2 have none.
    uv = np.array([[0.4, 0.3], [0.9, 0.9], [0.9, 0.9], [0.43, 0.31], [0.405, 0.34]])
    feet = feet_at(surface, uv)
    share = pieces(feet, 1, (0.5, 1, 0.6), (3, -1, 4))
    one = feet_at(surface, uv[[0, 3, 4]])
    assert share == pytest.approx([whole(one).sum(), 0.0, 0.0], rel=1e-12)
