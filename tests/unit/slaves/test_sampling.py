"""Points of contact on nodes and facets, their weights, and the way back to the nodes."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg
from contiga.errors import InputError
from contiga.slaves.sampling import RULES, Sampling

SHEET = cg.Slave(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0.5], [0, 1.5, 0], [5, 5, 5]],
    [[0, 1, 2], [0, 2, 3]],
    thickness=[0.0, 1.0, 2.0, 3.0, 0.0],
    mass=[1.0, 2.0, 3.0, 4.0, 5.0],
)


@pytest.mark.parametrize("count", list(RULES))
def test_a_rule_integrates_all_polynomials_of_its_degree(count: int) -> None:
    rule = RULES[count]
    assert rule.shape.shape == (count, 3)
    assert (rule.shape > 0.0).all()
    assert (rule.weight > 0.0).all()
    np.testing.assert_allclose(rule.shape.sum(axis=1), 1.0, rtol=1e-15)
    for i in range(rule.degree + 1):
        for j in range(rule.degree + 1 - i):
            # ∫ L₁ⁱ L₂ʲ over a triangle of area 1: 2 i! j! / (i + j + 2)!
            exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2)
            actual = (rule.weight * rule.shape[:, 0] ** i * rule.shape[:, 1] ** j).sum()
            assert actual == pytest.approx(exact, rel=1e-13), (i, j)


@pytest.mark.parametrize("count", list(RULES))
def test_a_rule_of_higher_degree_would_not_do(count: int) -> None:
    rule, degree = RULES[count], RULES[count].degree + 1
    exact = 2.0 * factorial(degree) / factorial(degree + 2)
    assert (rule.weight * rule.shape[:, 0] ** degree).sum() != pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("count", list(RULES))
def test_points_lie_on_their_facets_and_weigh_their_areas(count: int) -> None:
    sampling = Sampling(SHEET, None, count)
    points = sampling.points(SHEET.points)
    assert (sampling.n_points, sampling.first) == (5 + 2 * count, 5)
    np.testing.assert_array_equal(points[:5], SHEET.points)
    np.testing.assert_array_equal(sampling.weight[:5], 0.0)
    for k, facet in enumerate(SHEET.facets):
        own = slice(5 + k * count, 5 + (k + 1) * count)
        a, b, c = SHEET.points[facet]
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
        assert sampling.weight[own].sum() == pytest.approx(area, rel=1e-14)
        np.testing.assert_allclose(points[own], RULES[count].shape @ [a, b, c], atol=1e-15)


@pytest.mark.parametrize("count", [None, *RULES])
def test_forces_at_the_points_and_at_the_nodes_do_the_same_work(count: int | None) -> None:
    sampling = Sampling(SHEET, np.ones(5), count)
    rng = np.random.default_rng(0)
    rows = np.arange(sampling.first, sampling.n_points, 2)
    force, moved = rng.normal(size=(len(rows), 3)), rng.normal(size=(5, 3))
    nodal = sampling.nodal(rows, force)
    assert (nodal * moved).sum() == pytest.approx(
        (force * sampling.points(moved)[rows]).sum(), rel=1e-13
    )
    np.testing.assert_allclose(nodal.sum(axis=0), force.sum(axis=0), atol=1e-14)
    np.testing.assert_allclose(sampling.nodal_sum(rows, force[:, 0]), nodal[:, 0], atol=1e-15)


@pytest.mark.parametrize("count", [None, *RULES])
def test_shares_are_what_points_have_of_the_nodes(count: int | None) -> None:
    sampling = Sampling(SHEET, np.ones(5), count)
    rows = np.arange(sampling.first, sampling.n_points)[::2]
    shares = sampling.shares(rows)
    np.testing.assert_allclose(shares.T @ SHEET.points, sampling.points(SHEET.points)[rows])
    assert sampling.shares(rows[:0]).shape == (5, 0)


@pytest.mark.parametrize("count", list(RULES))
def test_masses_are_shared_and_thicknesses_are_means(count: int) -> None:
    sampling = Sampling(SHEET, None, count)
    # Node 4 is on no facet: its mass stays out.
    assert sampling.mass[5:].sum() == pytest.approx(10.0, rel=1e-14)
    # Nodes 0 and 2 are corners of both facets, and share theirs by area.
    area = [sampling.weight[5 : 5 + count].sum(), sampling.weight[5 + count :].sum()]
    first = 2.0 + (1.0 + 3.0) * area[0] / sum(area)
    assert sampling.mass[5 : 5 + count].sum() == pytest.approx(first, rel=1e-13)
    rows = np.arange(5, sampling.n_points)
    np.testing.assert_allclose(sampling.mass[:5], 0.0)
    assert (sampling.mass[5:] > 0.0).all()
    corner = SHEET.thickness[SHEET.facets]
    low = np.where(corner > 0.0, corner, np.inf).min(axis=1)
    thickness = sampling.thickness[rows].reshape(2, count)
    assert (thickness >= low[:, None]).all()
    assert (thickness <= corner.max(axis=1)[:, None]).all()


def test_points_of_a_facet_with_an_inactive_corner_take_no_part() -> None:
    active = np.array([True, True, True, False, False])
    slave = cg.Slave(SHEET.points, SHEET.facets, active=active)
    sampling = Sampling(slave, None, 3)
    np.testing.assert_array_equal(sampling.active[5:], [True] * 3 + [False] * 3)


def test_a_cloud_has_no_facets_to_put_points_on() -> None:
    with pytest.raises(InputError, match="points lie on facets"):
        Sampling(cg.Slave([[0.0, 0.0, 0.0]]), None, 1)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 25.4, 1e3])
def test_weights_of_a_mesh_do_not_depend_on_its_unit_and_place(scale: float) -> None:
    points, quads = square_sheet(2.8, 25)
    whole = cg.Slave(points, quads)
    pose = cg.motion.pose
    placed = pose.compose(pose.translation([3.0, -70.0, 0.1]), pose.rotation("y", 0.7))
    moved = cg.Slave(scale * pose.apply(placed, points), quads)
    np.testing.assert_array_equal(moved.facets, whole.facets)
    np.testing.assert_allclose(moved.area, scale**2 * whole.area, rtol=1e-11)
    inner = np.ones((25, 25), bool)
    inner[[0, -1]] = inner[:, [0, -1]] = False
    np.testing.assert_allclose(whole.area.reshape(25, 25)[inner], (2.8 / 24) ** 2, rtol=1e-12)
