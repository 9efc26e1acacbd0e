"""The box of faces beside closed forms: turned ellipsoids and tori, caps, faces cut by circles."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.geometry import clouds
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.face_box import bounds_of
from contiga.geometry.surface import NurbsSurface
from contiga.rigid.transform import rotation

TURN = rotation((1.0, 2.0, 3.0), 0.7)
AXES = np.array([110.0, 160.0, 100.0])


def body(surface: NurbsSurface, loops: list | None = None) -> cg.Body:
    return cg.Body([surface], trims=[loops])


def test_an_ellipsoid_reaches_as_far_as_its_axes() -> None:
    upright = body(cg.shapes.ellipsoid(axes=AXES))
    np.testing.assert_allclose(upright.bounds(), [-AXES, AXES], rtol=1e-13)
    turned = upright.transformed(TURN)
    reach = np.linalg.norm(TURN[:3, :3] * AXES, axis=1)
    np.testing.assert_allclose(turned.bounds(), [-reach, reach], rtol=1e-12)
    assert turned.size == pytest.approx(2.0 * np.linalg.norm(reach), rel=1e-12)


def test_three_arcs_that_go_round_reach_no_farther_than_their_circle() -> None:
    """As CAD kernels write spheres: control points at twice the radius, where the box once was."""
    corners = np.exp(1j * np.pi * (np.arange(7) + 1) / 3.0) * np.where(np.arange(7) % 2, 2.0, 1.0)
    knots = np.repeat([0.0, 1 / 3, 2 / 3, 1.0], [3, 2, 2, 3])
    points = np.stack([corners.real, corners.imag, np.zeros(7)], axis=1)
    ring = NurbsCurve(2, knots, points, np.where(np.arange(7) % 2, 0.5, 1.0))
    tube = body(cg.shapes.extruded(ring, (0.0, 0.0, 3.0)))
    assert np.abs(tube.patches[0].bounds()).max() > 1.9
    np.testing.assert_allclose(tube.bounds(), [[-1, -1, 0], [1, 1, 3]], atol=1e-12)


def test_a_turned_torus_reaches_as_far_as_it_should() -> None:
    ring = body(cg.shapes.torus(major=3.0, minor=1.0)).transformed(TURN)
    reach = 3.0 * np.sqrt(1.0 - TURN[:3, 2] ** 2) + 1.0
    np.testing.assert_allclose(ring.bounds(), [-reach, reach], rtol=1e-12)


@pytest.mark.parametrize("name", ["saddle", "bumpy_plate", "cone", "disc", "cylinder"])
def test_the_box_holds_points_of_the_surface_and_touches_it(name: str) -> None:
    surface = getattr(cg.shapes, name)().transformed(TURN)
    low, high = body(surface).bounds()
    points = clouds.sample(surface, 201, 201)
    assert (points >= low - 1e-12).all()
    assert (points <= high + 1e-12).all()
    np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [low, high], atol=2e-4)


def circle(radius: float, centre: tuple[float, float]) -> list[NurbsCurve]:
    return [cg.shapes.circle(radius=radius, centre=(*centre, 0.0))]


def test_of_a_trimmed_face_only_what_is_left_counts() -> None:
    flat = cg.shapes.bilinear((-1, -1, 0), (1, -1, 0), (-1, 1, 0), (1, 1, 0))
    cut = body(flat, [circle(0.3, (0.6, 0.4))])  # u and v from 0 to 1, x and y from -1 to 1
    expected = 2.0 * (np.array([[0.3, 0.1], [0.9, 0.7]])) - 1.0
    np.testing.assert_allclose(cut.bounds()[:, :2], expected, atol=1e-12)
    np.testing.assert_allclose(cut.bounds()[:, 2], 0.0, atol=1e-15)


def test_a_hole_takes_the_top_away() -> None:
    """A paraboloid z = 1 - x² - y²: without a disc about its top it ends at the rim of the hole."""
    dome = cg.shapes.saddle(width=2.0, length=2.0, height=1.0)
    net = dome.control_points.copy()
    square = np.array([1.0, -1.0, 1.0])
    net[..., 2] = 1.0 - square[:, None] - square[None, :]
    dome = NurbsSurface(dome.degrees, dome.knots, net)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    rim = [cg.shapes.line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    whole = body(dome, [rim])
    np.testing.assert_allclose(whole.bounds(), [[-1, -1, -1], [1, 1, 1]], atol=1e-12)
    off = (0.55, 0.5)  # x = 0.1, y = 0: the top lies in the hole of radius 0.4
    holed = body(dome, [rim, circle(0.2, off)])
    np.testing.assert_allclose(holed.bounds()[1, 2], 1.0 - (0.4 - 0.1) ** 2, atol=1e-12)


def test_a_part_of_a_sphere_between_meridians() -> None:
    """An eighth of it, as a patch of its own and cut out by lines of parameters."""
    globe = cg.shapes.sphere(radius=2.0)
    v = 0.5
    quarter = body(globe.restricted((0.0, 0.25), (0.5, 1.0)))
    np.testing.assert_allclose(quarter.bounds(), [[0, 0, 0], [2, 2, 2]], atol=1e-12)
    corners = [(0.0, v, 0), (0.25, v, 0), (0.25, 1.0, 0), (0.0, 1.0, 0)]
    loop = [cg.shapes.line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    cut = body(globe, [loop])
    np.testing.assert_allclose(cut.bounds(), quarter.bounds(), atol=1e-12)


def test_ridges_along_no_line_of_parameters_end_soon() -> None:
    """Rolled paper turned in its plane: a ridge across all elements, where no part stands out."""
    line = NurbsCurve(2, [0, 0, 0, 1, 1, 1], [(-1, 0, 0), (0, 0, 1), (1, 0, 0)])
    roof = cg.shapes.extruded(line, (0.5, 2.0, 0.0))
    low, high = bounds_of([roof], [None])
    np.testing.assert_allclose([low, high], [[-1, 0, 0], [1.5, 2, 0.5]], atol=1e-12)


def test_faces_of_a_body_are_asked_by_loops_of_their_own() -> None:
    """Of two caps that circles cut out of one ellipsoid the second holds its end alone."""
    patch = cg.shapes.ellipsoid(axes=AXES)
    (u0, u1), (v0, v1) = patch.domain
    end, aside = (np.array([u, 0.5 * (v0 + v1), 0.0]) for u in (0.5 * (u0 + u1), 0.3 * (u0 + u1)))
    np.testing.assert_allclose(patch.evaluate(end[None, :2]), [[-AXES[0], 0, 0]], atol=1e-12)
    loops = [[cg.shapes.circle(radius=0.1 * (u1 - u0), centre=middle)] for middle in (aside, end)]
    caps = cg.Body([patch, patch], trims=[[loop] for loop in loops])
    assert caps.bounds()[0, 0] == pytest.approx(-AXES[0], rel=1e-13)
    alone = [bounds_of([patch], [loops]) for loops in caps.trims]
    assert alone[0][0, 0] > -0.99 * AXES[0]
    low, high = np.array(alone).swapaxes(0, 1)
    np.testing.assert_array_equal(caps.bounds(), [low.min(axis=0), high.max(axis=0)])
