"""The images of facets that touch as a whole, measured from their feet and normals."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area.kernels import components_nb, facet_area_nb, image_nb, touch_nb
from contiga.area.method import AreaInput, Rest
from contiga.area.regions import topology_of
from contiga.records import empty_projection


def measured(body, nodes, facets):
    """Areas of the images of facets, all of whose nodes are in contact."""
    area, rows = cg.FacetArea("master"), np.arange(len(nodes), dtype=np.int32)
    kept = area.prepare(Rest(nodes, facets, None))
    return area.measure(
        AreaInput(body, rows, nodes, body.project(nodes), None, "master", kept)
    ).area


def excess(feet):
    """Solid angle of the triangle between three directions (van Oosterom and Strackee 1983)."""
    a, b, c = feet / np.linalg.norm(feet, axis=1, keepdims=True)
    return 2.0 * np.arctan2(abs(a @ np.cross(b, c)), 1.0 + a @ b + b @ c + c @ a)


AWAY = (0.0, 0.2, 0.45, 0.55, 0.8, 1.0, 1.5, 3.0, 10.0)
"""How far from the pole the middle of a facet is, in its own sizes: in it, on its side, beside."""


@pytest.mark.parametrize("axis", [[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0]])
@pytest.mark.parametrize("away", AWAY)
def test_a_facet_in_a_ball_has_its_solid_angle_round_and_beside_a_pole(axis, away):
    """As at its equator, through which the seam runs: to fourth order in the facet's size."""
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    pole, across = np.array(axis), np.array([0.0, 1.0, 0.0])
    errors = []
    for h in (0.2, 0.1):
        worst = 0.0
        for turn in np.linspace(0.1, 6.0, 7):
            side = np.cos(turn) * across + np.sin(turn) * np.cross(pole, across)
            middle = np.cos(away * h) * pole + np.sin(away * h) * side
            along = np.cross(middle, np.cross(side, pole))
            corners = 1.7 * turn + np.array([0.0, 2.0, 4.3])
            ring = np.outer(np.cos(corners), along) + np.outer(
                np.sin(corners), np.cross(middle, along)
            )
            nodes = 1.9 * (middle + 0.5 * h * ring)
            result = measured(ball, nodes, np.array([[0, 1, 2]], np.int32)).sum()
            worst = max(worst, abs(result / (4.0 * excess(nodes)) - 1.0))
        errors.append(worst)
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 12.0


def on_cone(nodes, half):
    """Area of the image of a plane triangle on a cone about −z, its tip at the origin.

    The image of a side keeps its turn about the axis; as far from the tip as its point's foot,
    it sweeps ½ s² sin(half) dφ of the unrolled cone.
    """
    x, w = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for a, b in zip(nodes, np.roll(nodes, -1, axis=0), strict=True):
        p = a + 0.5 * (x[:, None] + 1.0) * (b - a)
        r2 = p[:, 0] ** 2 + p[:, 1] ** 2
        s = np.sqrt(r2) * np.sin(half) - p[:, 2] * np.cos(half)
        turn = (p[:, 0] * (b - a)[1] - p[:, 1] * (b - a)[0]) / r2
        total += float((0.25 * w * s**2 * np.sin(half) * turn).sum())
    return abs(total)


@pytest.mark.parametrize("half", [np.pi / 6, np.pi / 4, np.pi / 3])
def test_beside_the_tip_of_a_cone_errors_are_of_third_order_in_size_over_distance(half):
    cone = cg.Body([cg.shapes.cone(radius=4.0 * np.tan(half), height=4.0)])
    worst = []
    tip = np.array([0.0, 0.0, 4.0])
    for away in (2.0, 4.0, 8.0):
        errors = []
        for turn in np.linspace(0.1, 6.0, 9):
            corners = 1.7 * turn + np.array([0.0, 2.0, 4.3])
            flat = 0.1 * np.array([away * np.cos(turn), away * np.sin(turn)])
            flat = flat + 0.05 * np.stack([np.cos(corners), np.sin(corners)], axis=1)
            far = np.linalg.norm(flat, axis=1)
            nodes = np.column_stack([flat, -far / np.tan(half)])
            result = measured(cone, nodes + tip, np.array([[0, 1, 2]], np.int32)).sum()
            errors.append(abs(result / on_cone(nodes, half) - 1.0))
        worst.append(max(errors))
    assert worst[0] < 3e-3
    assert worst[0] > 8.0 * worst[1] > 64.0 * worst[2]


def polar_net(n, rings, reach):
    """Nodes round the z axis to polar angle `reach`, one on it, and their facets."""
    polar = np.linspace(0.0, reach, rings + 1)[1:]
    turn = 2.0 * np.pi * np.arange(n) / n
    directions = [[[0.0, 0.0, 1.0]]]
    for k, p in enumerate(polar):
        f = turn + k * np.pi / n
        round_ = np.stack([np.sin(p) * np.cos(f), np.sin(p) * np.sin(f), np.cos(p) + 0 * f], 1)
        directions.append(round_.tolist())
    facets = [[0, 1 + i, 1 + (i + 1) % n] for i in range(n)]
    for k in range(rings - 1):
        for i in range(n):
            a, b = 1 + k * n + i, 1 + k * n + (i + 1) % n
            facets += [[a, a + n, b + n], [a, b + n, b]]
    return np.concatenate(directions), np.array(facets, np.int32)


def test_a_cap_about_a_pole_is_measured_to_fourth_order():
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    errors = []
    for m in (1, 2, 4):
        nodes, facets = polar_net(8 * m, 4 * m, 1.0)
        exact = sum(excess(nodes[f]) for f in facets)
        errors.append(abs(measured(ball, 0.97 * nodes, facets).sum() / exact - 1.0))
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[2]) / 2.0 > 3.7


def by_feet(body, corners, parts=64):
    """Area of a facet's image from the feet of its points: plane triangles, and their limit."""
    areas = []
    for n in (parts // 2, parts):
        i, j = (v.ravel() for v in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
        i, j = i[i + j <= n], j[i + j <= n]
        bary = np.stack([n - i - j, i, j], axis=1) / n
        feet = body.project(bary @ corners).point
        place = {(a, b): k for k, (a, b) in enumerate(zip(i.tolist(), j.tolist(), strict=True))}
        small = [[place[a, b], place[a + 1, b], place[a, b + 1]] for a, b in place if a + b < n] + [
            [place[a + 1, b], place[a + 1, b + 1], place[a, b + 1]]
            for a, b in place
            if a + b < n - 1
        ]
        p = feet[small]
        areas.append(
            0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
        )
    return (4.0 * areas[1] - areas[0]) / 3.0


def bowl():
    """A rational bicubic without inner knots, its parameters uneven."""
    rng = np.random.default_rng(4)
    x = np.linspace(0.0, 1.0, 4)
    net = np.stack([*np.meshgrid(x, x**2, indexing="ij"), 0.2 * rng.normal(size=(4, 4))], axis=-1)
    knots = np.array([0, 0, 0, 0, 1, 1, 1, 1.0])
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.5, 2.0, (4, 4)))


def test_images_on_a_free_surface_are_those_of_the_facets_points():
    """Also where the parameters run unevenly: no use is made of them."""
    surface = bowl()
    body = cg.Body([surface])
    errors = []
    for h in (0.06, 0.03, 0.015):
        uv = np.array([[0.4, 0.5], [0.4 + h, 0.5 + 0.2 * h], [0.4 + 0.1 * h, 0.5 + h]])
        nodes = surface.evaluate(uv)
        result = measured(body, nodes, np.array([[0, 1, 2]], np.int32)).sum()
        errors.append(abs(result / by_feet(body, nodes) - 1.0))
    assert errors[-1] < 1e-7
    assert np.log2(errors[0] / errors[2]) / 2.0 > 2.6


CUTS = [
    (1, (0.3, 1.0, 0.7), [(0, 0, 0.0), (0, 1, 0.3), (0, 2, 0.7)]),
    (2, (1.0, 0.4, 0.8), [(0, 0, 0.0), (1, 1, 0.0), (1, 2, 0.4), (0, 2, 0.8)]),
]


def cut_off(surface, uv, n_c, fraction, cut):
    """Area of a cut facet between points of a surface, and the corners of the part itself."""
    p, n = surface.evaluate(uv), surface.normal(uv)
    feet, share = empty_projection(len(p))._replace(point=p, normal=n), np.empty((1, 3))
    image_nb.image_pieces(
        np.array([[0, 1, 2]], np.int32), feet, n_c, np.full((1, 3), -1, np.int32),
        np.array([fraction]), share, 0, 1,
    )  # fmt: skip
    assert (share[0, n_c:] == 0.0).all()
    assert (share[0, :n_c] > 0.0).all()
    return share.sum(), np.array([p[a] + t * (p[b] - p[a]) for a, b, t in cut])


@pytest.mark.parametrize(("n_c", "fraction", "cut"), CUTS)
def test_one_cut_facet_in_a_ball_has_its_solid_angle_to_fourth_order(n_c, fraction, cut):
    ball = cg.shapes.sphere(radius=2.0)
    errors = []
    for h in (0.1, 0.05, 0.025):
        uv = [0.3, 0.4] + h * np.array([[0.0, 0.0], [1.0, 0.2], [0.1, 1.0]])
        (u0, u1), (v0, v1) = ball.domain
        found, p = cut_off(ball, [u0, v0] + uv * [u1 - u0, v1 - v0], n_c, fraction, cut)
        exact = 4.0 * sum(excess(p[[0, k, k + 1]]) for k in range(1, len(cut) - 1))
        errors.append(abs(found / exact - 1.0))
    assert np.log2(errors[0] / errors[2]) / 2.0 > 3.5
    assert errors[2] < 1e-5


@pytest.mark.parametrize(("n_c", "fraction", "cut"), CUTS)
def test_one_cut_facet_on_a_twisted_surface_has_the_area_of_its_image(n_c, fraction, cut):
    """To second order: the image of an edge is bent sideways, by as much in its two halves."""
    surface = bowl()
    body = cg.Body([surface])
    uv = [0.4, 0.5] + 0.015 * np.array([[0.0, 0.0], [1.0, 0.2], [0.1, 1.0]])
    found, p = cut_off(surface, uv, n_c, fraction, cut)
    exact = sum(by_feet(body, p[[0, k, k + 1]]) for k in range(1, len(cut) - 1))
    assert found == pytest.approx(exact, rel=1e-5)


def test_whole_facets_round_a_torus_are_measured_to_fourth_order():
    """Seams included: nothing is left out, no side is cut."""
    torus = cg.shapes.torus(major=1.0, minor=0.4)
    (u0, u1), (v0, v1) = torus.domain
    sizes, errors = (12, 24, 48), []
    for n in sizes:
        k = np.arange(n) / n
        uv = np.stack(np.meshgrid(u0 + k * (u1 - u0), v0 + k * (v1 - v0), indexing="ij"), -1)
        uv = uv.reshape(-1, 2)
        nodes = torus.evaluate(uv) - 0.02 * torus.normal(uv)
        i, j = (v.ravel() for v in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
        a, b = i * n + j, (i + 1) % n * n + j
        c, d = (i + 1) % n * n + (j + 1) % n, i * n + (j + 1) % n
        facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
        result = measured(cg.Body([torus]), nodes, facets).sum()
        errors.append(abs(result / (4.0 * np.pi**2 * 0.4) - 1.0))
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] >= 3.7
    assert errors[-1] < 1e-5


def test_a_facet_on_a_plane_is_split_alike():
    plate = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    nodes = np.array([[0.0, 0, -0.1], [0.5, 0, -0.1], [0.0, 0.4, -0.1]])
    area = cg.FacetArea("master")
    kept = area.prepare(Rest(nodes, np.array([[0, 1, 2]], np.int32), None))
    rows = np.arange(3, dtype=np.int32)
    areas = area.measure(AreaInput(plate, rows, nodes, plate.project(nodes), None, "master", kept))
    assert areas.area == pytest.approx(np.full(3, 0.1 / 3.0), rel=1e-12)


FACETS = np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [6, 7, 8]], np.int32)


@pytest.mark.interpreted
@pytest.mark.parametrize("rows", [[0, 1, 2], [1, 2, 3, 4], [7], list(range(9)), []])
def test_facets_are_sorted_by_their_corners_in_contact(rows):
    place = np.full(9, -1, np.int32)
    whole, part = touch_nb.touched(topology_of(FACETS, 9), np.array(rows, np.int32), place)
    count = np.isin(FACETS, rows).sum(axis=1)
    back = np.array(rows, np.int32)
    assert sorted(map(tuple, back[whole].tolist())) == sorted(map(tuple, FACETS[count == 3]))
    assert sorted(part.tolist()) == np.flatnonzero((count > 0) & (count < 3)).tolist()


@pytest.mark.interpreted
def test_regions_are_joined_over_whole_and_cut_facets():
    whole = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    corner = np.array([[-1, 6, 7], [-1, 8, -1]], np.int32)
    assert components_nb.facet_components(whole, corner, 9).tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 3]


@pytest.mark.interpreted
def test_whole_facets_on_the_slave_are_split_alike():
    points = np.array([[9.0, 9, 9], [0, 0, 0], [2, 0, 0], [0, 3, 0]])
    corner = np.array([[0, 1, 2]], np.int32)
    share = np.empty((1, 3))
    facet_area_nb.slave_whole(np.array([1, 2, 3], np.int32), points, corner, share, 0, 1)
    area = np.zeros(3)
    facet_area_nb.gather(corner, share, area)
    assert area.tolist() == [1.0, 1.0, 1.0]
