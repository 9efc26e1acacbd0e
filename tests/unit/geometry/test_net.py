"""Control points of a body in one array, and places that its surface carries along."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.geometry.net import NetMotion, dependence_of, net_of, spread
from contiga.records import SurfacePlaces


def bent(body: cg.Body, seed: int = 0, by: float = 0.05) -> np.ndarray:
    """Control points of a body that are moved at random."""
    points = body.net.points
    return points + by * body.size * np.random.default_rng(seed).standard_normal(points.shape)


def brick() -> cg.Body:
    """A box of 1 by 2 by 3 of six patches."""
    at = np.stack(np.meshgrid([0.0, 1.0], [0.0, 2.0], [0.0, 3.0], indexing="ij"), axis=-1)
    faces = []
    for axis in range(3):
        low, high = (at.take(end, axis) for end in (0, 1))
        faces += [low.swapaxes(0, 1), high] if axis != 1 else [low, high.swapaxes(0, 1)]
    return cg.Body([cg.shapes.bilinear(f[0, 0], f[1, 0], f[0, 1], f[1, 1]) for f in faces])


def places_on(body: cg.Body, n: int = 40) -> SurfacePlaces:
    rng = np.random.default_rng(1)
    patch = rng.integers(0, len(body.patches), n).astype(np.int32)
    ends = np.array([body.patches[k].domain for k in patch])
    uv = ends[:, :, 0] + rng.uniform(0.02, 0.98, (n, 2)) * np.diff(ends, axis=2)[..., 0]
    return SurfacePlaces(patch, uv)


def surface_points(body: cg.Body, points: np.ndarray, places: SurfacePlaces) -> np.ndarray:
    """Points of the surface that a body has with other control points."""
    out = np.empty((len(places.patch), 3))
    for k, patch in enumerate(body.patches):
        net = points[body.net.control[k]]
        rows = places.patch == k
        shape = cg.NurbsSurface(patch.degrees, patch.knots, net, patch.weights)
        out[rows] = shape.evaluate(places.uv[rows])
    return out


BODIES = {
    "bumpy": lambda: cg.Body([cg.shapes.bumpy_plate(waves=2)]),
    "sphere": lambda: cg.Body([cg.shapes.sphere(radius=2.0)]),
    "box": brick,
}


def test_a_ball_has_its_seam_and_its_poles_once() -> None:
    net = cg.Body([cg.shapes.sphere(radius=1.0)]).net
    control = net.control[0]
    assert net.points.shape == (8 * 3 + 2, 3)
    np.testing.assert_array_equal(control[0], control[-1])
    assert len(np.unique(control[:, 0])) == len(np.unique(control[:, -1])) == 1


def test_patches_share_the_control_points_of_their_edges_and_no_others() -> None:
    body = brick()
    assert body.closed
    assert len(body.net.points) == 8
    for patch, control in zip(body.patches, body.net.control, strict=True):
        np.testing.assert_array_equal(body.net.points[control], patch.control_points)


def test_points_inside_a_patch_stay_apart_where_they_lie_in_one_place() -> None:
    net = np.zeros((3, 3, 3))
    net[..., 0], net[..., 1] = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], indexing="ij")
    net[1, 1] = net[0, 0]
    patch = cg.NurbsSurface((2, 2), ([0, 0, 0, 1, 1, 1],) * 2, net)
    assert len(cg.Body([patch]).net.points) == 9


@pytest.mark.interpreted
@pytest.mark.parametrize("name", BODIES)
def test_what_turns_as_a_whole_carries_its_places_with_it(name: str) -> None:
    body = BODIES[name]()
    shape, feet = bent(body), places_on(body)
    points = surface_points(body, shape, feet) + 0.3
    spin, speed = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -3.0])
    moved = NetMotion(body, shape, np.cross(spin, shape) + speed).carry(feet, points)
    np.testing.assert_allclose(moved, np.cross(spin, points) + speed, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", BODIES)
def test_a_place_on_the_surface_goes_where_the_surface_goes(name: str) -> None:
    body = BODIES[name]()
    shape, feet, change = bent(body), places_on(body), bent(body, 5) - body.net.points
    before, after = (surface_points(body, at, feet) for at in (shape, shape + change))
    moved = NetMotion(body, shape, change).carry(feet, before)
    np.testing.assert_allclose(moved, after - before, rtol=0, atol=1e-13 * body.size)


def test_a_place_off_the_surface_turns_with_its_normal() -> None:
    body = BODIES["bumpy"]()
    shape, feet = bent(body, by=0.01), places_on(body)
    change, gap, h = bent(body, 7, 0.01) - body.net.points, 0.2, 1e-6

    def off(points: np.ndarray) -> np.ndarray:
        patch = body.patches[0]
        at = cg.NurbsSurface(patch.degrees, patch.knots, points[body.net.control[0]])
        return at.evaluate(feet.uv) + gap * at.normal(feet.uv)

    moved = NetMotion(body, shape, change).carry(feet, off(shape))
    central = (off(shape + h * change) - off(shape - h * change)) / (2.0 * h)
    np.testing.assert_allclose(moved, central, rtol=0, atol=1e-8)


@pytest.mark.interpreted
@pytest.mark.parametrize("name", BODIES)
def test_forces_on_control_points_do_the_same_work_and_balance(name: str) -> None:
    body = BODIES[name]()
    shape, feet = bent(body), places_on(body)
    rng = np.random.default_rng(3)
    points = surface_points(body, shape, feet) + rng.standard_normal((40, 3))
    forces, change = rng.standard_normal((40, 3)), rng.standard_normal(shape.shape)
    back = spread(body, shape, feet, points, forces)
    carried = NetMotion(body, shape, change).carry(feet, points)
    assert abs((back * change).sum() - (forces * carried).sum()) < 1e-10
    np.testing.assert_allclose(back.sum(axis=0), forces.sum(axis=0), rtol=0, atol=1e-12)
    moment = np.cross(points, forces).sum(axis=0)
    np.testing.assert_allclose(np.cross(shape, back).sum(axis=0), moment, rtol=0, atol=1e-11)


def test_a_surface_without_a_normal_carries_and_feels_forces_all_the_same() -> None:
    body = BODIES["bumpy"]()
    flat = np.zeros(body.net.points.shape)
    flat[:, 0] = np.arange(len(flat))  # all of it on a line
    feet = places_on(body, 3)
    points, forces = np.ones((3, 3)), np.eye(3)
    np.testing.assert_allclose(
        spread(body, flat, feet, points, forces).sum(axis=0), [1.0, 1.0, 1.0], rtol=1e-12
    )
    moved = NetMotion(body, flat, np.ones(flat.shape)).carry(feet, points)
    np.testing.assert_allclose(moved, 1.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("points", "told"),
    [
        (np.zeros((25, 3)), r"must have one row a control point of the body.*\(26, 3\)"),
        (np.full((26, 3), np.nan), r"control_points\[0\]: control points must be finite"),
        (np.zeros((9, 5, 3)), r"control_points"),
        ("all", r"control_points"),
    ],
)
def test_control_points_that_do_not_fit_are_refused(points: object, told: str) -> None:
    net = net_of(cg.Body([cg.shapes.sphere(radius=1.0)]))
    with pytest.raises(InputError, match=told):
        net.checked(points)


@pytest.mark.parametrize("name", BODIES)
def test_places_depend_on_control_points_by_functions_whose_sum_is_one(name: str) -> None:
    """Σ N_i P_i is the place, Σ P_i (∇N_i)ᵀ the projection on the tangent plane."""
    body = BODIES[name]()
    shape, places = bent(body), places_on(body)
    found = dependence_of(body, shape, places).entries
    k = len(places.patch)
    sums, at, slopes = np.zeros(k), np.zeros((k, 3)), np.zeros((k, 3, 3))
    np.add.at(sums, found.place, found.value)
    np.add.at(at, found.place, found.value[:, None] * shape[found.control])
    np.add.at(slopes, found.place, shape[found.control][:, :, None] * found.gradient[:, None, :])
    np.testing.assert_allclose(sums, 1.0, atol=1e-13)
    np.testing.assert_allclose(at, surface_points(body, shape, places), atol=1e-12 * body.size)
    np.testing.assert_allclose(slopes, slopes.transpose(0, 2, 1), atol=1e-10)
    np.testing.assert_allclose(slopes @ slopes, slopes, atol=1e-10)
    np.testing.assert_allclose(np.trace(slopes, axis1=1, axis2=2), 2.0, atol=1e-10)


@pytest.mark.interpreted
@pytest.mark.parametrize("name", BODIES)
def test_hessians_are_how_gradients_change_along_the_surface(name: str) -> None:
    """Along a way t over the surface ∇φ changes by H t within the tangent plane, for a field φ."""
    body, h = BODIES[name](), 1e-6
    shape, at = bent(body, by=0.01), places_on(body)
    field, way = bent(body, 9), np.random.default_rng(2).standard_normal(at.uv.shape)
    found = dependence_of(body, shape, at)
    low, high = (
        dependence_of(body, shape, SurfacePlaces(at.patch, at.uv + step * way)) for step in (-h, h)
    )
    tangent = (high.jet(shape).value - low.jet(shape).value) / (2.0 * h)
    change = (high.jet(field).gradient - low.jet(field).gradient) / (2.0 * h)
    n = found.normal
    change -= np.einsum("kab,kb,kc->kac", change, n, n)
    wanted = np.einsum("kabc,kc->kab", found.jet(field).hessian, tangent)
    np.testing.assert_allclose(wanted, change, rtol=0.0, atol=1e-7 * np.abs(change).max())
    turned = (high.normal - low.normal) / (2.0 * h)
    shape_operator = np.einsum("ka,kabc->kbc", n, found.jet(shape).hessian)
    wanted = -np.einsum("kbc,kc->kb", shape_operator, tangent)
    np.testing.assert_allclose(wanted, turned, rtol=0.0, atol=1e-7 * np.abs(turned).max())
