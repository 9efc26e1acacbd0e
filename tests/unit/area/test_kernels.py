"""The kernels of the areas, one by one, compiled and interpreted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import contiga as cg
from contiga.area import _facet_nb, _jacobian_nb, _touch_nb, _union_nb
from contiga.area.facet import images_of
from contiga.area.polygon import area_over
from contiga.records import Projection
from contiga.search.surface import surface_of

pytestmark = pytest.mark.interpreted

FACETS = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [6, 7, 8]], np.int32)


def test_every_facet_is_listed_at_its_corners():
    first, incident = _touch_nb.incidence(FACETS, 10)
    for i in range(10):
        own = incident[first[i] : first[i + 1]]
        assert own.tolist() == [f for f, facet in enumerate(FACETS.tolist()) if i in facet]


def test_corners_of_cut_facets_are_numbered_those_in_contact_first():
    # Points 1, 2 and 6 touch; facet 3 has no part in it.
    place = np.full(9, -1, np.int32)
    place[[1, 2, 6]] = [0, 1, 2]
    points = np.array([[k, k * k % 5, 0.0] for k in range(9)])
    part = np.array([0, 1, 2, 4], np.int32)
    found, corner, inner, free, start = _touch_nb.around(FACETS, part, points, place)
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
    found, *_ = _touch_nb.around(FACETS, np.array([0, 1, 2], np.int32), points, place)
    assert found.tolist() == [2]


def test_regions_of_a_graph_are_its_connected_components():
    rng = np.random.default_rng(2)
    n = 60
    ends = rng.integers(0, n, (45, 2))
    graph = coo_matrix((np.ones(len(ends)), ends.T), (n, n)).tocsr()
    graph = graph + graph.T
    rows = np.flatnonzero(rng.random(n) < 0.8).astype(np.int32)
    place = np.full(n, -1, np.int32)
    label = _union_nb.graph_components(
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
    border = _facet_nb.cuts(corner, feet, 1, fraction)
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


def feet_at(body, surface, uv, patch=0):
    n = len(uv)
    return Projection(
        np.full(n, patch, np.int32), uv, surface.evaluate(uv), surface.normal(uv), np.zeros(n),
        np.zeros(n, np.int8), np.zeros(n, np.int8), np.zeros(n, np.int8),
    )  # fmt: skip


def pieces(images, patch, n_c, fraction, row=(-1, -1, -1)):
    """Shares of one facet with corners 0, 1, 2."""
    share = np.empty((1, 3))
    _jacobian_nb.master_pieces(
        np.array([[0, 1, 2]], np.int32), patch, images, (n_c, np.array([row], np.int32)),
        np.array([fraction], dtype=float), share, 0, 1,
    )  # fmt: skip
    return share[0]


@pytest.mark.parametrize(
    ("n_c", "fraction", "cut"),
    [
        (1, (0.3, 1.0, 0.7), [(0, None), (0, 1, 0.3), (0, 2, 0.7)]),
        (2, (1.0, 0.4, 0.8), [(0, None), (1, None), (1, 2, 0.4), (0, 2, 0.8)]),
    ],
)
def test_one_cut_facet_has_the_area_of_its_image_to_third_order(n_c, fraction, cut):
    surface = bowl()
    body = cg.Body([surface])
    errors = []
    for h in (0.1, 0.05, 0.025):
        uv = np.array([[0.4, 0.3], [0.4 + h, 0.3 + 0.2 * h], [0.4 + 0.1 * h, 0.3 + h]])
        feet = feet_at(body, surface, uv)
        share = pieces(images_of(surface_of(body), feet), feet.patch, n_c, fraction)
        polygon = [
            uv[c[0]] if c[1] is None else uv[c[0]] + c[2] * (uv[c[1]] - uv[c[0]]) for c in cut
        ]
        exact = area_over(surface, np.array(polygon), (0.0, 0.0))
        errors.append(abs(share.sum() / exact - 1.0))
        assert (share[n_c:] == 0.0).all()
        assert (share[:n_c] > 0.0).all()
    assert np.log2(errors[0] / errors[2]) / 2.0 > 2.8
    assert errors[2] < 1e-5


def test_a_whole_facet_is_shared_by_the_jacobian_at_its_corners():
    surface = bowl()
    body = cg.Body([surface])
    uv = np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]])
    feet = feet_at(body, surface, uv)
    images = images_of(surface_of(body), feet)
    share = np.empty((1, 3))
    corner = np.array([[0, 1, 2]], np.int32)
    _jacobian_nb.master_whole(corner, feet.patch, images, share, 0, 1)
    assert share.sum() == pytest.approx(area_over(surface, uv, (0.0, 0.0)), rel=3e-5)
    # ∫ J λ_k of a linear J: (J_a + J_b + J_c + J_k) times a twelfth of the facet in (u, v).
    weight = images[:, 0].sum() + images[:, 0]
    assert share[0] / share.sum() == pytest.approx(weight / weight.sum(), rel=1e-12)
    # As a facet of which nothing is cut off.
    assert pieces(images, feet.patch, 3, (1, 1, 1)) == pytest.approx(share[0], rel=1e-12)


@pytest.mark.parametrize("why", ["two patches", "a seam", "a corner of no patch"])
def test_facets_without_one_image_are_measured_by_the_plane_triangle_of_their_feet(why):
    surface = bowl()
    body = cg.Body([surface])
    uv = np.array([[0.4, 0.3], [0.44, 0.31], [0.405, 0.35]])
    feet = feet_at(body, surface, uv)
    images = images_of(surface_of(body), feet)
    patch = feet.patch
    if why == "two patches":
        patch = np.array([0, 1, 0], np.int32)
    elif why == "a seam":
        images[1, 3] += 5.0
    else:
        patch = np.array([0, -1, 0], np.int32)
    a, b, c = feet.point
    flat = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
    share = np.empty((1, 3))
    _jacobian_nb.master_whole(np.array([[0, 1, 2]], np.int32), patch, images, share, 0, 1)
    assert share[0] == pytest.approx(np.full(3, flat / 3.0), rel=1e-12)
    # With a corner cut off halfway: a quarter of it.
    cut = pieces(images, patch, 1, (0.5, 1, 0.5))
    assert cut == pytest.approx([flat / 4.0, 0.0, 0.0], rel=1e-12)


def test_a_cut_on_a_border_is_where_the_foot_left():
    surface = bowl()
    body = cg.Body([surface])
    # Rows 3 and 4 are the feet at the ends of the edges; corners 1 and 2 have none.
    uv = np.array([[0.4, 0.3], [0.9, 0.9], [0.9, 0.9], [0.43, 0.31], [0.405, 0.34]])
    feet = feet_at(body, surface, uv)
    images = images_of(surface_of(body), feet)
    share = pieces(images, feet.patch, 1, (0.5, 1, 0.6), (3, -1, 4))
    exact = area_over(surface, uv[[0, 3, 4]], (0.0, 0.0))
    assert share == pytest.approx([exact, 0.0, 0.0], rel=3e-5)
