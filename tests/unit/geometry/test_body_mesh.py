"""Faces meshed on their own and joined: no cracks at shared edges, nothing moved away from them."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import Body, shapes
from contiga.errors import InputError
from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.edges import BodyEdge, EdgeUse

pytestmark = pytest.mark.usefixtures("kept")


def box() -> Body:
    return Body([shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3), *-np.eye(3))])


def open_edges(mesh: cg.TriMesh) -> int:
    return len(mesh.open_edges())


def test_a_box_of_six_patches_is_one_closed_mesh():
    mesh = box().tessellate(0.01)
    assert open_edges(mesh) == 0
    assert len(mesh.vertices) == 8
    assert mesh.volume() == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("method", ["chord", "net"])
def test_closed_faces_that_meet_only_themselves_stay_closed(method):
    balls = Body([shapes.sphere(radius=1.0, centre=(x, 0.0, 0.0)) for x in (-2.0, 2.0)])
    mesh = balls.tessellate(0.01, method=method)
    assert open_edges(mesh) == 0
    assert mesh.volume() == pytest.approx(8.0 * np.pi / 3.0, rel=0.03)


@pytest.mark.parametrize("method", ["chord", "net"])
def test_a_ball_in_pieces_of_other_fineness_is_closed(method):
    ball = shapes.sphere(radius=1.0)
    (u0, u1), (v0, v1) = ball.domain
    low, high = ball.split(v=v0 + 0.4 * (v1 - v0))
    half = u0 + 0.5 * (u1 - u0)
    body = Body([*low.split(u=half), *high.elevate(v=2).split(u=half)])
    errors = []
    for tol in (0.05, 0.003):
        mesh = body.tessellate(tol, method=method)
        assert open_edges(mesh) == 0
        errors.append(abs(mesh.volume() * 3.0 / (4.0 * np.pi) - 1.0))
        on_ball = np.linalg.norm(mesh.vertices, axis=1)
        np.testing.assert_allclose(on_ball, 1.0, rtol=0, atol=1e-9)
    assert errors[1] < 0.3 * errors[0]


def test_vertices_of_the_finer_face_cut_the_triangles_of_the_coarser_one():
    # A flat face needs two triangles, the curved one beside it many along the same edge.
    arc = shapes.arc(radius=1.0, start=0.0, end=np.pi)
    lid = shapes.ruled(arc, shapes.line([1, 0, 0], [-1, 0, 0]))
    wall = shapes.extruded(arc, [0, 0, 1])
    alone = [Body([p]).tessellate(1e-3) for p in (lid, wall)]
    mesh = Body([lid, wall]).tessellate(1e-3)
    assert open_edges(mesh) < sum(open_edges(m) for m in alone)
    feet = CurveFeet(arc)
    ends = mesh.vertices[mesh.open_edges()]
    middles = ends.mean(axis=1)
    assert feet(middles)[1].min() > 1e-3
    assert mesh.area() == pytest.approx(np.pi / 2 + np.pi, rel=2e-3)


def test_an_edge_known_only_roughly_keeps_its_vertices():
    # The tolerance exceeds the spacing of the vertices; the lid's border is off by a part of it.
    arc = shapes.arc(radius=1.0, start=0.0, end=np.pi)
    lid = shapes.ruled(arc.scaled(0.99), shapes.line([0.99, 0, 0], [-0.99, 0, 0]))
    wall = shapes.extruded(arc, [0, 0, 1])
    uses = (EdgeUse(0, -1, 2, False), EdgeUse(1, -1, 2, False))
    mesh = Body([lid, wall], edges=[BodyEdge(arc, 0.05, uses)]).tessellate(1e-4)
    assert mesh.area() == pytest.approx(np.pi / 2 + np.pi, rel=1e-3)
    ends = mesh.vertices[mesh.open_edges()]
    assert CurveFeet(arc)(ends.mean(axis=1))[1].min() > 1e-3


def test_a_sloppy_part_keeps_its_area_and_closes_but_at_free_edges(data_dir):
    body = cg.read_cad(data_dir / "occt_bearing.iges")
    assert max(edge.stated for edge in body.edges) > 0.01 * body.size
    mesh = body.tessellate(3e-4 * body.size)
    assert mesh.area() == pytest.approx(body.area(), rel=2e-3)
    ends = mesh.vertices[mesh.open_edges()]
    free = [edge for edge in body.edges if len(edge.uses) == 1]
    off = [CurveFeet(e.curve)(ends.reshape(-1, 3))[1] - 3.0 * e.stated for e in free]
    assert np.min(off, axis=0).max() < 1e-5 * body.size


def test_trimmed_faces_of_a_real_part_close(data_dir):
    body = cg.read_cad(data_dir / "nist_ctc_02_asme1_ap242.stp")
    mesh = body.tessellate(2.0)
    assert all(len(edge.uses) > 1 for edge in body.edges)
    assert open_edges(mesh) == 0
    # The chords of outward curves lie inside, those of inward ones outside: first order in tol.
    assert mesh.volume() == pytest.approx(body.volume(), rel=4e-3)
    assert mesh.area() == pytest.approx(body.area(), rel=4e-3)


def test_of_an_open_part_only_free_edges_stay_open(data_dir):
    body = cg.read_cad(data_dir / "utah_teapot_32bezier_gismo.xml")
    mesh = body.tessellate(0.02)
    ends = mesh.vertices[mesh.open_edges()]
    free = [CurveFeet(edge.curve) for edge in body.edges if len(edge.uses) == 1]
    distance = np.min([np.maximum(f(ends[:, 0])[1], f(ends[:, 1])[1]) for f in free], axis=0)
    assert len(ends) > 0
    assert distance.max() < 1e-9


@pytest.mark.parametrize(("tol", "method"), [(0.0, "chord"), (-1.0, "net"), (1.0, "delaunay")])
def test_wrong_requests_are_refused(tol, method):
    with pytest.raises(InputError):
        box().tessellate(tol, method=method)


def test_the_mesh_stands_in_for_its_body():
    body = box().with_reference_point([1.0, 2.0, 3.0]).renamed("crate")
    mesh = body.tessellate(0.1)
    assert mesh.name == "crate"
    assert mesh.reference_point.tolist() == [1.0, 2.0, 3.0]


def test_along_the_straight_border_of_a_bent_face_no_triangle_is_a_needle():
    body = Body([shapes.bumpy_plate()])
    mesh = body.tessellate(1e-4 * body.size)
    corner = mesh.vertices[mesh.triangles]
    sides = np.roll(corner, -1, axis=1) - corner
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    height = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / longest
    assert (longest / height).max() < 1000.0
