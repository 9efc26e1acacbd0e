"""The Jacobian at feet and its integral over facets that touch as a whole."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area import _facet_nb, _jacobian_nb, _touch_nb, _union_nb
from contiga.area.base import AreaInput, Rest
from contiga.area.polygon import area_over
from contiga.area.regions import topology_of
from contiga.search.projection import bin_by_element
from contiga.search.tables import tables_of


def surfaces():
    rng = np.random.default_rng(0)
    x = np.linspace(0.0, 1.0, 7)
    net = np.stack([*np.meshgrid(x, x, indexing="ij"), 0.1 * rng.normal(size=(7, 7))], axis=-1)
    knots = np.array([0, 0, 0, 0, 0.2, 0.5, 0.7, 1, 1, 1, 1.0])
    weights = rng.uniform(0.5, 2.0, (7, 7))
    yield "polynomial", cg.NurbsSurface((3, 3), (knots, knots), net)
    yield "rational", cg.NurbsSurface((3, 3), (knots, knots), net, weights)
    yield "degree 4", cg.NurbsSurface((3, 3), (knots, knots), net, weights).elevate(u=1, v=1)


def density_of(surface, uv):
    body = cg.Body([surface])
    tables = tables_of(body)
    bins = bin_by_element(tables, np.zeros(len(uv), np.int32), uv)
    images, point = np.zeros((len(uv), 8)), surface.evaluate(uv)
    _jacobian_nb.jacobians(tables.elements, uv, point, bins, images, 0, len(bins[1]))
    assert np.array_equal(images[:, 3:], np.column_stack([uv, point]))
    return images[:, :3]


@pytest.mark.interpreted
@pytest.mark.parametrize("named", list(surfaces()), ids=lambda s: s[0])
def test_jacobian_and_its_slopes_are_those_of_the_surface(named):
    surface = named[1]
    uv = np.random.default_rng(1).uniform(0.01, 0.99, (19, 2))

    def size(uv):
        d = surface.derivatives(uv, 1)
        return np.linalg.norm(np.cross(d[:, 1, 0], d[:, 0, 1]), axis=1)

    density = density_of(surface, uv)
    h = 1e-6
    assert density[:, 0] == pytest.approx(size(uv), rel=1e-12)
    for axis in range(2):
        step = h * np.eye(2)[axis]
        slope = (size(uv + step) - size(uv - step)) / (2 * h)
        assert density[:, 1 + axis] == pytest.approx(slope, rel=1e-5, abs=1e-5)


def sheet(surface, n):
    """Nodes inside a surface, over a part of it that lines up with nothing, and their facets."""
    x = np.linspace(0.11, 0.83, n + 1)
    uv = np.stack(np.meshgrid(x, x + 0.05, indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(uv), dtype=np.int32).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return uv, surface.evaluate(uv) - 0.01 * surface.normal(uv), facets


def test_whole_facets_are_measured_to_fourth_order():
    # A bicubic without inner knots, where the Jacobian is smooth.
    rng = np.random.default_rng(4)
    x = np.linspace(0.0, 1.0, 4)
    net = np.stack([*np.meshgrid(x, x, indexing="ij"), 0.2 * rng.normal(size=(4, 4))], axis=-1)
    knots = np.array([0, 0, 0, 0, 1, 1, 1, 1.0])
    surface = cg.NurbsSurface((3, 3), (knots, knots), net)
    square = np.array([[0.11, 0.16], [0.83, 0.16], [0.83, 0.88], [0.11, 0.88]])
    exact = area_over(surface, square, (0.0, 0.0))
    sizes, errors = (8, 16, 32, 64), []
    for n in sizes:
        _, nodes, facets = sheet(surface, n)
        body = cg.Body([surface])
        feet = body.project(nodes)
        rows = np.arange(len(nodes), dtype=np.int32)
        area = cg.FacetArea("master")
        kept = area.prepare(Rest(nodes, facets, None))
        found = area.measure(AreaInput(body, rows, nodes, feet, None, "master", kept))
        errors.append(abs(found.area.sum() / exact - 1.0))
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] >= 3.7
    assert errors[-1] < 1e-7


def test_a_facet_on_a_plane_is_split_alike():
    plate = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    nodes = np.array([[0.0, 0, -0.1], [0.5, 0, -0.1], [0.0, 0.4, -0.1]])
    area = cg.FacetArea("master")
    kept = area.prepare(Rest(nodes, np.array([[0, 1, 2]], np.int32), None))
    rows = np.arange(3, dtype=np.int32)
    found = area.measure(AreaInput(plate, rows, nodes, plate.project(nodes), None, "master", kept))
    assert found.area == pytest.approx(np.full(3, 0.1 / 3.0), rel=1e-12)


FACETS = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [6, 7, 8]], np.int32)


@pytest.mark.interpreted
@pytest.mark.parametrize("rows", [[0, 1, 2], [1, 2, 3, 4], [7], list(range(9)), []])
def test_facets_are_sorted_by_their_corners_in_contact(rows):
    place = np.full(9, -1, np.int32)
    whole, part = _touch_nb.touched(topology_of(FACETS, 9), np.array(rows, np.int32), place)
    count = np.isin(FACETS, rows).sum(axis=1)
    back = np.array(rows, np.int32)
    assert sorted(map(tuple, back[whole].tolist())) == sorted(map(tuple, FACETS[count == 3]))
    assert sorted(part.tolist()) == np.flatnonzero((count > 0) & (count < 3)).tolist()


@pytest.mark.interpreted
def test_regions_are_joined_over_whole_and_cut_facets():
    whole = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    corner = np.array([[-1, 6, 7], [-1, 8, -1]], np.int32)
    assert _union_nb.facet_components(whole, corner, 9).tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 3]


@pytest.mark.interpreted
def test_whole_facets_on_the_slave_are_split_alike():
    points = np.array([[9.0, 9, 9], [0, 0, 0], [2, 0, 0], [0, 3, 0]])
    corner = np.array([[0, 1, 2]], np.int32)
    share = np.empty((1, 3))
    _facet_nb.slave_whole(np.array([1, 2, 3], np.int32), points, corner, share, 0, 1)
    area = np.zeros(3)
    _facet_nb.gather(corner, share, area)
    assert area.tolist() == [1.0, 1.0, 1.0]
