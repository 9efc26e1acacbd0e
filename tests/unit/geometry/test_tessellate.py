"""Triangles from surfaces: the tolerance held, the thesis' net rule, closed meshes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga import NurbsSurface, TriMesh, shapes
from contiga.errors import GeometryError, InputError
from contiga.geometry import tessellate as ts

from .distances import distance_to_triangle


def largest_miss(surface, u, v, samples=7):
    """Largest distance of dense surface points from the two triangles of their own cell."""

    def at(s, t):
        uv = np.stack(np.meshgrid(s, t, indexing="ij"), -1)
        return surface.evaluate(uv.reshape(-1, 2)).reshape((*uv.shape[:2], 3))

    P = at(u, v)
    a, b, c, d = P[:-1, :-1], P[1:, :-1], P[1:, 1:], P[:-1, 1:]
    worst = 0.0
    for s in np.linspace(0, 1, samples):
        for t in np.linspace(0, 1, samples):
            x = at(u[:-1] + s * np.diff(u), v[:-1] + t * np.diff(v))
            miss = np.minimum(distance_to_triangle(x, a, b, c), distance_to_triangle(x, a, c, d))
            worst = max(worst, float(miss.max()))
    return worst


def wild_surface():
    """A rational biquartic with weights over two decades and a crease."""
    rng = np.random.default_rng(4)
    U, V = [0, 0, 0, 0, 0, 0.3, 1, 1, 1, 1, 1], [0, 0, 0, 0.5, 0.5, 1, 1, 1]
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    points = np.stack([x, y, rng.normal(size=(6, 5))], -1)
    return NurbsSurface((4, 2), (U, V), points, 10.0 ** rng.uniform(-1, 1, (6, 5)))


SHAPES = {
    "sphere": shapes.sphere(),
    "ellipsoid": shapes.ellipsoid(axes=(5.0, 1.0, 0.2)),
    "torus": shapes.torus(),
    "cone": shapes.cone(),
    "disc": shapes.disc(),
    "bumpy_plate": shapes.bumpy_plate(),
    "twisted": shapes.bilinear((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1)),
    "wild": wild_surface(),
}


@pytest.mark.parametrize("tol", [0.2, 1e-2, 2e-3])
@pytest.mark.parametrize("name", SHAPES)
def test_no_point_of_the_surface_is_farther_than_the_tolerance(name, tol):
    surface = SHAPES[name]
    u, v = ts.chord_grid(surface, tol)
    assert largest_miss(surface, u, v) <= tol * (1.0 + 1e-12)


@pytest.mark.parametrize("name", ["sphere", "torus", "cone", "disc"])
def test_the_tolerance_is_used_and_not_wasted(name):
    """Counts stay sane: the true miss is not far below what was asked for."""
    u, v = ts.chord_grid(SHAPES[name], 1e-3)
    assert largest_miss(SHAPES[name], u, v) > 0.7e-3


def test_flat_and_straight_parts_are_not_cut():
    assert len(shapes.plane().tessellate(1e-9).triangles) == 2
    u, v = ts.chord_grid(shapes.cylinder(), 1e-4)
    assert v.size == 2
    assert u.size < 300


def test_every_knot_is_on_the_grid():
    surface = wild_surface()
    u, v = ts.chord_grid(surface, 0.05)
    assert np.isin(np.unique(surface.knots[0]), u).all()
    assert np.isin(np.unique(surface.knots[1]), v).all()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_size_does_not_matter(scale):
    surface = shapes.torus()
    big = surface.scaled(scale)
    ours, theirs = ts.chord_grid(surface, 1e-2), ts.chord_grid(big, 1e-2 * scale)
    assert [len(k) for k in ours] == [len(k) for k in theirs]


def edges_used_twice(mesh: TriMesh) -> bool:
    """Each directed edge once, and once the other way: closed, and turned one way."""
    edges = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    there = {tuple(e) for e in edges.tolist()}
    return len(there) == len(edges) and all((b, a) in there for a, b in there)


@pytest.mark.parametrize("method", ["chord", "net"])
@pytest.mark.parametrize("name", ["sphere", "torus", "ellipsoid"])
def test_closed_patches_give_closed_meshes(name, method):
    mesh = SHAPES[name].tessellate(0.1, method=method)
    assert edges_used_twice(mesh)
    euler = len(mesh.vertices) - len(mesh.triangles) // 2
    assert euler == (0 if name == "torus" else 2)
    assert (mesh.areas() > 0.0).all()


def test_triangles_face_the_free_side():
    mesh = shapes.sphere().tessellate(0.01)
    centres = mesh.corners().mean(axis=1)
    assert (mesh.normals() * centres).sum(axis=1).min() > 0.9
    inward = shapes.sphere().flipped().tessellate(0.01)
    assert (inward.normals() * inward.corners().mean(axis=1)).sum(axis=1).max() < -0.9


def test_net_and_base_area_of_known_nets():
    """A quarter cylinder: its net has two legs of length r, its base one chord of √2 r."""
    quarter = shapes.cylinder(radius=2.0, height=3.0, angle=0.5 * math.pi)
    assert quarter.net_area() == pytest.approx(12.0, rel=1e-14)
    assert quarter.base_area() == pytest.approx(6.0 * math.sqrt(2.0), rel=1e-14)
    assert quarter.base_area() < quarter.area() < quarter.net_area()


def test_base_area_of_a_closed_patch_is_not_zero():
    """Algorithm 4 as printed takes the patch's corners, which are one point here."""
    assert shapes.torus().base_area() > 0.5 * shapes.torus().area()


def test_net_tessellation_closes_on_the_area_as_the_tolerance_falls():
    surface = shapes.bumpy_plate(width=4.0, length=4.0, amplitude=0.3)
    exact, errors, counts = surface.area(), [], []
    for tol in (0.5, 0.1, 0.01):
        mesh = surface.tessellate(tol, method="net")
        errors.append(abs(mesh.area() - exact))
        counts.append(len(mesh.triangles))
        assert errors[-1] < tol
    assert errors == sorted(errors, reverse=True)
    assert counts == sorted(counts)
    assert counts[-1] > 4 * counts[0]


def test_net_rule_halves_its_difference_fourfold_when_all_is_bisected():
    """Σ|A_net − A_base| is of second order in the size of the pieces."""
    surface, sums = shapes.saddle(height=0.5), []
    for n in (4, 8, 16):
        cuts = np.arange(1, n) / n
        net, base, _, _ = ts._piece_measures(ts.extract(surface, cuts, cuts))
        sums.append(np.abs(net - base).sum())
    assert sums[0] / sums[1] == pytest.approx(4.0, rel=0.05)
    assert sums[1] / sums[2] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("method", ["chord", "net"])
def test_wrong_requests_are_refused(method):
    for tol in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="tol: a tolerance must be positive"):
            shapes.sphere().tessellate(tol, method=method)
    with pytest.raises(InputError, match="not a method"):
        shapes.sphere().tessellate(0.1, method="delaunay")
    with pytest.raises(GeometryError, match="Take a larger one"):
        shapes.sphere().tessellate(1e-9, method="chord")
