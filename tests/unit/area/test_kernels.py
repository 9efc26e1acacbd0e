"""The kernels of the areas, one by one, compiled and interpreted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import contiga as cg
from contiga.area.kernels import components_nb, facet_area_nb, image_nb, touch_nb
from contiga.records import Projection

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


def test_regions_of_a_graph_are_its_connected_components():
    rng = np.random.default_rng(2)
    n = 60
    ends = rng.integers(0, n, (45, 2))
    graph = coo_matrix((np.ones(len(ends)), ends.T), (n, n)).tocsr()
    graph = graph + graph.T
    rows = np.flatnonzero(rng.random(n) < 0.8).astype(np.int32)
    place = np.full(n, -1, np.int32)
    label = components_nb.graph_components(
        graph.indptr.astype(np.int64), graph.indices.astype(np.int32), rows, place
    )
    count, other = connected_components(graph[rows][:, rows], directed=False)
    assert label.max() + 1 == count
    assert len({*zip(label.tolist(), other.tolist(), strict=True)}) == count
    # Numbered as they come.
    assert [label[k] for k in np.unique(label, return_index=True)[1]] == list(range(count))
    assert (np.diff(np.unique(label, return_index=True)[1]) > 0).all()


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
        CORNER, (feet.point, feet.normal), (n_c, np.array([row], np.int32)),
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
