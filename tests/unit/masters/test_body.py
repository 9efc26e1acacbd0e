"""Body: what it is made of, how it moves, what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga.errors import GeometryError, InputError
from contiga.geometry import shapes
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.surface import NurbsSurface
from contiga.masters.body import Body
from contiga.masters.body_summary import body_summary


def plate() -> NurbsSurface:
    net = [[[0, 0, 0], [0, 3, 0]], [[2, 0, 0], [2, 3, 0]]]
    return NurbsSurface((1, 1), ([0, 0, 2, 2], [0, 0, 3, 3]), net)


def polygon(*corners: tuple[float, float]) -> tuple[NurbsCurve, ...]:
    p = np.array(corners, dtype=float)
    return tuple(NurbsCurve(1, [0, 0, 1, 1], p[[i, (i + 1) % len(p)]]) for i in range(len(p)))


TRIANGLE = polygon((0.5, 0.5), (1.5, 0.5), (0.5, 2.5))


def with_hole() -> Body:
    """A plate without a triangle; one trim edge, one natural side of a second patch, as an edge."""
    frame = polygon((0, 0), (2, 0), (2, 3), (0, 3))
    side = NurbsCurve(1, [0, 0, 1, 1], [[2, 3, 0], [2, 0, 0]])
    uses = (EdgeUse(0, 0, 1, True), EdgeUse(1, -1, 0, True))
    edge = BodyEdge(side, 1e-6, uses, ((0.0, 1.0), (0.0, 3.0)))
    return Body(
        [plate(), plate().translated([2, 0, 0])],
        name="plate",
        trims=[[frame, TRIANGLE], None],
        edges=[edge],
        unit="mm",
        reference_point=(1.0, 2.0, 3.0),
    )


def in_space(body: Body, n: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Points of the first patch and whether they belong to the face, at the same places always."""
    share = np.random.default_rng(0).random((n, 2))
    low, high = np.array(body.patches[0].domain).T
    uv = low + share * (high - low)
    return body.patches[0].evaluate(uv), points_in_trim(body.trim_tables, 0, uv)


def of_the_plate(points: np.ndarray) -> np.ndarray:
    """Whether points of z = 0 belong to the first face of `with_hole`."""
    x, y = points[:, 0], points[:, 1]
    return ~((x > 0.5) & (y > 0.5) & (2 * (x - 0.5) + (y - 0.5) < 2.0))


def test_a_body_keeps_what_it_was_given():
    body = with_hole()
    assert [type(patch) for patch in body.patches] == [NurbsSurface] * 2
    assert [loops if loops is None else len(loops) for loops in body.trims] == [2, None]
    assert body.unit == "mm"
    assert body.name == "plate"
    assert np.array_equal(body.reference_point, [1, 2, 3])
    assert repr(body) == "Body('plate', patches 2, trimmed 1)"
    assert body.renamed("other").name == "other"
    assert body.area() == pytest.approx(11.0, rel=1e-13)


def test_one_patch_needs_no_list():
    assert len(Body(plate()).patches) == 1


def test_bodies_compare_by_identity_and_serve_as_keys():
    a, b = Body(plate()), Body(plate())
    assert a != b
    assert {a: 1, b: 2}[a] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"patches": []}, "a body with no faces"),
        ({"patches": [plate(), 3]}, "patch 1: patches must be NurbsSurface"),
        ({"patches": [plate()], "trims": [None, None]}, "one entry a patch; found 2"),
        ({"patches": [plate()], "trims": [[]]}, "needs a loop"),
        ({"patches": [plate()], "trims": [[()]]}, "at least one p-curve"),
        (
            {
                "patches": [plate()],
                "edges": [BodyEdge(TRIANGLE[0], 0.0, (EdgeUse(0, 0, 0, False),))],
            },
            "edge 0: an edge names a side that is not there",
        ),
        (
            {
                "patches": [plate()],
                "edges": [BodyEdge(TRIANGLE[0], 0.0, (EdgeUse(1, -1, 0, False),))],
            },
            "an edge names a side that is not there",
        ),
    ],
)
def test_what_does_not_fit_is_refused(arguments, words):
    with pytest.raises(GeometryError, match=words):
        Body(**arguments)


def test_bounds_count_only_the_part_of_a_patch_that_the_loops_reach():
    body = Body(plate(), trims=[[TRIANGLE]])
    assert np.allclose(body.bounds(), [[0.5, 0.5, 0], [1.5, 2.5, 0]], atol=1e-15)
    assert body.size == pytest.approx(math.sqrt(5.0))


def test_flipping_swaps_normals_and_keeps_the_same_points():
    body = with_hole()
    flipped = body.flipped()
    uv = [[1.9, 1.0]]
    assert np.allclose(flipped.patches[0].normal(uv), -body.patches[0].normal(uv))
    points, inside = in_space(flipped)
    assert np.array_equal(inside, of_the_plate(points))
    twice = flipped.flipped()
    assert np.allclose(twice.patches[0].control_points, body.patches[0].control_points)
    assert twice.edges[0].uses == body.edges[0].uses


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("mirror", [False, True])
def test_edges_follow_their_sides_through_flips_and_mirrors(flip, mirror):
    body = with_hole()
    matrix = np.diag([-2.0 if mirror else 2.0, 2.0, 2.0, 1.0])
    moved = body.transformed(matrix)
    moved = moved.flipped() if flip else moved
    edge = moved.edges[0]
    ends = edge.curve.evaluate(np.array([0.0, 1.0]))
    assert edge.tolerance == pytest.approx(2e-6)
    use = edge.uses[0]
    curve = moved.trims[0][use.loop][use.index]
    on = moved.patches[0].evaluate(curve.control_points[[0, -1], :2])
    assert np.allclose(on[::-1] if use.reversed else on, ends)
    use = edge.uses[1]
    (u0, u1), (v0, v1) = moved.patches[1].domain
    u = (u0, u1)[use.index]
    on = moved.patches[1].evaluate([[u, v0], [u, v1]])
    assert np.allclose(on[::-1] if use.reversed else on, ends)


def test_level_sides_turn_round_when_u_does():
    curve = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [1.5, 0, 0]])
    edge = BodyEdge(curve, 0.0, (EdgeUse(0, -1, 2, False),), ((0.0, 1.5),))
    flipped = Body(plate(), edges=[edge]).flipped().edges[0]
    assert flipped.uses == (EdgeUse(0, -1, 2, True),)
    assert flipped.spans == ((0.5, 2.0),)


def test_a_reflection_keeps_the_free_side_free():
    ball = Body(shapes.sphere(radius=2.0))
    mirrored = ball.transformed(np.diag([1.0, -1.0, 1.0, 1.0]))
    assert mirrored.volume() == pytest.approx(ball.volume(), rel=1e-12)
    assert ball.volume() > 0.0
    body = with_hole().transformed(np.diag([-1.0, 1.0, 1.0, 1.0]))
    points, inside = in_space(body)
    assert np.array_equal(inside, of_the_plate(points * [-1, 1, 1]))


def test_motions_carry_points_edges_and_reference_along():
    body = with_hole()
    turned = body.rotated("z", math.pi / 2).translated([1, 0, 5]).scaled(2.0)
    assert np.allclose(turned.reference_point, [-2, 2, 16])
    assert np.allclose(turned.edges[0].curve.control_points[0], [-4, 4, 10])
    assert turned.area() == pytest.approx(44.0, rel=1e-12)
    assert turned.unit == "mm"
    assert turned.name == "plate"


@pytest.mark.parametrize(
    "matrix", [np.eye(3), np.full((4, 4), np.nan), np.diag([1.0, 0.0, 1.0, 1.0])]
)
def test_matrices_that_are_no_motion_are_refused(matrix):
    with pytest.raises(InputError):
        with_hole().transformed(matrix)


def test_profile_is_given_depth_about_its_plane_with_the_free_side_to_its_right():
    bottom = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [4, 0, 0]])
    body = Body.from_profile(bottom, depth=0.5)
    assert np.allclose(body.bounds(), [[0, 0, -0.25], [4, 0, 0.25]])
    assert np.allclose(body.patches[0].normal([[0.3, 0.0]]), [[0, -1, 0]])
    assert body.area() == pytest.approx(2.0)


def test_closed_profile_run_anticlockwise_has_normals_outward():
    body = Body.from_profile(shapes.circle(radius=2.0))
    uv = [[u, 0.0] for u in np.linspace(*body.patches[0].domain[0], 9)]
    points = body.patches[0].evaluate(uv)
    assert np.all(np.einsum("ij,ij->i", points, body.patches[0].normal(uv)) > 1.99)
    assert body.area() == pytest.approx(4 * math.pi, rel=1e-12)


def test_a_rough_area_is_not_kept():
    body = Body(shapes.ellipsoid())
    rough = body.area(0.5)
    assert body.area() == Body(shapes.ellipsoid()).area() != rough


@pytest.mark.parametrize("depth", [0.0, -1.0, math.nan, math.inf])
def test_profile_needs_a_depth(depth):
    line = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [4, 0, 0]])
    with pytest.raises(GeometryError, match="depth"):
        Body.from_profile(line, depth)


def test_profile_must_be_plane():
    line = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [4, 0, 1]])
    with pytest.raises(GeometryError, match="z = 0"):
        Body.from_profile(line)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (shapes.sphere(radius=2.0), 32 * math.pi / 3),
        (shapes.torus(major=3.0, minor=1.0), 6 * math.pi**2),
    ],
)
def test_volume_is_that_of_the_closed_form_wherever_the_body_is(shape, volume):
    body = Body(shape)
    assert body.volume() == pytest.approx(volume, rel=1e-9)
    assert body.flipped().volume() == pytest.approx(-volume, rel=1e-9)
    assert body.translated([1e3, -1e3, 1e3]).volume() == pytest.approx(volume, rel=1e-8)


def test_triangles_obey_the_trims():
    body = with_hole()
    mesh = body.tessellate(0.01)
    assert mesh.area() == pytest.approx(11.0, rel=1e-12)
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    assert np.all(of_the_plate(middles) | (middles[:, 0] > 2.0))


def test_triangles_of_a_trimmed_curved_face_stay_within_the_tolerance():
    ball = shapes.sphere(radius=1.0)
    (u0, u1), (v0, v1) = ball.domain
    square = np.array([[0.2, 0.3], [0.5, 0.3], [0.6, 0.7], [0.2, 0.7]])
    corners = [(u0 + a * (u1 - u0), v0 + b * (v1 - v0)) for a, b in square]
    body = Body(ball, trims=[[polygon(*corners)]])
    errors = []
    for tol in (1e-2, 1e-3, 1e-4):
        mesh = body.tessellate(tol)
        middles = mesh.vertices[mesh.triangles].mean(axis=1)
        assert 1.0 - np.linalg.norm(middles, axis=1).min() <= 2.0 * tol
        errors.append(abs(mesh.area() / body.area() - 1.0))
        normals = np.cross(
            mesh.vertices[mesh.triangles[:, 1]] - mesh.vertices[mesh.triangles[:, 0]],
            mesh.vertices[mesh.triangles[:, 2]] - mesh.vertices[mesh.triangles[:, 0]],
        )
        assert np.all(np.einsum("ij,ij->i", normals, middles) > 0.0)
    assert errors[0] > 5 * errors[1] > 25 * errors[2]


def test_tessellation_needs_a_tolerance():
    with pytest.raises(InputError):
        with_hole().tessellate(0.0)


def test_summary_counts_what_is_there():
    summary = body_summary(with_hole())
    assert summary["patches"] == 2
    assert summary["degrees"] == {"1 × 1": 2}
    assert summary["rational"] == 0
    assert (summary["trimmed"], summary["loops"]) == (1, 2)
    assert (summary["shared_edges"], summary["free_edges"]) == (1, 0)
    assert summary["bounds"] == [[0, 0, 0], [4, 3, 0]]
    assert summary["area"] == pytest.approx(11.0)
    assert summary["unit"] == "mm"
    assert body_summary(Body(shapes.sphere(radius=1.0)))["rational"] == 1
