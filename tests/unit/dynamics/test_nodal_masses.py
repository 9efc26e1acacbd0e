"""Lumped masses on nodes of what deforms: against closed forms, and counted once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.blocks import Chain, block

import contiga as cg
from contiga.errors import InputError
from contiga.simulation.fingerprint import fingerprint_of

RUBBER = {"material": cg.materials.NeoHooke(young=1.0, poisson=0.3), "density": 0.02}
TOP = {"plane": [[0, 0, 2], [0, 0, 1]]}
"""Of a block that is 2 high."""


def _block(**options: Any) -> cg.Slave:
    return block((2, 2, 2), (2.0, 2.0, 2.0), kind="hexahedron", **options)


def _simulation(slave: cg.Slave, motion: object, **options: Any) -> cg.Simulation:
    return cg.Simulation(bodies={}, slaves={"soft": (slave, motion)}, contacts=[], **options)


def _masses(slave: cg.Slave, **options: Any) -> np.ndarray:
    return cg.motion.Deforming(**(RUBBER | options)).with_masses(slave).mass


def _rod(n: int) -> cg.Slave:
    points = np.zeros((n + 1, 3))
    points[:, 2] = np.linspace(0.0, 10.0, n + 1)
    rows = np.arange(n + 1)
    return cg.Slave(points, elements={"line": np.stack([rows[:-1], rows[1:]], axis=1)})


@pytest.mark.parametrize("share", [0.5, 1.0, 4.0])
def test_a_rod_with_a_mass_at_its_end_swings_as_the_closed_form_says(share: float) -> None:
    """Root of x tan x = rod / mass with x = ω L / c: S. P. Timoshenko, Vibration Problems in
    Engineering, longitudinal vibrations of a bar with a load at its end."""
    slave, young, density, section = _rod(24), 50.0, 2.0, 0.3
    end = share * density * section * 10.0
    x = brentq(lambda x: x * np.tan(x) - 1.0 / share, 1e-9, 0.5 * np.pi - 1e-9)
    omega = x * np.sqrt(young / density) / 10.0
    shape = np.sin(x * slave.points[:, 2] / 10.0)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=young, poisson=0.0),
        density=density,
        section=section,
        fixed={"nodes": [0]},
        masses={"nodes": [24], "mass": end},
        velocity=1e-5 * shape[:, None] * [0.0, 0.0, 1.0],
    )
    quarter = 0.5 * np.pi / omega
    simulation = _simulation(slave, motion, end=quarter, step=quarter / 400)
    result = simulation.run()
    way = result.state.slaves["soft"].points[:, 2] - slave.points[:, 2]
    np.testing.assert_allclose(way, 1e-5 / omega * shape, rtol=1e-3, atol=1e-9)
    assert abs(result.state.slaves["soft"].velocities[-1, 2]) < 1e-3 * 1e-5


def test_masses_fall_with_their_block_and_strain_nothing() -> None:
    slave = _block()
    masses = [TOP | {"mass": 3.0}, {"nodes": [5, 0], "mass": [0.4, 0.0]}]
    motion = cg.motion.Deforming(masses=masses, **RUBBER)
    result = _simulation(slave, motion, gravity=[0, 0, -10.0], end=0.5, step=0.01).run()
    fallen = result.state.slaves["soft"].points - slave.points
    np.testing.assert_allclose(fallen, [[0.0, 0.0, -1.25]] * len(slave), atol=1e-12)
    whole = 0.02 * 8.0 + 3.4
    middles = (5.0 - 0.05) * (5.0 + 0.05)  # of the steps before and after the end
    assert result.history["energy.kinetic"][-1] == pytest.approx(0.5 * whole * middles, rel=1e-12)
    assert result.history["energy.external"][-1] == pytest.approx(whole * 12.5, rel=1e-12)
    assert np.abs(result.history["energy.strain"]).max() < 1e-12


def test_momentum_is_kept_when_a_heavy_block_hits_a_ball() -> None:
    slave, mass = _block(low=(-1.0, -1.0, 1.01)), 0.5
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    motion = cg.motion.Deforming(
        masses={"side": ([0, 0, 1], 10.0), "mass": mass}, velocity=[0, 0, -0.5], **RUBBER
    )
    carrier = cg.motion.Free(mass=0.3, inertia=0.1 * np.eye(3), centre=(0, 0, 0))
    simulation = cg.Simulation(
        bodies={"ball": (ball, carrier)},
        slaves={"soft": (slave, motion)},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(2.0, per_area=True), quadrature=6)],
        end=1.0,
        step=0.005,
    )
    result = simulation.run()
    nodal = simulation.mechanism.masses["soft"]
    assert nodal.sum() == pytest.approx(0.16 + mass, rel=1e-12)
    there = nodal @ result.state.slaves["soft"].velocities
    ball_now = result.state.bodies["ball"].twist.velocity
    assert ball_now[2] < -0.05
    np.testing.assert_allclose(0.3 * ball_now + there, [0, 0, -0.5 * (0.16 + mass)], atol=1e-12)
    history = result.history
    assert history["energy.total"][0] == pytest.approx(0.5 * (0.16 + mass) * 0.25)
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def test_a_mass_is_shared_as_a_force_is_so_that_a_block_under_it_stays_straight() -> None:
    slave = _block()
    top = slave.points[:, 2] == 2.0
    extra = _masses(slave, masses=TOP | {"mass": 0.8}) - _masses(slave)
    load = cg.motion.NodalForce([0, 0, 0.8], on=TOP).nodes(slave, "").at(slave.points, 0.0)
    np.testing.assert_allclose(extra, load[:, 2], atol=1e-15)
    assert sorted(set(extra[top].round(12))) == [0.05, 0.1, 0.2]  # corners, edges, the middle
    straight = RUBBER | {"material": cg.materials.NeoHooke(young=1.0, poisson=0.0)}
    motion = cg.motion.Deforming(
        fixed={"plane": [[0, 0, 0], [0, 0, 1]]}, masses=TOP | {"mass": 0.8}, **straight
    )
    state = _simulation(slave, motion, gravity=[0, 0, -0.1], end=1.0, step=0.02).run().state
    heights = state.slaves["soft"].points[top, 2]
    assert heights.max() < 2.0 - 1e-3
    assert np.ptp(heights) < 1e-12


def test_masses_of_a_place_are_in_the_order_of_its_nodes() -> None:
    slave, plain = _block(), _masses(_block())
    mask = np.zeros(len(slave), np.bool_)
    mask[[3, 7]] = True
    for masses in (
        {"nodes": [7, 3], "mass": [2.0, 1.0]},
        {"nodes": mask, "mass": [1.0, 2.0]},
        [{"nodes": [3], "mass": 1.0}, {"nodes": [7, 7], "mass": [1.5, 0.5]}],
        {"mass": np.where(mask, np.where(np.arange(len(slave)) == 7, 2.0, 1.0), 0.0)},
    ):
        extra = _masses(slave, masses=masses) - plain
        np.testing.assert_allclose(extra[[3, 7]], [1.0, 2.0], rtol=1e-12)
        assert np.abs(np.delete(extra, [3, 7])).max() == 0.0


def test_masses_of_the_slave_are_not_added_unasked_nor_twice() -> None:
    slave = _block().with_mass(5.0)
    own = _masses(slave)
    assert own.sum() == pytest.approx(0.16)
    motion = cg.motion.Deforming(masses={"mass": slave.mass}, **RUBBER)
    once = motion.with_masses(slave)
    np.testing.assert_allclose(once.mass, own + 5.0)
    simple = cg.motion.Deforming(masses=TOP | {"mass": 1.0}, **RUBBER)
    again = simple.with_masses(simple.with_masses(slave))
    assert again.mass.sum() == pytest.approx(1.16)
    nodes = _simulation(again, simple, end=1.0, step=0.01).mechanism.nodes["soft"]
    np.testing.assert_array_equal(nodes.mass, again.mass)


def test_masses_lengthen_the_step_and_mass_scaling_adds_only_what_they_leave_to_add() -> None:
    slave = _block()
    rates = []
    for masses in (None, {"mass": 3.0 * _masses(slave)}):
        simulation = _simulation(
            slave, cg.motion.Deforming(masses=masses, **RUBBER), end=1.0, step=0.01
        )
        state = simulation.start().slaves["soft"]
        rates.append(simulation.mechanism.nodes["soft"].rates(state)[0])
    assert rates[1] == pytest.approx(0.25 * rates[0], rel=1e-12)
    step = 3.0 / np.sqrt(rates[0])
    scaled = _masses(slave, mass_scaling=step)
    both = cg.motion.Deforming(masses=TOP | {"mass": 9.0}, mass_scaling=step, **RUBBER)
    top = slave.points[:, 2] == 2.0
    nodal = both.with_masses(slave).mass
    np.testing.assert_array_equal(nodal[~top], scaled[~top])
    np.testing.assert_array_equal(nodal[top], _masses(slave, masses=TOP | {"mass": 9.0})[top])
    nodes = _simulation(slave, both, end=0.1, step=0.01).mechanism.nodes["soft"]
    (one,) = nodes.matter.added
    assert one.mass == pytest.approx(0.16)
    assert one.added == pytest.approx(nodal.sum() - 9.16)


def test_a_run_with_other_masses_is_another_run() -> None:
    slave = _block()
    motions = [
        cg.motion.Deforming(masses={"nodes": [3], "mass": mass}, **RUBBER) for mass in (1.0, 2.0)
    ]
    one, other = (fingerprint_of(_simulation(slave, m, end=1.0, step=0.01)) for m in motions)
    assert one != other


def test_a_body_carries_the_masses_on_nodes_that_are_attached_to_it() -> None:
    slave, board = _block(), cg.Body([cg.shapes.sphere(radius=1.0, centre=(1, 1, 4))])
    carrier = cg.motion.Free(mass=2.0, inertia=np.eye(3), centre=(1, 1, 4))
    motion = cg.motion.Deforming(
        attached=TOP | {"body": "board"}, masses=TOP | {"mass": 0.7}, **RUBBER
    )
    simulation = cg.Simulation(
        bodies={"board": (board, carrier)},
        slaves={"soft": (slave, motion)},
        contacts=[],
        end=1.0,
        step=0.01,
    )
    top = slave.points[:, 2] == 2.0
    of_pad = _masses(slave)[top].sum()
    assert simulation.mechanism.fixed[0, 0] == pytest.approx(2.0 + 0.7 + of_pad, rel=1e-12)


LONE = cg.Slave(
    [*_block().points, [9.0, 9.0, 9.0]],
    _block().facets,
    elements=dict(_block().elements),
)


@pytest.mark.parametrize(
    ("masses", "text"),
    [
        ({"nodes": [1]}, "masses: mass: must be a number, or one for each node"),
        ({"nodes": [1], "mass": -1.0}, "must be a number"),
        ({"nodes": [1], "mass": np.nan}, "must be a number"),
        ({"nodes": [1], "mass": 1j}, "complex"),
        ({"nodes": [1, 2], "mass": [1.0]}, "one mass for each node.*1 for 2 nodes"),
        ({"nodes": [99], "mass": 1.0}, "names a node that is not there"),
        ({"nodes": [1], "weight": 1.0}, "a key is not known.*weight"),
        ([TOP | {"mass": 1.0}, {"plain": 1}], r"masses\[1\].*a key is not known"),
        (3.0, r"masses\[0\]: must be tables"),
        ({"box": [[8, 8, 8], [10, 10, 10]], "mass": 1.0}, "node 27 is in no element, stays where"),
    ],
)
def test_masses_that_fit_nothing_are_refused(masses: Any, text: str) -> None:
    with pytest.raises(InputError, match=text):
        _simulation(LONE, cg.motion.Deforming(masses=masses, **RUBBER), end=1.0, step=0.01)


def test_matter_of_ones_own_has_its_masses() -> None:
    chain = Chain.of(_rod(2), 1.0, 50.0)
    with pytest.raises(InputError, match="masses: matter of one's own has its masses"):
        cg.motion.Deforming(material=chain, masses={"nodes": [0], "mass": 1.0})
