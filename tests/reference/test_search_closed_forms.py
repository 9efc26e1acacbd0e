"""Feet, normals, signs and entries on shapes whose answers are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.statuses import Feature, Status

RNG = np.random.default_rng(20)
N = 400


def unit(x):
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def on_sphere(n, seed=1):
    return unit(np.random.default_rng(seed).normal(size=(n, 3)))


def ellipse_distance(a, b, x, y):
    """Distance of (x, y), both >= 0, to the ellipse, and the foot: bisection (Eberly 2013)."""
    z0, z1 = x / a, y / b
    r0 = (a / b) ** 2
    low, high = z1 - 1.0, np.hypot(r0 * z0, z1) - 1.0
    for _ in range(200):
        s = 0.5 * (low + high)
        g = (r0 * z0 / (s + r0)) ** 2 + (z1 / (s + 1.0)) ** 2 - 1.0
        low, high = np.where(g > 0, s, low), np.where(g > 0, high, s)
    fx, fy = r0 * x / (s + r0), y / (s + 1.0)
    return np.hypot(fx - x, fy - y), fx, fy


def check(feet, point, normal, gap, size):
    np.testing.assert_allclose(feet.point, point, rtol=0, atol=1e-11 * size)
    np.testing.assert_allclose(feet.normal, normal, rtol=0, atol=1e-9)
    np.testing.assert_allclose(feet.gap, gap, rtol=0, atol=1e-12 * size)
    assert (feet.status == Status.OK).all()


@pytest.mark.parametrize("radius", [1.0, 3e-5, 2e4])
def test_sphere_inside_and_outside(radius):
    body = cg.Body([cg.shapes.sphere(radius=radius, centre=[radius, 0, 0])])
    n = on_sphere(N)
    r = radius * RNG.uniform(0.05, 3.0, N)
    feet = body.project(n * r[:, None] + [radius, 0, 0])
    check(feet, n * radius + [radius, 0, 0], n, r - radius, radius)
    np.testing.assert_array_equal(body.contains(n * r[:, None] + [radius, 0, 0]), r <= radius)


def test_cylinder_side():
    body = cg.Body([cg.shapes.cylinder(radius=2.0, height=5.0)])
    low, high = body.bounds()
    angle = RNG.uniform(0, 2 * np.pi, N)
    n = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    r, z = RNG.uniform(0.1, 6, N), RNG.uniform(low[2], high[2], N)
    up = np.outer(z, [0, 0, 1])
    check(body.project(n * r[:, None] + up), 2 * n + up, n, r - 2, 5.0)


def test_torus():
    body = cg.Body([cg.shapes.torus(major=3.0, minor=1.0)])
    p = RNG.uniform(-5, 5, (N, 3))
    ring = p * [1, 1, 0]
    centre = 3.0 * unit(ring)
    n = unit(p - centre)
    check(body.project(p), centre + n, n, np.linalg.norm(p - centre, axis=1) - 1, 8.0)


def test_plane_and_past_its_edges():
    body = cg.Body([cg.shapes.plane(width=2.0, length=1.0)])
    low, high = body.bounds()
    p = RNG.uniform(-2, 2, (N, 3))
    foot = np.clip(p, low, high)
    feet = body.project(p)
    np.testing.assert_allclose(feet.point, foot, atol=1e-12)
    np.testing.assert_allclose(np.abs(feet.gap), np.linalg.norm(p - foot, axis=1), atol=1e-12)
    np.testing.assert_array_equal(np.sign(feet.gap), np.sign(p[:, 2]))
    held = (p[:, :2] != foot[:, :2]).sum(axis=1)
    np.testing.assert_array_equal(feet.feature, held)
    np.testing.assert_array_equal(feet.status == Status.BORDER, held > 0)


def test_cone_with_apex():
    """Generatrix from (1, 0, 0) to the apex (0, 0, 2), seen in the half plane of the point."""
    body = cg.Body([cg.shapes.cone(radius=1.0, height=2.0)])
    low, high = body.bounds()
    base, apex = np.array([1.0, low[2]]), np.array([0.0, high[2]])
    angle = RNG.uniform(0, 2 * np.pi, N)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    r, z = RNG.uniform(0.0, 2.0, N), RNG.uniform(low[2] - 1, high[2] + 2, N)
    along = (apex - base) / np.linalg.norm(apex - base)
    half = np.stack([r, z], axis=1) - base
    share = np.clip(half @ along, 0, np.linalg.norm(apex - base))
    foot = base + share[:, None] * along
    distance = np.linalg.norm(np.stack([r, z], axis=1) - foot, axis=1)
    feet = body.project(np.column_stack([around * r[:, None], z]))
    np.testing.assert_allclose(np.abs(feet.gap), distance, atol=1e-12)
    at_apex = share >= np.linalg.norm(apex - base)
    assert at_apex.sum() > 20
    assert (feet.feature[at_apex] == Feature.VERTEX).all()
    assert (feet.gap[at_apex] > 0).all()
    np.testing.assert_allclose(feet.point[at_apex], [[0, 0, high[2]]] * at_apex.sum(), atol=1e-11)


def test_sharp_cone_has_its_outside_above_the_apex():
    """Half angle 6 degrees: most generatrices have normals that point away from such a point."""
    body = cg.Body([cg.shapes.cone(radius=0.1, height=1.0)])
    top = body.bounds()[1, 2]
    angle = np.linspace(0, 2 * np.pi, 50)
    p = np.column_stack([3 * np.cos(angle), 3 * np.sin(angle), np.full(50, top + 1.0)])
    feet = body.project(p)
    assert (feet.feature == Feature.VERTEX).all()
    np.testing.assert_allclose(feet.gap, np.sqrt(10.0), atol=1e-12)


def test_spheroid():
    body = cg.Body([cg.shapes.ellipsoid(axes=(3.0, 3.0, 1.0))])
    p = RNG.uniform(-4, 4, (N, 3))
    rho = np.hypot(p[:, 0], p[:, 1])
    distance, fx, fz = ellipse_distance(3.0, 1.0, rho, np.abs(p[:, 2]))
    feet = body.project(p)
    np.testing.assert_allclose(np.abs(feet.gap), distance, atol=1e-11)
    np.testing.assert_allclose(np.hypot(*feet.point[:, :2].T), fx, atol=1e-9)
    np.testing.assert_allclose(np.abs(feet.point[:, 2]), fz, atol=1e-9)
    inside = (rho / 3) ** 2 + p[:, 2] ** 2 < 1
    np.testing.assert_array_equal(feet.gap < 0, inside)


def tracked_turns(body, path):
    """Track one point along a path; statuses and feet of every step."""
    feet = body.project(path[:1])
    values = [feet]
    for p in path[1:]:
        feet = body.project(p[None], start=feet, mode="track")
        values.append(feet)
    statuses = np.concatenate([f.status for f in values])
    return statuses, np.concatenate([f.point for f in values]), values


@pytest.mark.parametrize("r", [0.4, 1.3])
def test_ten_turns_round_a_seam(r):
    body = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    angle = np.linspace(0, 20 * np.pi, 700)
    n = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    z = body.bounds().mean(axis=0)[2]
    status, point, _ = tracked_turns(body, r * n + np.array([0, 0, z]))
    assert (status == Status.OK).all()
    np.testing.assert_allclose(point, n + np.array([0, 0, z]), atol=1e-11)


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-4, 0.1])
@pytest.mark.parametrize("r", [0.7, 1.3])
def test_ten_turns_over_the_poles(tilt, r):
    body = cg.Body([cg.shapes.sphere()])
    angle = np.linspace(0, 20 * np.pi, 640)  # meets the poles on and off its steps
    n = np.stack(
        [np.cos(tilt) * np.sin(angle), np.sin(tilt) * np.sin(angle) + tilt, np.cos(angle)], axis=1
    )
    n = unit(n)
    status, point, _ = tracked_turns(body, r * n)
    assert (status == Status.OK).all()
    np.testing.assert_allclose(point, n, atol=1e-8)


def box_faces(size=(2.0, 3.0, 4.0)):
    x, y, z = size
    c = {(i, j, k): (i * x, j * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    quads = [
        [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)],
        [(0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)],
        [(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 1)],
        [(0, 1, 0), (0, 1, 1), (1, 1, 0), (1, 1, 1)],
        [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1)],
        [(1, 0, 0), (1, 1, 0), (1, 0, 1), (1, 1, 1)],
    ]
    return [cg.shapes.bilinear(*(c[k] for k in quad)) for quad in quads]


def box_of_one_patch(size=(2.0, 3.0, 4.0)):
    """The sides as one closed ring of degree (1, 1), the ends drawn together to their middles."""
    x, y, z = size
    ring = np.array([[0, 0], [x, 0], [x, y], [0, y], [0, 0]])
    middle = np.tile([x / 2, y / 2], (5, 1))
    rows = [(middle, 0.0), (ring, 0.0), (ring, z), (middle, z)]
    net = np.stack([np.column_stack([flat, np.full(5, h)]) for flat, h in rows], axis=1)
    U, V = [0, 0, 1, 2, 3, 4, 4], [0, 0, 1, 2, 3, 3]
    return cg.NurbsSurface((1, 1), (U, V), net)


def box_answer(p, size=(2.0, 3.0, 4.0)):
    size = np.array(size)
    foot = np.clip(p, 0, size)
    outside = (foot != p).any(axis=1)
    deep = np.minimum(p, size - p).min(axis=1)
    return np.where(outside, np.linalg.norm(p - foot, axis=1), -deep), (foot != p).sum(axis=1)


@pytest.mark.parametrize("kind", ["one patch", "six patches"])
def test_a_box_is_the_same_as_one_c0_patch_and_as_six(kind):
    body = cg.Body([box_of_one_patch()] if kind == "one patch" else box_faces())
    p = np.random.default_rng(3).uniform(-2, 6, (2000, 3))
    gap, held = box_answer(p)
    feet = body.project(p)
    np.testing.assert_allclose(feet.gap, gap, atol=1e-11)
    assert (feet.status == Status.OK).all()
    outside = gap > 0
    np.testing.assert_array_equal(feet.feature[outside], held[outside] - 1)
    np.testing.assert_array_equal(body.contains(p), gap < 0)


@pytest.mark.parametrize("kind", ["one patch", "six patches"])
def test_tracking_around_a_box_keeps_to_the_closest_point_outside(kind):
    """Outside a convex body the continued foot is the closest point: over edges and corners."""
    body = cg.Body([box_of_one_patch()] if kind == "one patch" else box_faces())
    n = on_sphere(60, seed=4)
    turn = unit(np.cross(n, on_sphere(60, seed=5)))
    feet = None
    for angle in np.linspace(0, 2 * np.pi, 80):
        p = np.array([1, 1.5, 2]) + 4.0 * (np.cos(angle) * n + np.sin(angle) * turn)
        feet = body.project(p) if feet is None else body.project(p, start=feet, mode="track")
        gap, held = box_answer(p)
        np.testing.assert_allclose(feet.gap, gap, atol=1e-11)
        np.testing.assert_array_equal(feet.feature, held - 1)
        assert (feet.status == Status.OK).all()


def test_a_sharp_wedge_has_the_right_side_past_its_edge():
    """Edge of 20 degrees: the normal of one face alone tells the wrong side."""
    a = np.radians(10.0)
    tip = ([0, 0, 0], [0, 1, 0])
    up, down = np.array([-np.cos(a), 0, np.sin(a)]), np.array([-np.cos(a), 0, -np.sin(a)])
    over = cg.shapes.bilinear(tip[0], tip[1], up, up + np.array([0, 1, 0])).flipped()
    under = cg.shapes.bilinear(tip[0], tip[1], down, down + np.array([0, 1, 0]))
    n_over = over.normal([[0.5, 0.5]])[0]
    body = cg.Body(
        [
            over if n_over[2] > 0 else over.flipped(),
            under if under.normal([[0.5, 0.5]])[0, 2] < 0 else under.flipped(),
        ]
    )
    angle = np.radians(np.linspace(-75, 75, 31))
    p = np.column_stack([np.cos(angle), np.full(31, 0.5), np.sin(angle)])
    feet = body.project(p)
    assert (feet.feature == Feature.EDGE).all()
    np.testing.assert_allclose(feet.gap, 1.0, atol=1e-12)


def test_ties_are_broken_the_same_way_every_time():
    ball, tube = cg.Body([cg.shapes.sphere()]), cg.Body([cg.shapes.cylinder(radius=1.0)])
    for body, p in ((ball, [[0.0, 0, 0]] * 8), (tube, [[0.0, 0, 0.3]] * 8)):
        feet = body.project(p)
        np.testing.assert_allclose(feet.gap, -1.0, atol=1e-12)
        assert (feet.status == Status.OK).all()
        again = body.project(p)
        np.testing.assert_array_equal(feet.uv, again.uv)
        np.testing.assert_array_equal(feet.uv, np.tile(feet.uv[0], (8, 1)))


@pytest.mark.parametrize("offset", [1e-12, 1e-9, 1e-6, 1e-3])
def test_next_to_the_centre_and_the_axis(offset):
    n = on_sphere(40, seed=6)
    feet = cg.Body([cg.shapes.sphere()]).project(offset * n)
    np.testing.assert_allclose(feet.gap, offset - 1, atol=1e-12)
    assert (feet.status == Status.OK).all()
    ring = unit(n * [1, 1, 0])
    feet = cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]).project(3 * ring + offset * n)
    # The tube's middle line: offsets along the ring do not count.
    away = np.linalg.norm(offset * (n - ring * (n * ring).sum(axis=1)[:, None]), axis=1)
    assert (np.abs(np.abs(feet.gap) - 1) <= offset + 1e-12).all()
    assert len(away) == 40


def test_entries_into_a_sphere():
    body = cg.Body([cg.shapes.sphere()])
    a, b = on_sphere(N, 7) * 2, on_sphere(N, 8) * RNG.uniform(0, 2, (N, 1))
    d = b - a
    dd, ad, aa = (d * d).sum(1), (a * d).sum(1), (a * a).sum(1) - 1
    root = ad**2 - dd * aa
    tau = (-ad - np.sqrt(np.maximum(root, 0))) / dd
    meets = (root > 1e-12) & (tau >= 0) & (tau <= 1)
    hit = body.first_hit(a, b)
    np.testing.assert_array_equal(hit.status == Status.OK, meets)
    np.testing.assert_allclose(hit.fraction[meets], tau[meets], atol=1e-10)
    assert (hit.status[~meets] == Status.NO_HIT).all()
    assert np.isnan(hit.fraction[~meets]).all()


def test_entries_through_poles_seams_and_knot_lines():
    body = cg.Body([cg.shapes.sphere()])
    knots = np.linspace(0, 2 * np.pi, 9)
    heights = np.radians([-90, -45, 0, 45, 90])
    angle, height = (x.ravel() for x in np.meshgrid(knots, heights))
    n = np.stack(
        [np.cos(angle) * np.cos(height), np.sin(angle) * np.cos(height), np.sin(height)], axis=1
    )
    hit = body.first_hit(2 * n, 0 * n)
    np.testing.assert_allclose(hit.fraction, 0.5, atol=1e-12)
    assert (hit.status == Status.OK).all()
    outwards = body.first_hit(0 * n, 2 * n)  # leaves through the surface: no entry
    assert (outwards.status == Status.NO_HIT).all()


def test_entries_into_a_box_through_edges_and_corners():
    for body in (cg.Body(box_faces()), cg.Body([box_of_one_patch()])):
        middle = np.array([1.0, 1.5, 2.0])
        corner = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) * [2.0, 3, 4]
        edge = np.array([[0, 1.5, 0], [2, 0, 2.0], [1, 3, 4]])
        to = np.concatenate([corner, edge])
        hit = body.first_hit(middle + 2 * (to - middle), np.tile(middle, (len(to), 1)))
        np.testing.assert_allclose(hit.fraction, 0.5, atol=1e-9)


def test_a_segment_that_starts_on_the_surface_and_leads_inside():
    body = cg.Body([cg.shapes.sphere()])
    n = on_sphere(100, 9)
    inward = body.first_hit(n, 0.5 * n)
    outward = body.first_hit(n, 1.5 * n)
    assert np.isin(inward.status, (Status.AT_START, Status.OK)).all()
    np.testing.assert_allclose(inward.fraction, 0, atol=1e-11)
    assert (outward.status == Status.NO_HIT).all()


def test_two_sheets_and_thin_walls_in_one_step():
    """The first of two parallel sheets counts; walls as thin as 1e-7 of the size are not missed."""
    for wall in (1e-2, 1e-5, 1e-7):
        top = cg.shapes.plane(width=2.0, length=2.0)
        low = cg.shapes.plane(width=2.0, length=2.0, centre=[0, 0, -wall]).flipped()
        body = cg.Body([top, low])
        xy = RNG.uniform(-0.9, 0.9, (200, 2))
        a, b = np.column_stack([xy, np.full(200, 1.0)]), np.column_stack([xy, np.full(200, -1.0)])
        down, up = body.first_hit(a, b), body.first_hit(b, a)
        np.testing.assert_allclose(down.fraction, 0.5, atol=1e-12)
        np.testing.assert_allclose(up.fraction, 0.5 - 0.5 * wall, atol=1e-12)
        assert (down.patch == 0).all()
        assert (up.patch == 1).all()


def test_grazing_segments_are_decided_by_their_depth():
    body = cg.Body([cg.shapes.sphere()])
    depth = np.array([1e-3, 1e-5, 1e-7, 1e-9])
    for sign in (1, -1):
        z = 1 - sign * depth
        a = np.column_stack([np.full(4, -1.0), 0 * z, z])
        b = np.column_stack([np.full(4, 1.0), 0 * z, z])
        hit = body.first_hit(a, b)
        if sign < 0:
            assert (hit.status == Status.NO_HIT).all()
        else:
            assert (hit.status == Status.OK).all()
            chord = np.sqrt(1 - z**2)
            np.testing.assert_allclose(hit.fraction, 0.5 - 0.5 * chord, atol=1e-11)
