"""Moments of bodies and meshes: invariants of them, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import GeometryError, InputError, MeshError
from contiga.geometry.trim_area import body_moments, patch_volumes


def cube(**options) -> cg.TriMesh:
    """Corners (0, 0, 0) and (1, 1, 1), outward."""
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return cg.TriMesh(corners, triangles, **options)


def ball(radius: float = 1.0) -> cg.Body:
    return cg.Body([cg.shapes.sphere(radius=radius)], name="ball")


def test_moments_of_a_cube_are_powers_of_its_side():
    cubes = cube().mass_properties(2.0)
    assert cubes.mass == pytest.approx(2.0, rel=1e-15)
    assert np.abs(cubes.centre - 0.5).max() < 1e-15
    assert np.abs(cubes.inertia - np.eye(3) / 3.0).max() < 1e-15


def test_products_of_inertia_have_the_sign_of_the_tensor():
    """Most mass of this wedge lies where x and y have opposite signs."""
    wedge = cg.TriMesh(
        [[1, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 1], [0, 1, 1], [0, 0, 1]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]],
    ).mass_properties(1.0)
    # ∫ x y dV = 1/24, about the centre of (1/3, 1/3): 1/24 − 1/18 = −1/72.
    assert wedge.mass == pytest.approx(0.5, rel=1e-15)
    assert wedge.inertia[0, 1] == pytest.approx(1.0 / 72.0, rel=1e-13)


def test_moments_do_not_depend_on_the_origin():
    body = cg.Body(cg.shapes.torus(major=3.0, minor=1.0))
    one, other = body_moments(body, np.zeros(3)), body_moments(body, np.array([1.0, -2.0, 0.5]))
    volume = one[0]
    assert other[0] == pytest.approx(volume, rel=1e-12)
    assert other[1:4] == pytest.approx(volume * np.array([-1.0, 2.0, -0.5]), rel=1e-12)
    second = volume * np.array([1.0, 4.0, 0.25, -2.0, -1.0, 0.5]) + one[4:]
    assert other[4:] == pytest.approx(second, rel=1e-12)


def test_volumes_of_patches_are_the_first_of_their_moments():
    body = cg.Body(cg.shapes.torus(major=2.0, minor=0.5)).rotated("x", 0.3)
    origin = np.array([0.1, 0.2, 0.3])
    assert patch_volumes(body, origin).sum() == pytest.approx(body_moments(body, origin)[0])


def test_a_tighter_tolerance_is_closer():
    """A tall ellipsoid needs many parts; its moments are those of the ball, stretched."""
    body = ball().transformed(np.diag([1.0, 1.0, 40.0, 1.0]))
    exact = 40.0 * 4.0 * np.pi / 3.0 * np.array([1.0, 0.2, 0.2, 0.2 * 1600.0])
    for rtol in (1e-6, 1e-12):
        moments = body_moments(body, np.zeros(3), rtol)[[0, 4, 5, 6]]
        assert np.abs(moments / exact - 1.0).max() < rtol


def test_meshes_do_not_depend_on_the_order_of_the_origin():
    far = cube().translated([1e3, -1e3, 1e3]).mass_properties(1.0)
    assert np.abs(far.centre - [1000.5, -999.5, 1000.5]).max() < 1e-12
    assert np.abs(far.inertia - np.eye(3) / 6.0).max() < 1e-12


def test_a_void_is_taken_off():
    hollow = cg.Body([cg.shapes.sphere(radius=2.0), cg.shapes.sphere(radius=1.0).flipped()])
    assert hollow.mass_properties(1.0).mass == pytest.approx(28.0 * np.pi / 3.0, rel=1e-12)


@pytest.mark.parametrize("density", [0.0, -1.0, np.nan, np.inf, "heavy", None])
@pytest.mark.parametrize("make", [ball, lambda: cube(name="ball")])
def test_a_density_is_positive_and_finite(make, density):
    with pytest.raises(InputError, match=r"ball, density: must be .*allowed: a finite number > 0"):
        make().mass_properties(density)


@pytest.mark.parametrize("make", [ball, lambda: cube(name="ball")])
def test_inward_normals_are_told(make):
    with pytest.raises(InputError, match=r"ball: encloses no volume.*found -.*flipped\(\)"):
        make().flipped().mass_properties(1.0)


def test_open_bodies_have_no_mass():
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)], name="tube")
    with pytest.raises(GeometryError, match=r"tube: only a closed body.*Give its mass, centre and"):
        tube.mass_properties(1.0)


def test_open_meshes_have_no_mass():
    lidless = cg.TriMesh(cube().vertices, cube().triangles[:-2], name="box")
    with pytest.raises(MeshError, match=r"box: only a closed mesh.*found '4 edges of one"):
        lidless.mass_properties(1.0)


def test_meshes_whose_triangles_disagree_have_no_mass():
    triangles = cube().triangles.copy()
    triangles[0] = triangles[0, ::-1]
    with pytest.raises(MeshError, match="box"):
        cg.TriMesh(cube().vertices, triangles, name="box").mass_properties(1.0)


def test_mass_properties_show_themselves_in_one_line():
    shown = cube().mass_properties(6.0)
    assert repr(shown).startswith("MassProperties(mass 6, centre (0.5, 0.5, 0.5), Ixx Iyy Izz (1,")
    assert "<th style='text-align:left'>mass</th><td>6</td>" in shown._repr_html_()
