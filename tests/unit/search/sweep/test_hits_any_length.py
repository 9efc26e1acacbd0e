"""First entries at every length, angle and place: an end inside is explained by an entry."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.statuses import Status

EPS = np.finfo(float).eps


def directions(n, seed):
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def tilted(normals, cosine, seed):
    """Unit directions that make `cosine` with −normals."""
    w = np.cross(normals, directions(len(normals), seed))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    return -cosine * normals + np.sqrt(1.0 - cosine**2) * w


def cube(half=1.0):
    """The cube as a mesh and as six patches."""
    p = half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    faces = [cg.shapes.bilinear(p[a], p[b], p[d], p[c]) for a, b, c, d in quads]
    return cg.TriMesh(p, np.array(triangles)), cg.Body(faces)


def sphere_gap(p):
    return np.linalg.norm(p, axis=1) - 1.0


def torus_gap(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 2.0, p[:, 2]) - 0.7


def cube_gap(p):
    return np.abs(p).max(axis=1) - 1.0


@pytest.mark.parametrize("length", [1e3, 1.0, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12])
def test_no_radial_segment_through_a_sphere_is_missed(length):
    body = cg.Body([cg.shapes.sphere()])
    n = directions(20_000, 0)
    hit = body.first_hit(n * (1 + 0.5 * length), n * (1 - min(0.5 * length, 0.9)))
    assert (hit.patch == 0).all()
    out = body.first_hit(n * (1 - min(0.5 * length, 0.9)), n * (1 + 0.5 * length))
    assert (out.status == Status.NO_HIT).all()


@pytest.mark.parametrize(("length", "cosine"), [(1e-3, 0.03), (1e-3, 1e-3), (1e-6, 1e-4)])
def test_no_oblique_segment_is_missed(length, cosine):
    n = directions(20_000, 1)
    d = tilted(n, cosine, 2)
    a, b = n - 0.5 * length * d, n + 0.5 * length * d
    explained = (sphere_gap(a) > 0.0) & (sphere_gap(b) < -4 * EPS)
    hit = cg.Body([cg.shapes.sphere()]).first_hit(a, b)
    assert explained.sum() > 1000
    assert (hit.patch[explained] == 0).all()


@pytest.mark.parametrize("aim", [[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0], [0.6, 0, 0.8]])
def test_poles_and_seams_are_no_holes_at_any_length(aim):
    body = cg.Body([cg.shapes.sphere()])
    n = np.tile(aim, (40, 1))
    for length in (1e-1, 1e-4, 1e-8, 1e-12):
        for cosine in (1.0, 0.3, 1e-2):
            d = tilted(n, cosine, 3)
            a, b = n - 0.5 * length * d, n + 0.5 * length * d
            inside = sphere_gap(b) < -16 * EPS
            assert (body.first_hit(a, b).patch[inside] == 0).all()


@pytest.mark.parametrize("offset", [1e3, 1e6])
def test_a_body_far_from_the_origin_loses_none(offset):
    away = offset * np.array([1.0, -0.7, 0.4])
    body = cg.Body([cg.shapes.sphere(centre=away)])
    tolerance = 64 * EPS * offset
    for length in (1e-1, 1e-4, 1e-6):
        n = directions(2000, 4)
        d = tilted(n, 0.2, 5)
        a, b = away + n - 0.5 * length * d, away + n + 0.5 * length * d
        explained = (sphere_gap(a - away) > tolerance) & (sphere_gap(b - away) < -tolerance)
        assert explained.any()
        assert (body.first_hit(a, b).patch[explained] == 0).all()


@pytest.mark.parametrize("steps", [1, 7, 1000])
def test_a_path_in_steps_enters_where_the_whole_path_does(steps):
    """Closed intervals: the next starts where the last one ended, and nothing lies between."""
    body = cg.Body([cg.shapes.torus(major=2.0, minor=0.7)])
    rng = np.random.default_rng(6)
    a, b = rng.uniform(-3, 3, (2, 100, 3))
    whole = body.first_hit(a, b)
    first = np.full(len(a), np.inf)
    marks = [a + (b - a) * k / steps for k in range(steps + 1)]
    for k in range(steps):
        part = body.first_hit(marks[k], marks[k + 1])
        entered = (part.patch >= 0) & np.isinf(first)
        first[entered] = (k + part.fraction[entered]) / steps
    # A path that starts inside and leaves has no entry in either.
    np.testing.assert_allclose(np.where(np.isinf(first), np.nan, first), whole.fraction, atol=1e-9)


@pytest.mark.parametrize("length", [3.0, 1e-1, 1e-6, 1e-10])
@pytest.mark.parametrize("kind", ["mesh", "patches"])
def test_edges_and_corners_of_a_cube_are_watertight(kind, length):
    master = cube()[kind == "patches"]
    rng = np.random.default_rng(7)
    corner = rng.choice([-1.0, 0.0, 1.0], (4000, 3))
    corner = corner[np.abs(corner).sum(axis=1) >= 2]
    d = directions(len(corner), 8)
    for beside in (0.0, 1e-9, 1e-2 * length):
        c = corner + beside * rng.normal(size=corner.shape)
        a, b = c - 0.5 * length * d, c + 0.5 * length * d
        explained = (cube_gap(a) > 0.0) & (cube_gap(b) < -1e-14)
        hit = master.first_hit(a, b)
        assert (hit.patch[explained] >= 0).all()


def last(master, a, b):
    return master.surface.last_crossings(a, b, np.arange(len(a), dtype=np.int32))


def check_states(master, gap, a, b, tolerance):
    """What the last crossing says of the ends, given the starts, against the exact gaps."""
    hit, sense = last(master, a, b)
    inside = np.where(sense == 0, gap(a) < 0.0, sense == 1)
    clear = (np.abs(gap(a)) > tolerance) & (np.abs(gap(b)) > tolerance)
    assert clear.any()
    np.testing.assert_array_equal(inside[clear], gap(b)[clear] < 0.0)
    assert ((hit.patch >= 0) == (sense != 0)).all()
    found = sense != 0
    on_path = a[found] + hit.fraction[found, None] * (b - a)[found]
    np.testing.assert_allclose(on_path, hit.point[found], rtol=0, atol=1e-7)


@pytest.mark.parametrize("length", [3.0, 1e-1, 1e-3, 1e-6, 1e-10])
def test_the_last_crossing_tells_inside_from_outside(length):
    rng = np.random.default_rng(9)
    n = directions(4000, 10)
    d = directions(4000, 11)
    c = n * (1 + 0.4 * length * rng.normal(size=(len(n), 1)))
    check_states(
        cg.Body([cg.shapes.sphere()]), sphere_gap, c - d * length / 2, c + d * length / 2, 1e-13
    )
    turn, tilt = rng.uniform(0, 7, (2, len(n)))
    r = 0.7 + 0.4 * length * rng.normal(size=len(n))
    ring = 2 + r * np.cos(tilt)
    c = np.stack([ring * np.cos(turn), ring * np.sin(turn), r * np.sin(tilt)], axis=1)
    body = cg.Body([cg.shapes.torus(major=2.0, minor=0.7)])
    check_states(body, torus_gap, c - d * length / 2, c + d * length / 2, 1e-13)


@pytest.mark.parametrize("length", [3.0, 1e-1, 1e-6])
@pytest.mark.parametrize("kind", ["mesh", "patches"])
def test_the_last_crossing_through_edges_and_corners(kind, length):
    master = cube()[kind == "patches"]
    rng = np.random.default_rng(12)
    corner = rng.choice([-1.0, 0.0, 1.0], (6000, 3))
    corner = corner[np.abs(corner).sum(axis=1) >= 2]
    d, share = directions(len(corner), 13), rng.uniform(size=(len(corner), 1))
    for beside in (0.0, 1e-3 * length, 0.3 * length):
        c = corner + beside * rng.normal(size=corner.shape)
        a, b = c - share * length * d, c + (1 - share) * length * d
        check_states(master, cube_gap, a, b, 1e-12)


@pytest.mark.parametrize("kind", ["mesh", "patches"])
def test_out_of_one_wall_and_into_another_in_one_step(kind):
    """A slot between two blocks: what counts is the last crossing, not the first."""
    halves = [cube()[kind == "patches"] for _ in range(2)]
    if kind == "mesh":
        v, t = halves[0].vertices, halves[0].triangles
        both = np.concatenate([v, v + np.array([2.1, 0, 0])])
        body = cg.TriMesh(both, np.concatenate([t, t + len(v)]))
    else:
        patches = halves[0].patches
        moved = [p.transformed(np.array(SHIFT)) for p in patches]
        body = cg.Body([*patches, *moved])
    y = np.linspace(-0.9, 0.9, 20)
    a = np.column_stack([np.full(20, 0.9), y, 0.1 * y])
    hit, sense = last(
        body, a, a + np.array([0.4, 0, 0])
    )  # left at 1.0, entered at 1.1, ends at 1.3
    assert (sense == 1).all()
    np.testing.assert_allclose(hit.fraction, 0.5, atol=1e-12)
    hit, sense = last(body, a, a + np.array([0.15, 0, 0]))
    assert (sense == -1).all()
    np.testing.assert_allclose(hit.point[:, 0], 1.0, atol=1e-12)


SHIFT = [[1, 0, 0, 2.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]


def test_last_crossings_of_degenerate_segments():
    for master in (cg.Body([cg.shapes.sphere()]), cube()[0]):
        p = np.array([[3.0, 0, 0], [0, 0, 0], [np.nan, 0, 0], [3.0, 0, 0]])
        q = np.array([[3.0, 0, 0], [0.1, 0, 0], [0, 0, 0], [2.0, 0, 0]])
        hit, sense = last(master, p, q)
        assert sense.tolist() == [0, 0, 0, 0]
        nothing = Status.NO_HIT
        assert hit.status.tolist() == [nothing, nothing, Status.NOT_FINITE, nothing]


@pytest.mark.interpreted
def test_the_last_crossing_without_compilation():
    body = cg.Body([cg.shapes.plane()])
    hit, sense = last(body, np.array([[0.1, 0.2, 1.0]]), np.array([[0.1, 0.2, -1.0]]))
    assert sense.tolist() == [1]
    np.testing.assert_allclose(hit.fraction, 0.5, atol=1e-12)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_sphere_lowered_in_small_steps_takes_every_point_of_a_sheet(step):
    """All points that the sphere has passed are in contact, however small the steps were."""
    rng = np.random.default_rng(14)
    r, turn = 0.2 * np.sqrt(rng.uniform(size=600)), rng.uniform(0, 7, 600)
    points = np.column_stack([r * np.cos(turn), r * np.sin(turn), np.zeros(600)])
    contact = cg.Contact(
        cg.Body([cg.shapes.sphere()]), cg.Slave(points, area=np.ones(600)), law=cg.PenaltyLaw(1.0)
    )
    # Only as deep as 40 steps, so that a few hundred points come in one after the other.
    depth = 40 * step
    start = np.eye(4)
    start[2, 3] = 1.0 + 0.5 * step
    state = contact.start(points, start)
    pose = start.copy()
    for k in range(41):
        pose[2, 3] = start[2, 3] - (k + 1) * step
        state = contact.step(state, points, pose.copy(), dt=1.0)
    gap = np.linalg.norm(points - pose[:3, 3], axis=1) - 1.0
    assert depth > 0
    assert (gap < 0).sum() > 0
    np.testing.assert_array_equal(np.asarray(state.penetration) > 0, gap < 0)
    np.testing.assert_allclose(np.sum(state.penetration), -gap[gap < 0].sum(), rtol=1e-9)
