"""Meshes as they come: open, crowded, turned, doubled, flat triangles, vertices of none."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import Status, TriMesh
from contiga.errors import MeshError
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.topology import topology_of

SLAVE = cg.Slave([[0.0, 0.0, 1.0]], area=[1.0])
LAW = cg.PenaltyLaw(1.0)


def test_vertices_at_one_place_are_one(oracle):
    box = oracle.box()
    soup = TriMesh(box.corners().reshape(-1, 3), np.arange(36).reshape(-1, 3))
    assert tables_of(box).closed
    assert tables_of(soup).closed
    points = np.random.default_rng(0).normal(size=(200, 3))
    for a, b in zip(box.project(points), soup.project(points), strict=True):
        np.testing.assert_array_equal(a, b)


def test_an_open_mesh_is_known_as_such(oracle):
    box = oracle.box()
    lid_off = TriMesh(box.vertices, box.triangles[:10])
    tables = tables_of(lid_off)
    assert not tables.closed
    assert (tables.facets.link[:, :3] == -1).sum() == 4
    assert tables.facets.corner[:, 3].sum() == 4


def test_vertices_of_no_triangle_do_not_count(oracle):
    box = oracle.box()
    more = TriMesh(np.vstack([box.vertices, [[99.0, 99.0, 99.0]]]), box.triangles)
    np.testing.assert_array_equal(more.bounds(), box.bounds())
    assert more.size == box.size
    np.testing.assert_array_equal(more.project([[3, 1, 1]]).gap, box.project([[3, 1, 1]]).gap)
    assert len(more.compact().vertices) == 8


def test_triangles_given_twice_count_once(oracle):
    box = oracle.box()
    twice = TriMesh(box.vertices, np.vstack([box.triangles, np.roll(box.triangles, 1, axis=1)]))
    tables = tables_of(twice)
    assert tables.closed
    assert topology_of(twice).crowded == 0
    assert len(tables.facets.link) == 12
    points = np.random.default_rng(1).normal(size=(50, 3))
    feet = twice.project(points)
    np.testing.assert_array_equal(feet.patch, box.project(points).patch)
    second = feet._replace(patch=feet.patch + np.int32(12))
    np.testing.assert_array_equal(twice.project(points, start=second, mode="track").gap, feet.gap)


def test_flat_triangles_join_what_is_around_them():
    # A T-junction closed by a triangle without area: the lower triangle meets two upper ones.
    vertices = [[0, 0, 0], [2, 0, 0], [1, 0, 0], [1, -1, 0], [0, 1, 0], [2, 1, 0]]
    good = [[0, 3, 1], [0, 2, 4], [2, 1, 5], [2, 5, 4]]
    with_gap = TriMesh(vertices, good)
    joined = TriMesh(vertices, [*good, [0, 1, 2]])
    assert (tables_of(with_gap).facets.link[:, :3] == -1).sum() == 8
    assert (tables_of(joined).facets.link[:, :3] == -1).sum() == 5
    start = joined.project([[0.9, -0.3, 0.1]])
    for x in (0.5, 1.0, 1.5):
        feet = joined.project([[x, 0.2, 0.1]], start=start, mode="track")
        assert feet.status[0] == Status.OK
        assert feet.gap[0] == pytest.approx(0.1, abs=1e-15)
    start = with_gap.project([[1, -0.3, 0.1]])
    stuck = with_gap.project([[0.5, 0.2, 0.1]], start=start, mode="track")
    assert stuck.status[0] == Status.BORDER


def test_a_foot_given_on_a_flat_triangle_is_found_anew(oracle):
    box = oracle.box()
    mesh = TriMesh(box.vertices, [[0, 1, 1], *box.triangles])
    feet = mesh.project([[0.1, 0.2, 2.0]])
    assert feet.patch[0] > 0
    flat = feet._replace(patch=np.array([0], np.int32))
    np.testing.assert_array_equal(
        mesh.project([[0.1, 0.2, 2.0]], start=flat, mode="track").point, feet.point
    )


def test_where_three_triangles_meet_the_walk_tries_all():
    # A T of three leaves along the y axis.
    vertices = [[x, y, z] for x, z in ((0, 0), (1, 0), (-1, 0), (0, 1)) for y in (0, 1)]
    leaves = [[0, 2, 1], [2, 3, 1], [0, 1, 4], [1, 5, 4], [0, 6, 1], [6, 7, 1]]
    mesh = TriMesh(vertices, leaves)
    assert topology_of(mesh).crowded == 1
    start = mesh.project([[0.5, 0.5, -0.1]])
    assert start.patch[0] < 2
    for point, expected in (([-0.6, 0.5, -0.1], {2, 3}), ([-0.02, 0.5, 0.7], {4, 5})):
        feet = mesh.project([point], start=start, mode="track")
        assert feet.patch[0] in expected


def test_triangles_that_face_opposite_ways_are_refused_as_a_master_and_can_be_turned(oracle):
    box = oracle.box()
    triangles = box.triangles.copy()
    triangles[[3, 7]] = triangles[[3, 7], ::-1]
    mixed = TriMesh(box.vertices, triangles, name="crate")
    with pytest.raises(MeshError, match=r"crate: neighbouring triangles face opposite ways; found"):
        cg.Contact(mixed, SLAVE, law=LAW)
    # Distances need no sides.
    assert abs(mixed.project([[0.1, 0.2, 2.0]]).gap[0]) == 1.5
    turned = mixed.oriented()
    assert turned.volume() == pytest.approx(1.0)
    assert turned.surface.closed


def test_a_mesh_without_a_surface_is_refused_as_a_master():
    with pytest.raises(MeshError, match="without triangles"):
        cg.Contact(TriMesh([], []), SLAVE, law=LAW)


def test_slivers_have_the_normal_of_their_plane():
    sliver = TriMesh([[0, 0, 0], [1, 0, 0], [0.5, 1e-7, 0]], [[0, 1, 2]])
    feet = sliver.project([[0.5, 0.2e-7, 0.3], [0.5, 1.0, 0.0]])
    np.testing.assert_allclose(feet.normal[0], [0, 0, 1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.abs(feet.gap), [0.3, 1.0 - 1e-7], rtol=0, atol=1e-12)
