"""Nodes on shells: their weights, what elements and patches share, and edges by their nodes."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.matter.iga import assemble_shell, join
from contiga.patches.nodes import lobatto, surface_nodes

STEEL = cg.materials.Elastic(young=2000.0, poisson=0.3)


def plate(left: float = -1.0, right: float = 1.0, parts: int = 3) -> cg.NurbsSurface:
    """A flat patch of degree 3 with even elements."""
    middle = 0.5 * (left + right)
    flat = cg.shapes.plane(width=right - left, length=2.0)
    flat = flat.transformed(cg.motion.pose.translation([middle, 0.0, 0.0]))
    inner = [[a + (b - a) * k / parts for k in range(1, parts)] for a, b in flat.domain]
    return flat.k_refined((2, 2), *inner)


@pytest.mark.parametrize("count", range(2, 9))
def test_lobatto_integrates_what_it_should(count: int) -> None:
    rule = lobatto(count)
    assert rule.points[0] == 0.0
    assert rule.points[-1] == 1.0
    assert rule.weights.min() > 0.0
    for power in range(2 * count - 2):
        whole = float((rule.weights * rule.points**power).sum())
        assert whole == pytest.approx(1.0 / (power + 1), abs=1e-15)
    over = 2 * count - 2
    assert abs((rule.weights * rule.points**over).sum() - 1.0 / (over + 1)) > 1e-9


def test_weights_are_the_area_and_integrate_over_it() -> None:
    nodes = surface_nodes(join([plate()]))
    x, y, _ = nodes.points(join([plate()]).points).T
    assert nodes.weight.sum() == pytest.approx(4.0, abs=1e-13)
    assert (nodes.weight * x**4 * y**2).sum() == pytest.approx(4.0 / 15.0, abs=1e-13)


def test_nodes_of_a_dome_lie_on_it() -> None:
    dome = cg.shapes.sphere(radius=2.0).restricted((0.1, 0.2), (0.3, 0.6))
    net = join([dome])
    nodes = surface_nodes(net)
    np.testing.assert_allclose(np.linalg.norm(nodes.points(net.points), axis=1), 2.0, atol=1e-13)
    # Of a sphere the rule is not exact, but near it.
    finer = surface_nodes(net, 12)
    assert nodes.weight.sum() == pytest.approx(finer.weight.sum(), rel=1e-4)


def test_two_patches_share_the_nodes_of_their_joint() -> None:
    net = join([plate(-1.0, 0.0), plate(0.0, 1.0)])
    nodes, alone = surface_nodes(net), surface_nodes(join([plate(-1.0, 0.0)]))
    x = nodes.points(net.points)
    side = round(np.sqrt(len(alone.weight)))
    assert len(nodes.weight) == 2 * len(alone.weight) - side
    assert nodes.weight.sum() == pytest.approx(4.0, abs=1e-13)
    assert len(np.unique(np.round(x, 9), axis=0)) == len(x)
    # One mesh: every inner side belongs to two facets.
    sides = np.sort(nodes.facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, times = np.unique(sides, axis=0, return_counts=True)
    assert times.max() == 2
    assert (times == 1).sum() == 6 * (side - 1)


def test_nodes_of_an_edge_depend_on_the_edge_alone() -> None:
    net = join([plate()])
    nodes = surface_nodes(net)
    on_edge = nodes.points(net.points)[:, 0] == -1.0
    force = np.repeat(on_edge[:, None], 3, axis=1).astype(np.float64)
    np.testing.assert_array_equal(
        np.flatnonzero(nodes.spread(force)[:, 0]), np.sort(net.edge("u0"))
    )


def test_spread_is_the_transpose() -> None:
    net = join([plate(-1.0, 0.0), plate(0.0, 1.0)])
    nodes, rng = surface_nodes(net), np.random.default_rng(3)
    q, f = rng.normal(size=(len(net.points), 3)), rng.normal(size=(len(nodes.weight), 3))
    assert (nodes.points(q) * f).sum() == pytest.approx((q * nodes.spread(f)).sum(), rel=1e-12)
    np.testing.assert_allclose(nodes.spread(f).sum(axis=0), f.sum(axis=0), atol=1e-12)


def test_a_ball_bounces_off_a_plate_and_the_energy_is_kept() -> None:
    shell = assemble_shell([plate()], material=STEEL, density=1e-3, thickness=0.02)
    x = shell.points(shell.nodes)
    slave = cg.Slave(x, shell.facets, area=shell.contact.weight)
    edge = (np.abs(x[:, :2]) >= 1.0 - 1e-12).any(axis=1)
    centre = (0.07, -0.03, 0.501)
    ball = cg.Body([cg.shapes.sphere(radius=0.5, centre=centre)])
    moving = cg.motion.Free(1e-4, inertia=1e-5 * np.eye(3), centre=centre, velocity=(0, 0, -1.0))
    simulation = cg.Simulation(
        bodies={"ball": (ball, moving)},
        slaves={"plate": (slave, cg.motion.Deforming(material=shell, fixed=edge))},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(10.0, per_area=True))],
        end=0.25,
        step="auto",
    )
    result = simulation.run()
    energy, state = result.state.energy, result.state.slaves["plate"]
    assert result.history["energy.strain"].max() > 0.3 * energy.initial
    assert abs(energy.error) < 1e-3 * energy.initial
    np.testing.assert_array_equal(state.points[edge], x[edge])
    np.testing.assert_allclose(state.points, shell.points(state.matter["q"]), atol=1e-14)
