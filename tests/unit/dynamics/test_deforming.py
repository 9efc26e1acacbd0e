"""Deforming slaves: integration, what is held, ledger, critical step, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import Chain, block

import contiga as cg
from contiga.errors import ElementError, InputError, RunError

RUBBER = cg.materials.NeoHooke(young=1.0, poisson=0.3)


def _simulation(
    slave: cg.Slave, motion: object, body: cg.Body | None = None, **options: object
) -> cg.Simulation:
    """With a ball far below, if no body is given."""
    ball = body or cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, -100.0))])
    law = cg.PenaltyLaw(1.0, per_area=slave.facets is not None)
    contact = cg.Contact(ball, slave, law=law, **({} if slave.facets is not None else AREAS))
    return cg.Simulation(
        bodies={"ball": ball}, slaves={"soft": (slave, motion)}, contacts=[contact], **options
    )


AREAS = {"area": cg.NodalArea(1.0)}


def _pair() -> cg.Slave:
    return cg.Slave([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def _chain(slave: cg.Slave, **options: object) -> cg.motion.Deforming:
    return cg.motion.Deforming(material=Chain.of(slave, 1.0, 50.0), **options)


def test_a_pair_on_a_spring_swings_as_it_should() -> None:
    slave, omega = _pair(), 10.0  # √(k (1/m + 1/m))
    motion = _chain(slave, velocity=[[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]])
    off = []
    for step in (0.01, 0.005):
        simulation = _simulation(slave, motion, end=1.0, step=step)
        state = simulation.run().state
        length = np.ptp(state.slaves["soft"].points[:, 2]) - 1.0
        off.append(abs(length - 0.2 / omega * np.sin(omega)))
    assert off[0] < 1e-4
    assert off[1] < off[0] / 3.5


def test_of_linear_elements_energy_is_kept_at_any_stable_step() -> None:
    slave = _pair()
    motion = _chain(slave, velocity=[[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]])
    history = _simulation(slave, motion, end=38.0, step=0.19).run().history
    kept = np.abs(history["energy.error"]).max() / history["energy.total"][0]
    assert kept < 1e-12


def test_a_step_above_the_critical_one_is_refused() -> None:
    slave = _pair()
    simulation = _simulation(slave, _chain(slave), end=1.0, step=0.21)
    with pytest.raises(RunError, match="elements of slave 'soft'"):
        simulation.run()


def test_what_is_unstable_is_stopped_with_the_reason() -> None:
    slave = _pair()
    motion = _chain(slave, velocity=[[0.0, 0.0, -1e-3], [0.0, 0.0, 1e-3]])
    simulation = _simulation(slave, motion, end=100.0, step=0.25, allow_unstable=True)
    with pytest.raises(RunError, match=r"'soft' is unstable: .* Node \d at .* Take steps below"):
        simulation.run()


def test_an_element_that_turns_inside_out_is_told_with_place_and_time() -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.0))
    velocity = np.zeros((8, 3))
    velocity[slave.points[:, 2] == 1.0, 2] = -50.0
    motion = cg.motion.Deforming(material=RUBBER, density=1.0, velocity=velocity)
    simulation = _simulation(slave, motion, end=1.0, step=0.03)
    with pytest.raises(ElementError, match=r"tet4 .*'soft'.* inside out at the time 0\.03"):
        simulation.run()


def test_held_nodes_stay_and_held_ways_slide() -> None:
    slave = block((2, 2, 2), (1.0, 1.0, 1.0))
    fixed = [
        {"plane": [[0, 0, 0], [0, 0, 2.0]]},
        {"box": [[0, 0, 0], [0, 1, 1]], "hold": "x"},
    ]
    motion = cg.motion.Deforming(
        material=RUBBER, density=1.0, fixed=fixed, velocity=[0.1, 0.1, -0.1], damping=0.5
    )
    run = _simulation(slave, motion, end=1.0, step="auto", gravity=[0.1, 0.1, -0.3]).run()
    way = run.state.slaves["soft"].points - slave.points
    low, side = slave.points[:, 2] == 0.0, slave.points[:, 0] == 0.0
    assert not way[low].any()
    assert not way[side, 0].any()
    assert (np.abs(way[side & ~low][:, 1:]) > 1e-3).all()
    energy = run.history
    assert energy["energy.damping"][-1] > 0.01 * energy["energy.total"].max()
    assert np.abs(energy["energy.error"]).max() < 1e-3 * energy["energy.total"].max()


def test_damping_slows_a_flight_exponentially_and_its_loss_is_counted() -> None:
    slave = _pair()
    motion = _chain(slave, velocity=[0.0, 0.0, 1.0], damping=2.0)
    off = []
    for step in (0.02, 0.01):
        history = _simulation(slave, motion, end=1.0, step=step).run().history
        speed = np.sqrt(history["energy.kinetic"][-1])
        assert abs(speed - np.exp(-2.0)) < 3.0 * step**2 * np.exp(-2.0)
        off.append(np.abs(history["energy.error"]).max())
    assert off[0] < 5e-4
    assert off[1] < off[0] / 3.5


def test_a_rest_other_than_the_start_is_strained() -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.1))
    rest = slave.points / [1.0, 1.0, 1.1]
    motion = cg.motion.Deforming(material=RUBBER, density=1.0, rest=rest)
    state = _simulation(slave, motion, end=1.0, step=0.01).start()
    assert state.energy.strain > 1e-3
    strained = state.energy.strain
    even = cg.motion.Deforming(material=RUBBER, density=1.0)
    assert _simulation(slave, even, end=1.0, step=0.01).start().energy.strain < 1e-12 * strained


def test_nodes_of_no_element_stay_where_they_are() -> None:
    whole = block((1, 1, 1), (1.0, 1.0, 1.0))
    points = np.concatenate([[[5.0, 5.0, 5.0]], whole.points])
    slave = cg.Slave(
        points, whole.facets + 1, elements={"tetra": np.asarray(whole.elements["tetra"]) + 1}
    )
    motion = cg.motion.Deforming(material=RUBBER, density=1.0, velocity=[0.0, 0.0, 1.0])
    simulation = _simulation(slave, motion, end=1.0, step=0.05, gravity=[0.0, 0.0, 2.0])
    assert "lone" not in {finding.rule for finding in simulation.check()}
    active = cg.Slave(points, slave.facets, active=np.ones(9, bool), elements=slave.elements)
    findings = _simulation(active, motion, end=1.0, step=0.05).check()
    assert any("1 of its points" in finding.text for finding in findings if finding.rule == "lone")
    state = simulation.run().state
    way = state.slaves["soft"].points - points
    assert not way[0].any()
    np.testing.assert_allclose(way[1:], np.tile([0.0, 0.0, 2.0], (8, 1)), atol=1e-12)


def test_facets_alone_are_membranes() -> None:
    points = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    slave = cg.Slave(points, [[0, 1, 2], [0, 2, 3]])
    motion = cg.motion.Deforming(material=RUBBER, density=2.0, thickness=0.1, fixed=[0, 3])
    nodes = _simulation(slave, motion, end=1.0, step=0.01).mechanism.nodes["soft"]
    assert nodes.mass is not None
    assert nodes.mass.sum() == pytest.approx(0.2)


def test_what_decides_the_way_is_in_the_fingerprint() -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.0))
    stiffer = cg.materials.NeoHooke(young=1.1, poisson=0.3)
    motions = [
        cg.motion.Deforming(material=RUBBER, density=1.0),
        cg.motion.Deforming(material=RUBBER, density=1.1),
        cg.motion.Deforming(material=stiffer, density=1.0),
        cg.motion.Deforming(material=RUBBER, density=1.0, fixed={"nodes": [0]}),
        cg.motion.Deforming(material=RUBBER, density=1.0, damping=0.1),
    ]
    prints = {_simulation(slave, one, end=1.0, step=0.01).fingerprint() for one in motions}
    assert len(prints) == len(motions)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"material": 3.0}, "must be a material"),
        ({"fixed": {"hold": ["x"]}}, "by one key"),
        ({"damping": -1.0}, "must be 0 or more"),
        ({"density": 0.0}, "density"),
        ({"density": None}, "density: is missing"),
        ({"fixed": {"bax": [[0, 0, 0], [1, 1, 1]]}}, "a key is not known"),
        ({"fixed": {"box": [[5, 5, 5], [6, 6, 6]]}}, "no node of the slave is there"),
        ({"fixed": {"plane": [[0, 0, 0], [0, 0, 1]], "hold": ["rx"]}}, "can be held"),
        ({"fixed": [9]}, "not there"),
        ({"velocity": np.zeros((3, 3))}, "one row a slave point"),
        ({"rest": np.zeros((3, 3))}, "one row a slave point"),
    ],
)
def test_bad_input_is_refused(options: dict[str, object], text: str) -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match=text):
        _deformed_by(slave, {"material": RUBBER, "density": 1.0} | options)


def _deformed_by(slave: cg.Slave, options: dict[str, object]) -> None:
    motion = cg.motion.Deforming(**options)
    assert _simulation(slave, motion, end=1.0, step=0.01).mechanism


def test_slaves_that_cannot_deform_are_refused() -> None:
    motion = cg.motion.Deforming(material=RUBBER, density=1.0)
    with pytest.raises(InputError, match="needs elements"):
        assert _simulation(_pair(), motion, end=1.0, step=0.01).mechanism
    wedge = cg.Slave(
        [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
        [[0, 2, 1]],
        elements={"wedge": [[0, 1, 2, 3, 4, 5]]},
    )
    with pytest.raises(InputError, match="1 wedge"):
        assert _simulation(wedge, motion, end=1.0, step=0.01).mechanism
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    with pytest.raises(InputError, match="a body is rigid"):
        cg.Simulation(bodies={"ball": (ball, motion)}, slaves={}, contacts=[], end=1.0, step=0.1)
