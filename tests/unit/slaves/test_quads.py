"""Quadrilateral faces of solids: which facets are their halves, areas, vectors, quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block, facet_areas

import contiga as cg
from contiga.slaves.cells import SOLIDS
from contiga.slaves.quads import (
    SkinCorners,
    at_corners,
    corner_areas,
    corner_vectors,
    corners_of,
    halves_of,
    quad_normals,
    quad_rule,
)
from contiga.slaves.sampling import QUAD_RULES, RULES, Sampling
from contiga.slaves.skin import tributary_area

NO_QUADS = np.zeros((0, 2), np.int32)
ONE = np.array([[0, 1, 2, 3]], np.int32)
NO_TRIANGLES = np.zeros((0, 3), np.int32)
CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)


def _brick(points: np.ndarray, facets: object | None = None) -> cg.Slave:
    """One hexahedron with its six faces, split along their shorter diagonals."""
    faces = SOLIDS["hexahedron"].corner_faces if facets is None else facets
    return cg.Slave(points, np.array(faces), elements={"hexahedron": [list(range(8))]})


def _warped(seed: int = 0, size: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return size * (CUBE + rng.uniform(-0.2, 0.2, CUBE.shape))


def _volume(points: np.ndarray) -> float:
    """∫ det J of the trilinear hexahedron, whose faces are bilinear: degree 2 in each direction."""
    at, weight = np.polynomial.legendre.leggauss(3)
    whole = 0.0
    for i, x in enumerate(at):
        for j, y in enumerate(at):
            for k, z in enumerate(at):
                sides = np.array([x, y, z]) * (2.0 * CUBE - 1.0) + 1.0
                slope = [
                    0.125 * (2.0 * CUBE[:, a] - 1.0) * np.delete(sides, a, axis=1).prod(axis=1)
                    for a in range(3)
                ]
                whole += weight[i] * weight[j] * weight[k] * np.linalg.det(slope @ points)
    return whole


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_rule_integrates_what_gauss_rules_do(count: int) -> None:
    rule = quad_rule(count)
    assert rule.shape.shape == (count**2, 4)
    assert (rule.weight > 0.0).all()
    assert (rule.shape > 0.0).all()
    u, v = rule.shape[:, 1] + rule.shape[:, 2], rule.shape[:, 2] + rule.shape[:, 3]
    for i in range(2 * count):
        for j in range(2 * count):
            whole = float((rule.weight * u**i * v**j).sum())
            assert whole == pytest.approx(1.0 / ((i + 1) * (j + 1)), rel=1e-13)
    wrong = float((rule.weight * u ** (2 * count)).sum())
    assert wrong != pytest.approx(1.0 / (2 * count + 1), rel=1e-9)


def test_a_parallelogram_gives_each_corner_a_quarter_and_a_trapezium_what_integrals_say() -> None:
    skew = np.array([[0, 0, 1], [4, 1, 1], [5, 3, 1], [1, 2, 1]], float)
    areas, _ = corner_areas(skew, SkinCorners(ONE, NO_TRIANGLES))
    np.testing.assert_allclose(areas, [[7.0 / 4.0] * 4], rtol=1e-14)
    # Of sides 3 and 1 and height 2: x_u × x_v = 2 (3 − 2v), ∫ (1 − u)(1 − v) 2 (3 − 2v) = 7/6.
    trapezium = np.array([[0, 0, 0], [3, 0, 0], [1, 2, 0], [0, 2, 0]], float)
    areas, _ = corner_areas(trapezium, SkinCorners(ONE, NO_TRIANGLES))
    np.testing.assert_allclose(areas, [[7.0 / 6.0, 7.0 / 6.0, 5.0 / 6.0, 5.0 / 6.0]], rtol=1e-14)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e3])
def test_areas_of_warped_faces_are_the_integrals(size: float) -> None:
    points = _warped(size=size)
    areas, _ = corner_areas(points, SkinCorners(ONE, NO_TRIANGLES))
    fine = quad_rule(40)
    jacobian = np.linalg.norm(quad_normals(points, ONE, fine)[0], axis=1)
    np.testing.assert_allclose(areas[0], (fine.weight * jacobian) @ fine.shape, rtol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_vectors_of_a_closed_skin_are_the_gradient_of_its_volume(seed: int) -> None:
    points = _warped(seed)
    brick = _brick(points)
    skin = corners_of(brick.facets, brick.quads)
    assert (len(skin.quads), len(skin.triangles)) == (6, 0)
    quads, triangles = corner_vectors(points, skin)
    vectors = np.stack(
        [at_corners(skin, (quads[..., k], triangles[..., k]), 8) for k in range(3)], axis=1
    )
    way = np.random.default_rng(9).normal(size=points.shape)
    # Volume is of third degree along a straight way: this combination of differences is exact.
    h = 0.05
    first = (_volume(points + h * way) - _volume(points - h * way)) / (2.0 * h)
    second = (_volume(points + 2 * h * way) - _volume(points - 2 * h * way)) / (4.0 * h)
    assert float((vectors * way).sum()) == pytest.approx((4.0 * first - second) / 3.0, rel=1e-10)
    np.testing.assert_allclose(vectors.sum(axis=0), 0.0, atol=1e-14)
    # The volume itself: a third of Σ x·∂V/∂x.
    assert float((vectors * points).sum()) / 3.0 == pytest.approx(_volume(points), rel=1e-13)


def test_nothing_depends_on_the_diagonal_that_a_face_is_drawn_with() -> None:
    points = _warped(4)
    halves = {True: [], False: []}
    for a, b, c, d in SOLIDS["hexahedron"].corner_faces:
        halves[True] += [[a, b, c], [a, c, d]]
        halves[False] += [[b, c, d], [d, a, b]]
    one, other = (_brick(points, facets) for facets in halves.values())
    assert len(one.quads) == len(other.quads) == 6
    np.testing.assert_allclose(one.area, other.area, rtol=1e-14)
    force = [cg.motion.Pressure(1.0).nodes(slave, "load").at(points, 0.0) for slave in (one, other)]
    np.testing.assert_allclose(force[0], force[1], atol=1e-15)


@pytest.mark.parametrize("kind", ["hexahedron", "tetra"])
def test_halves_are_those_of_faces_of_solids_wherever_they_stand(kind: str) -> None:
    slave = block((3, 2, 2), (3.0, 2.0, 2.0), kind=kind)
    faces = {"hexahedron": 2 * (3 * 2 + 3 * 2 + 2 * 2), "tetra": 0}[kind]
    assert slave.quads.shape == (faces, 2)
    order = np.random.default_rng(1).permutation(len(slave.facets))
    turned = np.roll(slave.facets[order], 1, axis=1)
    mixed = cg.Slave(slave.points, turned, elements=slave.elements)
    assert len(mixed.quads) == faces
    assert len(np.unique(mixed.quads)) == 2 * faces
    np.testing.assert_allclose(mixed.area, slave.area, rtol=1e-13)
    # A quadrilateral has the sense of its halves.
    skin = corners_of(mixed.facets, mixed.quads)
    whole = quad_normals(slave.points, skin.quads, quad_rule(1))[:, 0]
    a, b, c = (mixed.points[mixed.facets[mixed.quads[:, 0]][:, k]] for k in range(3))
    assert ((whole * np.cross(b - a, c - a)).sum(axis=1) > 0.0).all()


def test_halves_of_wedges_beside_hexahedra_and_none_of_shells() -> None:
    points = np.concatenate([CUBE, [[2.0, 0.0, 0.0], [2.0, 0.0, 1.0]]])
    elements = {"hexahedron": [list(range(8))], "wedge": [[1, 2, 8, 5, 6, 9]]}
    facets = [
        [1, 8, 9],
        [1, 9, 5],
        [2, 6, 9],
        [2, 9, 8],
        [1, 2, 8],
        [5, 9, 6],
        [0, 3, 2],
        [0, 2, 1],
    ]
    slave = cg.Slave(points, facets, elements=elements)
    assert sorted(slave.quads.tolist()) == [[0, 1], [2, 3], [6, 7]]
    shell = cg.Slave(CUBE[:4], [[0, 1, 2], [0, 2, 3]], elements={"quad": [[0, 1, 2, 3]]})
    assert len(shell.quads) == 0
    assert len(cg.Slave(CUBE, elements={"hexahedron": [list(range(8))]}).quads) == 0


def test_half_a_face_and_facets_that_meet_three_times_are_triangles() -> None:
    elements = {"hexahedron": np.arange(8)[None]}
    half = np.array([[0, 2, 1]], np.int32)
    assert len(halves_of(half, elements, 8)) == 0
    twice = np.array([[0, 2, 1], [0, 3, 2], [2, 0, 1]], np.int32)
    assert len(halves_of(twice, elements, 8)) == 0
    np.testing.assert_allclose(
        tributary_area(CUBE, half, NO_QUADS)[[0, 1, 2]], facet_areas(CUBE, half)[0] / 3.0
    )


def test_a_place_has_faces_whole_or_not_at_all() -> None:
    slave = block((2, 2, 1), (2.0, 2.0, 1.0), kind="hexahedron")
    # Three corners of a face of the top: half of it as it is drawn.
    three = slave.selected(box=[[0, 0, 1], [2, 1, 1]]).facets
    assert len(three) == 4
    nodes = np.flatnonzero((slave.points[:, 2] == 1.0) & (slave.points[:, :2].sum(axis=1) < 2.5))
    for rows in (nodes, nodes[slave.points[nodes, :2].max(axis=1) < 1.5]):
        chosen = slave.selected(nodes=rows)
        assert len(chosen.facets) == 2 * len(chosen.quads)
    side = slave.selected(side=([0, 0, 1], 30.0))
    np.testing.assert_allclose(np.sort(side.area)[-9:], [0.25] * 4 + [0.5] * 4 + [1.0], rtol=1e-13)


@pytest.mark.parametrize("count", list(RULES))
def test_points_lie_on_the_bilinear_face_and_weigh_its_area(count: int) -> None:
    points = _warped(2)
    brick = _brick(points)
    sampling, k = Sampling(brick, None, count), len(QUAD_RULES[count].weight)
    assert sampling.n_points == 8 + 6 * k
    skin = corners_of(brick.facets, brick.quads)
    there = sampling.points(points)[8:].reshape(6, k, 3)
    u = QUAD_RULES[count].shape[:, 1] + QUAD_RULES[count].shape[:, 2]
    v = QUAD_RULES[count].shape[:, 2] + QUAD_RULES[count].shape[:, 3]
    for face, corners in enumerate(skin.quads):
        a, b, c, d = points[corners]
        lower, upper = a + u[:, None] * (b - a), d + u[:, None] * (c - d)
        np.testing.assert_allclose(there[face], lower + v[:, None] * (upper - lower), atol=1e-15)
    areas = corner_areas(points, skin)[0].sum(axis=1)
    assert 2 * count <= k < 2 * count + 5
    off = {1: 1e-2, 3: 1e-3, 6: 1e-12, 12: 1e-4}[count]
    np.testing.assert_allclose(sampling.weight[8:].reshape(6, k).sum(axis=1), areas, rtol=off)
    rows = np.arange(8, sampling.n_points, 3)
    rng = np.random.default_rng(0)
    force, moved = rng.normal(size=(len(rows), 3)), rng.normal(size=(8, 3))
    work = (force * sampling.points(moved)[rows]).sum()
    assert (sampling.nodal(rows, force) * moved).sum() == pytest.approx(work, rel=1e-13)
    np.testing.assert_allclose(sampling.points_at(rows, moved), sampling.points(moved)[rows])


def test_faces_of_both_kinds_share_masses_and_forces() -> None:
    """A wedge has triangles and quadrilaterals."""
    points = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [0, 1, 1]], float)
    facets = [
        [0, 2, 1],
        [3, 4, 5],
        [0, 1, 4],
        [0, 4, 3],
        [1, 2, 5],
        [1, 5, 4],
        [2, 0, 3],
        [2, 3, 5],
    ]
    mass, elements = np.arange(1.0, 7.0), {"wedge": [[0, 1, 2, 3, 4, 5]]}
    slave = cg.Slave(points, facets, elements=elements, mass=mass, thickness=mass)
    sampling = Sampling(slave, None, 3)
    assert sampling.n_points == 6 + 3 * 9 + 2 * 3
    assert sampling.mass.sum() == pytest.approx(mass.sum(), rel=1e-14)
    assert sampling.weight.sum() == pytest.approx(slave.area.sum(), rel=1e-14)
    rows = np.array([1, 6, 7, 32, 33, 38])
    np.testing.assert_allclose(sampling.points_at(rows, points), sampling.points(points)[rows])
    rows, force = rows[1:], np.random.default_rng(3).normal(size=(5, 3))
    work = (force * sampling.points(points)[rows]).sum()
    assert (sampling.nodal(rows, force) * points).sum() == pytest.approx(work, rel=1e-13)
    np.testing.assert_allclose(
        sampling.nodal_sum(rows, force[:, 1]), sampling.nodal(rows, force)[:, 1], atol=1e-15
    )


@pytest.mark.parametrize("quadrature", ["nodes", 1, 3, 6, 12])
def test_a_ball_on_a_block_keeps_the_symmetry_of_its_forces(quadrature: str | int) -> None:
    slave = block((6, 6, 1), (6.0, 6.0, 1.0), kind="hexahedron")
    points = slave.points - [3.0, 3.0, 1.0]
    ball = cg.Body([cg.shapes.sphere(radius=60.0, centre=(0.0, 0.0, 60.0))])
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0, per_area=True), quadrature=quadrature)
    state = contact.start(points - [0.0, 0.0, 0.1])
    force = contact.step(state, points + np.array([0.0, 0.0, 0.3]), dt=1.0).force
    assert np.count_nonzero(force[:, 2]) >= 49
    for turn in (np.diag([-1.0, 1, 1]), np.diag([1.0, -1, 1]), np.eye(3)[[1, 0, 2]]):
        image = np.argmin(np.linalg.norm((points @ turn)[:, None] - points, axis=2), axis=1)
        np.testing.assert_allclose(
            force[image], force @ turn, atol=1e-10 * np.abs(force).max(), rtol=0.0
        )
