"""Contact areas against closed forms, with the order in which they are reached."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import contiga as cg

SIZES = (16, 32, 64, 128)
FINE = (32, 64, 128, 192)
FINEST = (48, 96, 192, 256)
# A cut mesh errs by chance as well: errors are root mean squares over these places of the mesh.
SHIFTS = ((0.0123, 0.0077), (-0.0031, 0.0164), (0.0049, -0.0098), (-0.0142, -0.0057))


def grid(n, half, shift=SHIFTS[0], other=None):
    """Nodes (x, y) and triangles of a rectangle, off the axes so that nothing lines up."""
    x = np.linspace(-half, half, n + 1) + shift[0]
    y = np.linspace(-(other or half), other or half, n + 1) + shift[1]
    xy = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(xy)).reshape(len(x), len(y))
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return xy, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def flat(z):
    return lambda xy: np.column_stack([xy, np.full(len(xy), z)])


def ball_below(radius, centre_z):
    """The lower side of a sphere over the plane of its nodes."""
    return lambda xy: np.column_stack(
        [xy, centre_z - np.sqrt(radius**2 - np.square(xy).sum(axis=1))]
    )


def touch(body, xy_facets, place, area, law=None, kind="slave"):
    xy, facets = xy_facets
    slave = cg.Slave(place(xy), facets)
    contact = cg.Contact(
        body,
        slave,
        law=law or cg.PenaltyLaw(1.0),
        area=area,
        search="penetration",
        contact_type=kind,
    )
    return contact.start(slave.points)


def errors_of(value, exact, half, other=None, sizes=SIZES):
    """Relative errors of value(mesh) at each size, root mean square over the shifts."""
    return [
        np.sqrt(np.mean([(value(grid(n, half, s, other)) / exact - 1.0) ** 2 for s in SHIFTS]))
        for n in sizes
    ]


def order(errors, sizes=SIZES):
    """Slope of log error over log size, least squares."""
    return -np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def plate(width=4.0):
    return cg.Body([cg.shapes.plane(width=width, length=width)])


def scenes():
    R, h = 1.0, 0.2
    d = R - h
    a = np.sqrt(R * R - d * d)
    low = ball_below(R, d)
    yield "ball in a plane, disc", plate(), low, 0.66, ("master", np.pi * a * a, 1)
    yield "ball in a plane, its own cap", plate(), low, 0.66, ("slave", 2 * np.pi * R * h, 1)

    r, c = 0.8, 0.22  # a ball in a hollow one, touching where it comes through the wall
    hollow = cg.Body([cg.shapes.sphere(radius=1.0)]).flipped()
    z = (r * r - 1.0 - c * c) / (2 * c)
    inner = ball_below(r, -c)
    yield "ball in a hollow ball, wall", hollow, inner, 0.5, ("master", 2 * np.pi * (1 + z), 1)
    own = 2 * np.pi * r * (z + c + r)
    yield "ball in a hollow ball, ball", hollow, inner, 0.5, ("slave", own, 1)

    two = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    b2 = 0.25 - 0.35**2
    yield "two discs", two, flat(0.35), 0.99, ("slave", 2 * np.pi * b2, 2)
    yield "two caps", two, flat(0.35), 0.99, ("master", 2 * 2 * np.pi * 0.5 * 0.15, 2)

    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.4)])
    half_width = np.sqrt(0.16 - 0.09)
    yield "annulus", ring, flat(0.3), 1.6, ("slave", 4 * np.pi * half_width, 1)
    alpha = np.arccos(0.3 / 0.4)
    yield "ring of a torus", ring, flat(0.3), 1.6, ("master", 4 * np.pi * 0.4 * alpha, 1)


@pytest.mark.parametrize("scene", list(scenes()), ids=lambda s: s[0])
def test_facet_area_is_of_second_order(scene):
    _, body, place, half, (on, exact, clusters) = scene

    def area(mesh):
        state = touch(body, mesh, place, cg.FacetArea(on))
        assert state.n_clusters == clusters
        return state.total_area

    errors = errors_of(area, exact, half)
    assert order(errors) >= 1.9
    assert errors[-1] < 3e-3


@pytest.mark.parametrize("scene", list(scenes())[::2], ids=lambda s: s[0])
def test_facets_are_closer_than_the_hulls_of_the_thesis_at_equal_point_count(scene):
    # On the master, what hulls measure: the closed form of the pair that is taken there.
    name, body, place, half, _ = scene
    exact = {other[0]: other[4][1] for other in scenes() if other[4][0] == "master"}
    on_master = {"two discs": "two caps", "annulus": "ring of a torus"}.get(name, name)

    def error(method):
        def area(mesh):
            return touch(body, mesh, place, method).total_area

        return errors_of(area, exact[on_master], half, sizes=(64,))[0]

    facet, cloud = error(cg.FacetArea("master")), error(cg.CloudArea("master", by="feet"))
    hulls = [error(cg.HullArea("auto", mapping)) for mapping in ("linear", "exact")]
    assert 3.0 * facet < min(hulls)
    assert 2.0 * cloud < min(hulls)


@pytest.mark.parametrize("on", ["master", "slave"])
def test_cylinder_in_a_trough_that_ends_before_it(on):
    # Wider slave than master: contact ends at the border of the trough, which is cut exactly.
    R, r, c, length = 1.0, 0.7, 0.4, 1.1
    trough = cg.Body([cg.shapes.cylinder(radius=R, height=length, axis="x")]).flipped()
    z = (r * r - R * R - c * c) / (2 * c)
    exact = {
        "master": 2.0 * np.arccos(-z / R) * R * length,
        "slave": 2.0 * np.arccos(-(z + c) / r) * r * length,
    }[on]

    def place(xy):
        return np.column_stack([xy, -c - np.sqrt(r * r - xy[:, 1] ** 2)])

    def area(mesh):
        return touch(trough, mesh, place, cg.FacetArea(on)).total_area

    errors = errors_of(area, exact, 0.8, 0.6)
    assert order(errors) >= 1.9


@pytest.mark.parametrize("on", ["master", "slave"])
def test_plate_larger_than_its_master_touches_all_of_it(on):
    body = cg.Body([cg.shapes.plane(width=1.0, length=0.7)])

    def area(mesh):
        return touch(body, mesh, flat(-0.05), cg.FacetArea(on)).total_area

    # Only where a corner of the master falls inside a facet is anything lost.
    errors = errors_of(area, 0.7, 1.0)
    assert order(errors) >= 1.8
    assert errors[-1] < 3e-4


def test_saddle_by_quadrature():
    # z = (x² − y²)/4 over [−1, 1]², cut by a plane: two regions that the border of the saddle ends.
    body = cg.Body([cg.shapes.saddle(width=2.0, length=2.0, height=0.25)])
    level = 0.08

    def strip(y):
        x0 = np.sqrt(4 * level + y * y)
        return quad(lambda x: np.sqrt(1 + 0.25 * (x * x + y * y)), x0, 1.0)[0]

    end = np.sqrt(1 - 4 * level)
    exact = 2 * quad(strip, -end, end)[0]

    def area(mesh):
        state = touch(body, mesh, flat(level), cg.FacetArea("master"))
        assert state.n_clusters == 2
        return state.total_area

    errors = errors_of(area, exact, 1.1, None, FINEST)
    assert order(errors, FINEST) >= 1.9


R, DEPTH, STIFFNESS, THICKNESS = 1.0, 0.2, 3.0, 0.5


def test_force_of_a_ball_in_a_winkler_foundation():
    # σ = k λ/t over the plane: the force is k/t times the volume of penetration.
    exact = STIFFNESS / THICKNESS * np.pi * DEPTH**2 * (R - DEPTH / 3.0)
    law = cg.StressLaw(STIFFNESS, thickness=THICKNESS)

    def force(mesh):
        place = ball_below(R, R - DEPTH)
        return touch(plate(), mesh, place, cg.FacetArea(), law, "master").total_force[2]

    errors = errors_of(force, exact, 0.66, None, FINE)
    assert order(errors, FINE) >= 1.9
    assert errors[-1] < 1e-3


def test_other_areas_make_a_larger_error_of_that_force():
    exact = STIFFNESS / THICKNESS * np.pi * DEPTH**2 * (R - DEPTH / 3.0)
    law = cg.StressLaw(STIFFNESS, thickness=THICKNESS)
    errors = {}
    for name, area in (
        ("facets", cg.FacetArea()),
        ("constant", cg.NodalArea()),
        ("hulls", cg.HullArea("auto", "linear")),
    ):

        def force(mesh, area=area):
            place = ball_below(R, R - DEPTH)
            return touch(plate(), mesh, place, area, law, "master").total_force[2]

        (errors[name],) = errors_of(force, exact, 0.66, None, (64,))
    print("errors of the force:", ", ".join(f"{name} {e:.2%}" for name, e in errors.items()))
    assert 10.0 * errors["facets"] < errors["hulls"] < errors["constant"]


def test_force_of_a_ball_master_on_a_winkler_layer():
    # The slave deforms: σ over the flat layer along the ball's normals, F_z = k/t π d h².
    exact = STIFFNESS / THICKNESS * np.pi * (R - DEPTH) * DEPTH**2
    body = cg.Body([cg.shapes.sphere(radius=R)])
    law = cg.StressLaw(STIFFNESS, thickness=THICKNESS)

    def force(mesh):
        return -touch(body, mesh, flat(DEPTH - R), cg.FacetArea(), law).total_force[2]

    errors = errors_of(force, exact, 0.66, None, FINE)
    assert order(errors, FINE) >= 1.9
