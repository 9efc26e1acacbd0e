"""Points half a thickness off the mid-surface: where they are, how they move, where forces go."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.slaves.kernels.shell_offset_nb import move_facet_points, move_nodes
from contiga.slaves.sampling import RULES, Sampling

SHEET = cg.Slave(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0.5], [0, 1.5, 0], [5, 5, 5]],
    [[0, 1, 2], [0, 2, 3]],
    thickness=[0.5, 1.0, 2.0, 3.0, 0.0],
)


def _sampling(side: str, count: int = 3, slave: cg.Slave = SHEET) -> Sampling:
    return Sampling(slave, None, RULES[count], side)


@pytest.mark.parametrize(("side", "sign"), [("front", 1.0), ("back", -1.0)])
def test_points_stand_half_the_thickness_off_their_facets(side: str, sign: float) -> None:
    on, off = _sampling("none").points(SHEET.points), _sampling(side).points(SHEET.points)
    half = 0.5 * _sampling(side).thickness[5:]
    for k, facet in enumerate(SHEET.facets):
        a, b, c = SHEET.points[facet]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        rows = slice(3 * k, 3 * k + 3)
        expected = on[5:][rows] + sign * half[rows, None] * normal
        np.testing.assert_allclose(off[5:][rows], expected, rtol=1e-14, atol=1e-15)


def test_nodes_go_along_the_mean_normal_and_alone_they_stay() -> None:
    flat = cg.Slave(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]],
        [[0, 1, 2], [0, 2, 3]],
        thickness=0.2,
    )
    points = _sampling("front", slave=flat).points(flat.points)
    np.testing.assert_allclose(points[:4], np.add(flat.points[:4], [0.0, 0.0, 0.1]), atol=1e-16)
    np.testing.assert_array_equal(points[4], flat.points[4])


@pytest.mark.parametrize("count", list(RULES))
def test_velocities_are_those_of_the_points(count: int) -> None:
    sampling, rng = _sampling("back", count), np.random.default_rng(1)
    velocity, h = rng.normal(size=(5, 3)), 1e-6
    rows = np.arange(sampling.first, sampling.n_points)
    exact = sampling.velocities(rows, SHEET.points, velocity)
    ahead, behind = (sampling.points(SHEET.points + s * h * velocity) for s in (1.0, -1.0))
    np.testing.assert_allclose(exact, (ahead - behind)[rows] / (2.0 * h), atol=1e-9)


@pytest.mark.parametrize("count", list(RULES))
def test_forces_do_the_same_work_and_have_the_same_sum_and_moment(count: int) -> None:
    sampling, rng = _sampling("front", count), np.random.default_rng(2)
    rows = np.arange(sampling.first, sampling.n_points, 2)
    force, velocity = rng.normal(size=(len(rows), 3)), rng.normal(size=(5, 3))
    nodal = sampling.forces(rows, SHEET.points, force)
    points = sampling.points(SHEET.points)[rows]
    power = (force * sampling.velocities(rows, SHEET.points, velocity)).sum()
    assert (nodal * velocity).sum() == pytest.approx(power, rel=1e-13)
    np.testing.assert_allclose(nodal.sum(axis=0), force.sum(axis=0), atol=1e-13)
    moment = np.cross(points, force).sum(axis=0)
    np.testing.assert_allclose(np.cross(SHEET.points, nodal).sum(axis=0), moment, atol=1e-12)


def test_facets_without_area_or_thickness_have_no_offset() -> None:
    slave = cg.Slave(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]],
        [[0, 1, 2], [0, 1, 3], [4, 5, 6]],
        thickness=[1, 1, 1, 1, 0, 0, 0],
    )
    on, off = (_sampling(side, 1, slave) for side in ("none", "front"))
    way = off.points(slave.points)[7:] - on.points(slave.points)[7:]
    np.testing.assert_array_equal(way, [[0, 0, 0], [0, 0, 0.5], [0, 0, 0]])
    rows = np.array([7])
    force = np.array([[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(
        off.forces(rows, slave.points, force), on.forces(rows, slave.points, force)
    )


def test_a_slave_without_thickness_is_refused() -> None:
    bare = cg.Slave(SHEET.points, SHEET.facets, name="sheet")
    for slave in (bare, bare.with_thickness(0.0)):
        with pytest.raises(InputError, match="no thickness to stand off by"):
            _sampling("front", slave=slave)


@pytest.mark.interpreted
def test_rows_asked_for_are_moved_and_no_others() -> None:
    rng = np.random.default_rng(0)
    nodal = rng.standard_normal((7, 3))
    facets = rng.permuted(np.tile(np.arange(7), (5, 1)), axis=1)[:, :3].astype(np.int32)
    offset, out = rng.random(20), np.zeros((20, 3))
    move_facet_points(nodal, facets, offset, out, 1, 4)
    a, b, c = (nodal[facets[:, j]] for j in range(3))
    normal = np.cross(b - a, c - a)
    unit = normal / np.linalg.norm(normal, axis=1)[:, None]
    expected = offset[:, None] * np.repeat(unit, 4, axis=0)
    np.testing.assert_allclose(out[4:16], expected[4:16], rtol=1e-13)
    assert not out[:4].any()
    assert not out[16:].any()
    total, at_nodes = np.empty((7, 3)), np.zeros((7, 3))
    move_nodes(nodal, facets, np.ones(7), total, at_nodes)
    sums = np.zeros((7, 3))
    for corner in range(3):
        np.add.at(sums, facets[:, corner], normal)
    touched = np.linalg.norm(sums, axis=1)
    expected = np.divide(
        sums, touched[:, None], out=np.zeros_like(sums), where=touched[:, None] > 0
    )
    np.testing.assert_allclose(at_nodes, expected, rtol=1e-13, atol=1e-15)


def test_no_direction_is_stiffer_than_the_bound_on_row_sums() -> None:
    sampling, rng = _sampling("front", 3), np.random.default_rng(4)
    rows = np.arange(sampling.first, sampling.n_points)
    stiffness = rng.random(len(rows))
    bound = sampling.stiffness(rows, SHEET.points, stiffness)
    size, h = 5, 1e-6
    jacobian = np.empty((len(rows), 3, 3 * size))
    for k in range(3 * size):
        way = np.zeros(3 * size)
        way[k] = h
        ahead, behind = (
            sampling.points(SHEET.points + s * way.reshape(-1, 3))[rows] for s in (1.0, -1.0)
        )
        jacobian[:, :, k] = (ahead - behind) / (2.0 * h)
    whole = np.einsum("q,qai,qaj->ij", stiffness, jacobian, jacobian)
    mass = rng.uniform(1.0, 3.0, size)
    fastest = np.linalg.eigvalsh(whole / np.sqrt(np.outer(*[np.repeat(mass, 3)] * 2))).max()
    assert fastest <= (bound / mass).max()
    assert (bound / mass).max() < 3.0 * fastest
    plain = _sampling("none").stiffness(rows, SHEET.points, stiffness)
    np.testing.assert_array_equal(plain, _sampling("none").nodal_sum(rows, stiffness))
