"""Caps about poles: what is claimed of their balls holds, and where it cannot hold nothing is."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.unit.search.balls.radii_at import radii_at

import contiga as cg
from contiga.arrays.codes import POLE
from contiga.search.balls import ball_cap_bounds, ball_cells
from contiga.search.balls.ball_caps import find_caps
from contiga.search.balls.ball_cells import CAP, SIDE_TOL
from contiga.search.balls.kernels.ball_cell_nb import MAX_CHANGE, measure_cells
from contiga.search.balls.radii import balls_of
from contiga.search.balls.spans import less_a_factor, restriction

SCALES = (1e-3, 1.0, 1e3) if FULL else (1e3,)


def turned(points, degree=3):
    """A Bézier curve (r, z), from the axis outwards, turned about the axis."""
    knots = [0.0] * (degree + 1) + [1.0] * (degree + 1)
    return cg.shapes.revolved(cg.NurbsCurve(degree, knots, [(r, 0.0, z) for r, z in points]))


def triaxial():
    return cg.shapes.sphere().scaled((1.0, 0.7, 0.5))


def bowl():
    """z = r² for r ≤ 1."""
    return turned([(0.0, 0.0), (0.5, 0.0), (1.0, 1.0)], 2)


def dimple():
    """A dent whose bend at the pole is 6, and which turns over farther out."""
    return turned([(0.0, 0.0), (1.0 / 6.0, 0.0), (0.4, 0.25), (1.0, 0.0)])


def hook():
    """A bowl whose wall comes back over its pole, at a height of 0.4."""
    return turned([(0.0, 0.0), (1.4, 0.0), (1.4, 0.4), (0.1, 0.4)])


def moved(surface, row, move):
    """`surface` with the control points `move` (u, v, 3) chooses moved."""
    points = surface.control_points.copy()
    points[row] += move
    return cg.NurbsSurface(surface.degrees, surface.knots, points, surface.weights)


def steepened(share):
    """A sphere, elevated, the tangents of which leave the pole's plane by `share` in one place."""
    ball = cg.shapes.sphere().elevate(1, 1)
    return moved(ball, (3, 1), (0.0, 0.0, share))


SMOOTH = {
    "sphere": cg.shapes.sphere,
    "cubic sphere": lambda: cg.shapes.sphere().elevate(1, 1),
    "long": lambda: cg.shapes.ellipsoid(axes=(0.5, 0.5, 1.0)),
    "flat": lambda: cg.shapes.ellipsoid(axes=(1.0, 1.0, 0.4)),
    "triaxial": triaxial,
    "bowl": bowl,
    "dimple": dimple,
    "disc": lambda: turned([(0.0, 0.0), (1.0, 0.0)], 1),
    "hook": hook,
    "turned over": lambda: dimple().flipped(),
}


QUICK = ("sphere", "triaxial", "bowl", "dimple", "turned over")
CLOSED = {"sphere", "cubic sphere", "long", "flat", "triaxial"}


def rigid(seed):
    """A random rotation."""
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def placed(surface, scale, seed):
    """`surface` turned at random, scaled and away from the origin."""
    points = scale * (surface.control_points @ rigid(seed).T + (3.0, -2.0, 1.0))
    return cg.NurbsSurface(surface.degrees, surface.knots, points, surface.weights)


def caps_of(body):
    """The caps of a body."""
    tables = body.surface.tables
    root = tables.tree[0]
    centre, size = 0.5 * (root["low"] + root["high"]), float(tables.scale[0])
    cells = ball_cells._grid(tables, centre, size)[2]
    return find_caps(tables, cells, SIDE_TOL * size + 2e-15 * float(np.abs(centre).max()))


def within(body, caps, k, n, seed=0):
    """Random parameters, points and normals of cap k, many near the pole."""
    rng = np.random.default_rng(seed)
    table = body.surface.tables.elements.table
    e, side = np.argwhere(caps.cap_of_side == k)[
        rng.integers((caps.cap_of_side == k).sum(), size=n)
    ].T
    far = caps.reach[k] * rng.uniform(1e-4, 1.0, n) ** rng.choice([1.0, 3.0], n)
    local = rng.uniform(0.0, 1.0, (n, 2))
    local[np.arange(n), side // 2] = np.where(side % 2 == 0, far, 1.0 - far)
    box = table["box"][e].reshape(-1, 2, 2)
    uv = box[:, :, 0] + local * (box[:, :, 1] - box[:, :, 0])
    surface = body.patches[0]
    return uv, surface.evaluate(uv), surface.normal(uv)


def balls_at(body, uv):
    """Radii of inner and outer balls at feet in the only patch."""
    return radii_at(body, np.zeros(len(uv), np.int32), uv)


def worst(q, normal, x, radius):
    """How far points x reach into balls of `radius` that touch at q on the side of `normal`."""
    apart = x[None] - q[:, None]
    square = (apart**2).sum(axis=2)
    height = (apart * normal[:, None]).sum(axis=2)
    return float((2.0 * radius * height - square).max())


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", SMOOTH)
def test_no_ball_as_large_as_claimed_holds_another_point_of_the_cap(name, scale):
    body = cg.Body([placed(SMOOTH[name](), scale, len(name))])
    caps = caps_of(body)
    assert len(caps.reach) == (2 if name in CLOSED else 1)
    for k in range(len(caps.reach)):
        _, q, normal = within(body, caps, k, 500)
        x = within(body, caps, k, 2000, seed=1)[1]
        for side, sign in ((0, -1.0), (1, 1.0)):
            radius = min(float(caps.radii[k, side]), 1e3 * scale)
            assert worst(q, sign * normal, x, radius) <= 1e-12 * max(radius, scale) * scale


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", [*QUICK, *full(*(name for name in SMOOTH if name not in QUICK))])
def test_no_ball_at_a_foot_of_the_cap_holds_a_point_of_the_body(name, scale):
    body = cg.Body([placed(SMOOTH[name](), scale, 7 + len(name))])
    caps = caps_of(body)
    rng = np.random.default_rng(2)
    (u0, u1), (v0, v1) = body.patches[0].domain
    x = body.patches[0].evaluate(rng.uniform((u0, v0), (u1, v1), (4000, 2)))
    for k in range(len(caps.reach)):
        uv, q, normal = within(body, caps, k, 500, seed=3)
        known = 0
        for radius, sign in zip(balls_at(body, uv), (-1.0, 1.0), strict=True):
            known += int((radius > 0.0).sum())
            assert worst(q, sign * normal, x, radius[:, None]) <= 1e-12 * body.size**2
        assert known > 500


@pytest.mark.parametrize(
    ("name", "inner", "outer"),
    [
        ("sphere", 1.0, math.inf),
        ("long", 0.25, math.inf),
        ("flat", 2.5, math.inf),
        ("triaxial", 0.98, math.inf),  # 0.7²/0.5 at the ends of the shortest axis
        ("bowl", math.inf, 0.5),
        ("dimple", math.inf, 1.0 / 6.0),
        ("turned over", math.inf, 1.0 / 6.0),
        ("disc", math.inf, math.inf),
    ],
)
def test_balls_claimed_are_those_of_the_bend_at_the_pole_but_for_a_factor(name, inner, outer):
    body = cg.Body([SMOOTH[name]()])
    near = caps_of(body).radii[0]
    # Open ones bend upwards, and not all of them have their outer side there.
    if body.patches[0].normal([[0.3, 0.01]])[0, 2] < 0.0 and name not in CLOSED:
        inner, outer = outer, inner
    for claimed, true in zip(near, (inner, outer), strict=True):
        assert claimed <= true
        assert claimed >= (0.2 * true if true < math.inf else 0.25)


def bends_at(surface, uv):
    """Least and largest eigenvalue of the second derivatives of z over (x, y)."""
    d = surface.derivatives(uv, 2)
    first = np.stack([d[:, 1, 0], d[:, 0, 1]], axis=1)
    second = np.stack([d[:, 2, 0], d[:, 1, 1], d[:, 1, 1], d[:, 0, 2]], axis=1)
    inverse = np.linalg.inv(first[:, :, :2])
    slope = (inverse @ first[:, :, 2:])[:, :, 0]
    form = (second[:, :, 2] - (second[:, :, :2] * slope[:, None]).sum(axis=2)).reshape(-1, 2, 2)
    return np.linalg.eigvalsh(inverse @ form @ inverse.swapaxes(1, 2)).T


def test_ranges_of_second_derivatives_hold_them_and_are_close_over_small_boxes():
    rng = np.random.default_rng(5)
    ball = triaxial().elevate(1, 1)
    points = ball.control_points.copy()
    points[:, 2:] += 0.15 * rng.normal(size=points[:, 2:].shape)  # tangents at the pole are kept
    surface = cg.NurbsSurface(ball.degrees, ball.knots, points, ball.weights)
    body = cg.Body([surface])
    tables = body.surface.tables
    assert tables.elements.table["kind"][0, 2] == POLE
    u0, u1, v0, v1 = tables.elements.table["box"][0]
    net = ball_cap_bounds._net(tables, 0, 2, False)
    net[:, :, :3] -= net[:, :, 3:] * net[0, 0, :3] / net[0, 0, 3]
    chart = less_a_factor(net[:, :, :3].swapaxes(1, 2))
    steps = np.array([0.5, 0.502])
    for x in rng.uniform(0.0, 0.98, 40):
        part = restriction(len(chart) - 1, np.array([x]), np.array([x + 2e-3]))[0]
        small = np.tensordot(part, chart, 1), part @ net[:, :, 3]
        bands, _ = ball_cap_bounds._bands(*small, steps, 1)
        assert bands.is_sound.all()
        at = np.column_stack([x + 2e-3 * rng.uniform(size=100), rng.uniform(*steps, 100)])
        low, high = bends_at(surface, (u0, v0) + at * (u1 - u0, v1 - v0))
        assert low.min() - 0.5 <= bands.low[0] <= low.min() + 1e-9
        assert high.max() - 1e-9 <= bands.high[0] <= high.max() + 0.5


@pytest.mark.parametrize("name", SMOOTH)
def test_normals_of_cells_of_a_cap_are_as_close_to_the_middle_s_as_marked(name):
    body = cg.Body([SMOOTH[name]()])
    caps = caps_of(body)
    tables = body.surface.tables
    root = tables.tree[0]
    centre = 0.5 * (root["low"] + root["high"])
    cells = ball_cells._grid(tables, centre, float(tables.scale[0]))[2]
    measure_cells(tables.elements, centre, cells, 0, len(cells))
    poor = ~(cells["turn"] < MAX_CHANGE)
    caps.mark(cells)
    cells = cells[(cells["cap"] >= 0) & (cells["tilt"] < MAX_CHANGE)]
    assert poor.any() == (cells["wobble"] > 0.0).any() or name == "disc"
    assert len(cells) > 0
    share = np.random.default_rng(6).uniform(1e-3, 1.0, (50, 2))
    corner = np.stack(
        [
            (1 - share[:, 0]) * (1 - share[:, 1]),
            (1 - share[:, 0]) * share[:, 1],
            share[:, 0] * (1 - share[:, 1]),
            share.prod(axis=1),
        ],
        axis=1,
    )
    for cell in cells:
        box = cell["uv"].reshape(2, 2)
        normal = body.patches[0].normal(box[:, 0] + share * (box[:, 1] - box[:, 0]))
        sine = np.linalg.norm(np.cross(normal, cell["normal"]), axis=1)
        assert sine.max() <= cell["tilt"] + 1e-9
        off = np.linalg.norm(normal - corner @ cell["corner_normal"], axis=1)
        assert off.max() <= cell["wobble"] + 1e-9


def test_of_a_sphere_most_of_the_radius_is_proved_about_its_poles():
    body = cg.Body([cg.shapes.sphere()])
    feet = np.array([[0.1, 1e-9], [0.6, 0.01], [0.9, 0.05], [0.3, 0.97], [0.0, 1.0]])
    inner, outer = balls_at(body, feet)
    assert (inner > 0.25).all()
    assert (inner < 1.0).all()
    np.testing.assert_allclose(outer, CAP * body.size, rtol=1e-6)


def half():
    """Half a bowl: nothing goes on round its pole."""
    arc = cg.NurbsCurve(2, [0, 0, 0, 1, 1, 1], [(0, 0, 0), (1, 0, 0), (1, 0, 1)])
    return cg.shapes.revolved(arc, math.pi)


REFUSED = {
    "cone": lambda: cg.shapes.cone(radius=1.0, height=1.0),
    "nearly flat cone": lambda: cg.shapes.cone(radius=1.0, height=1e-6),
    "torus": lambda: cg.shapes.torus(major=1.0, minor=0.3),
    "pointed": lambda: turned([(0.0, 0.0), (0.5, 0.1), (1.0, 1.0)], 2),
    "half": half,
    "quarter": lambda: cg.shapes.sphere().restricted((0.0, 0.25), (0.0, 1.0)),
    "bent up at one place": lambda: steepened(1e-4),
    "cusp": lambda: turned([(0.0, 0.0), (0.0, 0.0), (0.5, 0.0), (1.0, 1.0)]),
}


@pytest.mark.parametrize("name", REFUSED)
def test_there_is_no_cap_where_the_surface_is_not_smooth_or_does_not_close(name):
    caps = caps_of(cg.Body([REFUSED[name]()]))
    lower = caps.cap_of_side[:, 2] if name == "bent up at one place" else caps.cap_of_side
    assert (lower < 0).all()


def test_a_joint_with_a_kink_is_refused():
    ball = cg.shapes.sphere().elevate(1, 1)
    for far, found in ((0.0, 2), (1e-7, 1)):
        # The third ring of control points from the lower pole, beside a joint: S_u jumps there, by
        # less than makes a crease.
        bent = moved(ball, (4, 2), (0.0, 0.0, far))
        assert len(caps_of(cg.Body([bent])).reach) == found


def test_a_cap_ends_before_a_kink_of_the_profile():
    points = [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, 0.0, 1.0)]
    curve = cg.NurbsCurve(1, [0.0, 0.0, 0.5, 1.0, 1.0], points)
    body = cg.Body([cg.shapes.revolved(curve)])
    caps = caps_of(body)
    assert len(caps.reach) == 1
    assert (caps.cap_of_side[body.surface.tables.elements.table["box"][:, 2] >= 0.5] < 0).all()
    small = np.minimum(*balls_at(body, np.array([[0.3, 0.1], [0.3, 0.49]])))
    assert small[0] > 0.1
    assert small[1] <= 0.01 + 1e-12


def test_trims_about_a_pole_leave_the_balls_as_large():
    whole = cg.shapes.sphere()
    corners = [(0.0, 0.05), (1.0, 0.05), (1.0, 0.5), (0.0, 0.5), (0.0, 0.05)]
    loop = tuple(
        cg.NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], [(*a, 0.0), (*b, 0.0)]) for a, b in pairwise(corners)
    )
    body, cut = cg.Body([whole]), cg.Body([whole], trims=[(loop,)])
    assert len(caps_of(cut).reach) == 2
    feet = np.array([[0.3, 0.06], [0.7, 0.08]])
    (inner, outer), (less, least) = balls_at(cut, feet), balls_at(body, feet)
    assert (inner >= 0.9 * less).all()
    assert (less > 0.25).all()
    np.testing.assert_allclose(outer, CAP * cut.size, rtol=1e-6)
    np.testing.assert_allclose(least, CAP * body.size, rtol=1e-6)


@pytest.mark.parametrize("name", ["sphere", "triaxial", "flat", "dimple"])
def test_closest_points_about_a_pole_are_the_same_bits_with_balls_and_without(name):
    surface = SMOOTH[name]()
    body = cg.Body([surface])
    rng = np.random.default_rng(4)
    (u0, u1), (v0, v1) = surface.domain
    v = v0 + (v1 - v0) * 0.3 * rng.uniform(0.0, 1.0, 600) ** 6
    v[:20] = v0
    u = rng.uniform(u0, u1, 600)
    u[20:60] = u0 + (u1 - u0) * rng.integers(0, 5, 40) / 4.0
    uv = np.column_stack([u, v])
    near = rng.choice([0.01, 0.3], 600) * body.size * rng.normal(size=600)
    away = np.where(v > v0, v, v0 + 1e-9)
    points = surface.evaluate(uv) + near[:, None] * surface.normal(np.column_stack([u, away]))
    before = body.project(points)
    balls_of(body.surface.tables)
    after = body.project(points)
    for field in ("patch", "uv", "point", "normal", "gap", "status", "feature"):
        np.testing.assert_array_equal(getattr(before, field), getattr(after, field))
