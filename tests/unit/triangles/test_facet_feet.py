"""Feet on triangles: against every triangle, on edges and corners, tracked, bit by bit."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import contiga as cg
from contiga import Feature, Status, TriMesh
from contiga.errors import InputError, MeshError

SHEET = TriMesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]])


@pytest.fixture(scope="module")
def torus() -> TriMesh:
    return cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.02)


def _feet_are_the_oracles(oracle, mesh, points):
    feet = mesh.project(points)
    distance = oracle.distances(mesh, points)
    size = mesh.size
    np.testing.assert_allclose(np.abs(feet.gap), distance.min(axis=1), rtol=0, atol=1e-14 * size)
    reached = oracle.on_triangles(mesh, feet.patch, feet.uv)
    np.testing.assert_allclose(reached, feet.point, rtol=0, atol=1e-12 * size)
    gaps = ((points - feet.point) * feet.normal).sum(axis=1)
    np.testing.assert_allclose(gaps, feet.gap, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(np.linalg.norm(feet.normal, axis=1), 1.0, rtol=0, atol=1e-12)
    return feet


@pytest.mark.parametrize("spread", [0.3, 1.0, 30.0])
def test_feet_on_a_closed_mesh_are_those_of_every_triangle(oracle, torus, spread):
    points = spread * np.random.default_rng(0).normal(size=(700, 3))
    feet = _feet_are_the_oracles(oracle, torus, points)
    assert set(feet.status) == {Status.OK}
    assert Feature.EDGE in feet.feature


def test_feet_on_an_open_rough_sheet_are_those_of_every_triangle(oracle):
    points = np.random.default_rng(1).uniform(-0.5, 1.5, (900, 3))
    feet = _feet_are_the_oracles(oracle, oracle.rough(0), points)
    assert {Feature.FACE, Feature.EDGE, Feature.VERTEX} == set(feet.feature)
    assert {Status.OK, Status.BORDER} == set(feet.status)
    assert (feet.feature[feet.status == Status.BORDER] != Feature.FACE).all()


@pytest.mark.interpreted
def test_feet_of_a_few_points_on_a_box(oracle):
    box = oracle.box()
    points = np.array(
        [[0.0, 0.1, 0.9], [0.1, 0.0, 0.3], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.1, 0.5]]
    )
    feet = box.project(points)
    r = np.sqrt(0.5)
    np.testing.assert_allclose(feet.gap, [0.4, -0.2, r, np.sqrt(0.75), 0.0], rtol=0, atol=1e-15)
    assert feet.feature.tolist() == [0, 0, 1, 2, 0]
    np.testing.assert_allclose(feet.normal[2:4], [[r, r, 0], [3**-0.5] * 3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        feet.point, [[0, 0.1, 0.5], [0.1, 0, 0.5], [0.5, 0.5, 0], [0.5] * 3, points[4]], atol=1e-15
    )
    tracked = box.project(points + 0.01, start=feet, mode="track")
    np.testing.assert_array_equal(tracked.gap, box.project(points + 0.01).gap)


def test_sign_on_a_closed_mesh_is_that_of_another_code(torus):
    vtk = pytest.importorskip("vtk")
    numpy_support = pytest.importorskip("vtk.util.numpy_support")
    poly, at, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    at.SetData(numpy_support.numpy_to_vtk(torus.vertices, deep=True))
    for t in torus.triangles:
        cells.InsertNextCell(3, t.tolist())
    poly.SetPoints(at)
    poly.SetPolys(cells)
    other = vtk.vtkImplicitPolyDataDistance()
    other.SetInput(poly)
    points = np.random.default_rng(2).uniform([-3, -3, -1], [3, 3, 1], (3000, 3))
    expected = [other.EvaluateFunction(p.tolist()) for p in points]
    np.testing.assert_allclose(torus.project(points).gap, expected, rtol=0, atol=1e-6)


def test_sign_holds_at_every_edge_and_corner_of_a_star(oracle):
    # A spiky body: near its reflex and sharp edges the plain normals of one facet mislead.
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.05)
    spikes = 1.0 + 0.6 * np.random.default_rng(3).random(len(ball.vertices))
    star = TriMesh(ball.vertices * spikes[:, None], ball.triangles)
    points = np.random.default_rng(4).uniform(-1.7, 1.7, (4000, 3))
    feet = star.project(points)
    # Inside means: a ray to the centre crosses the surface an even number of times; here, that
    # the point is short of the facet its own direction meets.
    hits = star.first_hit(3.0 * points / np.linalg.norm(points, axis=1, keepdims=True), 0 * points)
    inside = np.linalg.norm(points, axis=1) < np.linalg.norm(hits.point, axis=1)
    assert (hits.patch >= 0).all()
    clear = np.abs(feet.gap) > 1e-9
    assert ((feet.gap < 0.0) == inside)[clear].all()
    assert (feet.feature != Feature.FACE).sum() > 500


def test_ties_go_to_the_first_triangle_wherever_the_search_starts(oracle):
    box = oracle.box()
    rng = np.random.default_rng(5)
    mixed = rng.permutation(len(box.triangles))
    centre = np.zeros((200, 3))
    points = np.concatenate([centre[:1], rng.normal(size=(300, 3)), centre])
    feet = box.project(points)
    assert feet.patch[0] == 0
    assert (feet.patch[-200:] == 0).all()
    other = TriMesh(box.vertices, box.triangles[mixed]).project(points)
    np.testing.assert_array_equal(other.gap, feet.gap)
    assert (other.patch[-200:] == 0).all()


def test_order_of_the_points_changes_no_bit(torus):
    points = np.random.default_rng(6).normal(size=(3000, 3))
    order = np.random.default_rng(7).permutation(len(points))
    plain, mixed = torus.project(points), torus.project(points[order])
    for a, b in zip(plain, mixed, strict=True):
        np.testing.assert_array_equal(a[order], b)


PROGRAM = """
import sys, numpy as np, contiga as cg
mesh = cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.02)
p = np.random.default_rng(8).normal(size=(20000, 3))
a = mesh.project(p)
b = mesh.project(p + 0.01, start=a, mode="track")
h = mesh.first_hit(p, p * 0.3)
np.savez(sys.argv[1], *a, *b, *h)
"""


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core")
def test_threads_change_no_bit(tmp_path):
    results = []
    for n in ("1", "2"):
        path = tmp_path / f"{n}.npz"
        environment = os.environ | {"NUMBA_NUM_THREADS": n}
        subprocess.run([sys.executable, "-c", PROGRAM, path], env=environment, check=True)
        results.append(np.load(path))
    for name in results[0].files:
        np.testing.assert_array_equal(results[0][name], results[1][name])


def test_points_above_the_border_and_the_diagonal_are_on_the_surface():
    points = [[2.0, 1.0, 0.3], [1.0, 1.0, 0.3], [0.0, 0.0, -0.3]]
    feet = SHEET.project(points)
    assert (feet.status == Status.OK).all()
    np.testing.assert_array_equal(feet.gap, [0.3, 0.3, -0.3])
    np.testing.assert_array_equal(feet.normal, [[0, 0, 1]] * 3)


def test_vertex_normals_are_those_of_the_smooth_shape_to_second_order():
    errors = []
    for tol in (0.01, 0.0025):
        ball = cg.shapes.sphere(radius=1.0).tessellate(tol)
        points = np.random.default_rng(11).normal(size=(400, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        facet, smooth = (ball.project(1.1 * points, normals=kind) for kind in ("facet", "vertex"))
        np.testing.assert_array_equal(facet.gap, smooth.gap)
        np.testing.assert_allclose(np.linalg.norm(smooth.normal, axis=1), 1.0, rtol=0, atol=1e-12)
        flat = np.flatnonzero(facet.feature == Feature.FACE)
        errors.append(
            [np.linalg.norm(feet.normal - points, axis=1)[flat].max() for feet in (facet, smooth)]
        )
    assert errors[0][1] < 0.5 * errors[0][0]
    assert errors[1][1] < 0.5 * errors[0][1]


def test_a_mesh_made_smooth_projects_smoothly(torus):
    smooth = TriMesh(torus.vertices, torus.triangles, normals="vertex")
    points = np.random.default_rng(12).normal(size=(20, 3))
    np.testing.assert_array_equal(
        smooth.project(points).normal, torus.project(points, normals="vertex").normal
    )


@pytest.mark.parametrize("mode", ["global", "track"])
def test_feet_written_over_those_of_the_step_before_are_the_same_bits(torus, mode):
    rng = np.random.default_rng(13)
    p = 2.0 * rng.normal(size=(500, 3))
    own = other = torus.project(p)
    for _ in range(3):
        p = p + 0.1 * rng.normal(size=p.shape)
        new = torus.project(p, start=other, mode=mode)
        assert torus.project(p, start=own, mode=mode, out=own) is own
        for a, b in zip(new, own, strict=True):
            np.testing.assert_array_equal(a, b)
        other = new
    with pytest.raises(InputError, match="shares memory"):
        torus.project(own.point, out=own)


def test_wrong_questions_are_refused(torus):
    with pytest.raises(InputError, match="unknown mode"):
        torus.project([[0, 0, 0]], mode="nearest")
    with pytest.raises(InputError, match="continues a projection"):
        torus.project([[0, 0, 0]], mode="track")
    feet = torus.project([[0, 0, 0]])
    with pytest.raises(InputError, match="one row a point"):
        torus.project([[0, 0, 0]] * 2, start=feet, mode="track")
    with pytest.raises(InputError, match="not there"):
        SHEET.project([[0, 0, 0]], start=feet._replace(patch=np.array([2])), mode="track")
    with pytest.raises(InputError, match="unknown kind of normals"):
        torus.project([[0, 0, 0]], normals="smooth")
    with pytest.raises(MeshError, match="without triangles"):
        TriMesh([], []).project([[0, 0, 0]])
    with pytest.raises(MeshError, match="none of the triangles has an area"):
        TriMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]).project([[0, 0, 0]])
