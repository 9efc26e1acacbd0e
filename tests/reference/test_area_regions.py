"""Regions of contact over poles, seams, borders of patches and trimmed edges, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

SIZES = (16, 32, 64, 128)
SHIFTS = ((0.0123, 0.0077), (-0.0031, 0.0164), (0.0049, -0.0098), (-0.0142, -0.0057))


def grid(n, half, shift=SHIFTS[0]):
    x = np.linspace(-half, half, n + 1)
    xy = np.stack(np.meshgrid(x + shift[0], x + shift[1], indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(xy)).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return xy, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def touch(body, points, facets, area, pose=None):
    contact = cg.Contact(
        body, cg.Slave(points, facets), law=cg.PenaltyLaw(1.0), area=area, search="penetration"
    )
    return contact.start(points, pose)


def errors_of(body, place, half, area, exact, sizes=SIZES):
    """Relative errors at each size, root mean square over places of the mesh."""
    result = []
    for n in sizes:
        values = []
        for shift in SHIFTS:
            xy, facets = grid(n, half, shift)
            state = touch(body, place(xy), facets, area)
            assert state.n_clusters == 1
            values.append(state.total_area)
        result.append(np.sqrt(np.mean((np.array(values) / exact - 1.0) ** 2)))
    return result


def order(errors, sizes=SIZES):
    return -np.polyfit(np.log(sizes), np.log(errors), 1)[0]


CAP = 2 * np.pi * 0.2  # of a unit sphere, a plane 0.2 inside it
TURNS = {
    "round the pole": np.eye(3),
    "over the seam": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),  # master's x downwards
    "away from both": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}


@pytest.mark.parametrize("where", TURNS)
def test_cap_of_a_sphere_by_facets_wherever_it_lies(where):
    # The same sphere turned: pole, seam or plain surface under the sheet z = -0.8.
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])

    def place(xy):
        return np.column_stack([xy, np.full(len(xy), -0.8)]) @ TURNS[where]

    errors = errors_of(ball, place, 0.66, cg.FacetArea("master"), CAP)
    assert order(errors) >= 1.9
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("where", ["over the seam", "away from both"])
def test_cap_of_a_sphere_by_hulls_beside_the_pole(where):
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    xy, facets = grid(128, 0.66)
    points = np.column_stack([xy, np.full(len(xy), -0.8)]) @ TURNS[where]
    state = touch(ball, points, facets, cg.HullArea("auto", mapping="exact"))
    assert state.n_clusters == 1
    # The image of a disc is convex in (u, v) here; half a spacing is lost around it.
    assert state.total_area == pytest.approx(CAP, rel=0.03)


def test_cap_round_the_pole_by_hulls_is_a_band_of_the_parameters():
    # Points spread evenly over the cap (golden spiral); their angles fill the whole of u.
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    errors = []
    for n in (400, 1600, 6400):
        k = np.arange(n) + 0.5
        z = 1.0 - 0.2 * k / n
        angle = np.pi * (1.0 + 5.0**0.5) * k
        r = np.sqrt(1.0 - z * z)
        feet = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
        state = touch(ball, 0.9 * feet, None, cg.HullArea("auto", mapping="exact"))
        assert state.n_clusters == 1
        errors.append(1.0 - state.total_area / CAP)
    assert 0.0 < errors[2] < errors[1] < errors[0] < 0.03


def halves_of_a_plane():
    return [cg.shapes.plane(width=1.5, length=3.0, centre=[x, 0, 0]) for x in (-0.75, 0.75)]


def test_disc_over_the_border_of_two_patches():
    def bowl(xy):
        return np.column_stack([xy, 0.8 - np.sqrt(1.0 - np.square(xy).sum(axis=1))])

    body = cg.Body(halves_of_a_plane())
    errors = errors_of(body, bowl, 0.66, cg.FacetArea("master"), 0.36 * np.pi)
    assert order(errors) >= 1.9
    # Each patch's hull ends half a spacing short of the border, and round the disc.
    xy, facets = grid(128, 0.66)
    state = touch(body, bowl(xy), facets, cg.HullArea("auto", mapping="exact"))
    assert state.n_clusters == 1
    assert state.total_area == pytest.approx(0.36 * np.pi, rel=0.04)


def line(a, b):
    return cg.NurbsCurve(1, [0, 0, 1, 1], [a, b])


def trimmed_plate(x):
    """A plate of side 3 about the origin, of which what lies beyond `x` is trimmed away."""
    plate = cg.shapes.plane(width=3.0, length=3.0)
    (u0, u1), (v0, v1) = plate.domain
    u = u0 + (u1 - u0) * (x + 1.5) / 3.0
    corners = [(u0, v0), (u, v0), (u, v1), (u0, v1)]
    loop = tuple(line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))
    body = cg.Body([plate], trims=[(loop,)])
    assert body.area() == pytest.approx(3.0 * (x + 1.5))
    return body


@pytest.mark.parametrize("on", ["slave", "master"])
def test_disc_trimmed_by_a_straight_edge(on):
    x, radius = 0.251, 0.6
    body = trimmed_plate(x)
    angle = np.arccos(x / radius)
    disc = np.pi * radius**2 - radius**2 * (angle - np.sin(angle) * np.cos(angle))
    # The slave is a cone of slope s: its own part is √(1 + s²) times its image.
    slope = 0.4
    exact = disc * (np.sqrt(1.0 + slope**2) if on == "slave" else 1.0)

    def cone(xy):
        return np.column_stack([xy, slope * (np.linalg.norm(xy, axis=1) - radius)])

    errors = errors_of(body, cone, 0.66, cg.FacetArea(on), exact)
    assert order(errors) >= 1.9
    assert errors[-1] < 2e-3


def tubes(gap, depth, n=61, rows=11):
    """Nodes and facets of two lying half tubes side by side, `gap` apart, `depth` in z = 0."""
    angle = np.linspace(-np.pi, 0.0, n)
    y = np.arange(rows) * 0.05
    tube = np.array([[np.cos(a), s, np.sin(a) + 1.0 - depth] for a in angle for s in y])
    i = np.arange(len(tube)).reshape(n, rows)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    both = np.concatenate([tube, tube + np.array([2.0 + gap, 0.0, 0.0])])
    return both, np.concatenate([facets, facets + len(tube)])


def test_two_cylinders_grow_together_into_one_region_of_a_cloud():
    plate = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])
    depths = (0.1, 0.5, 0.7, 1.0)
    for gap, counts in ((0.03, [2, 2, 2, 1]), (0.5, [2, 2, 2, 2])):
        states = [touch(plate, tubes(gap, d)[0], None, cg.HullArea("auto")) for d in depths]
        assert [state.n_clusters for state in states] == counts
    # Facets say what a cloud cannot know: two cylinders stay two.
    assert touch(plate, *tubes(0.03, 1.0), cg.FacetArea()).n_clusters == 2


def test_area_of_each_of_two_cylinders_is_its_rectangle():
    plate = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])
    points, facets = tubes(0.5, 0.3, 601)
    state = touch(plate, points, facets, cg.FacetArea("master"))
    width = 2.0 * np.sqrt(1.0 - 0.7**2)
    for k in range(2):
        assert state.area[state.clusters == k].sum() == pytest.approx(0.5 * width, rel=2e-4)


METHODS = {
    "facets on the slave": (cg.FacetArea("slave"), True),
    "facets on the master": (cg.FacetArea("master"), True),
    "cloud at rest": (cg.CloudArea(), False),
    "cloud by feet": (cg.CloudArea(by="feet"), False),
    "hulls, linear": (cg.HullArea("auto", mapping="linear"), False),
    "hulls, exact": (cg.HullArea("auto", mapping="exact"), True),
}


def two_discs():
    body = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    # Uneven, so that Delaunay triangles are one thing only.
    xy, facets = grid(40, 0.99)
    xy += np.random.default_rng(1).uniform(-0.01, 0.01, xy.shape)
    return body, np.column_stack([xy, np.full(len(xy), 0.35)]), facets


def same_regions(one, other):
    pairs = {(int(a), int(b)) for a, b in zip(one, other, strict=True)}
    return len(pairs) == len(set(one.tolist())) == len(set(other.tolist()))


@pytest.mark.parametrize("method", METHODS)
def test_order_of_points_and_facets_changes_nothing(method):
    area, with_facets = METHODS[method]
    body, points, facets = two_discs()
    state = touch(body, points, facets if with_facets else None, area)
    rng = np.random.default_rng(5)
    shuffle = rng.permutation(len(points))
    new = np.argsort(shuffle)[facets][rng.permutation(len(facets))]
    other = touch(body, points[shuffle], new if with_facets else None, area)
    assert state.n_clusters == other.n_clusters == 2
    assert same_regions(state.clusters[shuffle], other.clusters)
    assert other.area == pytest.approx(state.area[shuffle], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_rigid_motion_of_both_changes_nothing(method):
    area, with_facets = METHODS[method]
    body, points, facets = two_discs()
    facets = facets if with_facets else None
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, [3.0, -40.0, 7.0]
    state = touch(body, points, facets, area)
    moved = touch(body, points @ turn.T + pose[:3, 3], facets, area, pose)
    assert moved.n_clusters == 2
    assert same_regions(state.clusters, moved.clusters)
    assert moved.total_area == pytest.approx(state.total_area, rel=1e-9)
    assert moved.area == pytest.approx(state.area, rel=1e-7, abs=1e-12)


def test_profile_has_its_length_times_its_depth():
    # A plane circle pressed by a chord of points: arc length times depth, by every method.
    depth = 2.5
    body = cg.Body.from_profile(cg.shapes.circle(radius=1.0), depth=depth)
    arc = 2.0 * np.arccos(0.8)
    exact = {"slave": 2 * 0.6 * depth, "master": arc * depth}
    for n in (101, 401):
        x = np.linspace(-1.0, 1.0, n) + 1e-4
        line = np.column_stack([x, np.full(n, -0.8), np.zeros(n)])
        hull = touch(body, line, None, cg.HullArea("auto", mapping="exact"))
        assert hull.total_area == pytest.approx(exact["master"], rel=4.0 / n)
        cloud = touch(body, line, None, cg.CloudArea())
        assert cloud.total_area == pytest.approx(exact["slave"], rel=4.0 / n)
    # A strip of facets as deep as the body.
    x, z = np.linspace(-1.0, 1.0, 201) + 1e-4, np.linspace(-0.5 * depth, 0.5 * depth, 9)
    points = np.array([[a, -0.8, b] for a in x for b in z])
    i = np.arange(len(points)).reshape(201, 9)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    for on, value in exact.items():
        state = touch(body, points, facets, cg.FacetArea(on))
        assert state.total_area == pytest.approx(value, rel=1e-3)
