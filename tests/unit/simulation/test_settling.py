"""What comes to rest before it runs: closed forms, the ledger after it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.errors import InputError, RunError

YOUNG, DENSITY, GRAVITY = 1.0, 1e-3, 0.5
SOFT = cg.materials.Elastic(young=YOUNG)
FAR = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, -100.0))])


def _simulation(slave: cg.Slave, fixed: object = None, **options: object) -> cg.Simulation:
    """A block under its own weight, beside nothing that it touches, if no contact is given."""
    motion = cg.motion.Deforming(material=SOFT, density=DENSITY, fixed=fixed)
    given = {"bodies": {"ball": FAR}, "contacts": []} | options
    return cg.Simulation(
        slaves={"block": (slave, motion)},
        **({"gravity": [0.0, 0.0, -GRAVITY], "end": 4.0, "step": "auto", "settling": True} | given),
    )


def _bar(tolerance: float | None = 1e-6) -> cg.Simulation:
    slave = block((1, 1, 8), (4.0, 4.0, 20.0), kind="hexahedron")
    fixed = {"plane": [[0, 0, 20.0], [0, 0, 1]]}
    settle = False if tolerance is None else cg.Settle(tolerance=tolerance)
    return _simulation(slave, fixed, settling=settle)


def _hanging(counts: int, height: float) -> np.ndarray:
    """Depths of the nodes, from the lowest on: each element carries the nodes below its middle."""
    side = height / counts
    stress = DENSITY * GRAVITY * side * (np.arange(counts) + 0.5) / YOUNG
    # (1 + e) (e + e²/2) = σ/E of Saint-Venant and Kirchhoff
    strains = [max(np.roots([0.5, 1.5, 1.0, -s]).real, key=lambda e: e > -0.5) for s in stress]
    return side * np.cumsum(strains[::-1])[::-1]


def test_a_bar_hangs_as_each_element_carries_what_is_below() -> None:
    simulation = _bar()
    state = simulation.settle()
    slave = simulation.slaves["block"].slave
    column = (slave.points[:, 0] == 0.0) & (slave.points[:, 1] == 0.0)
    way = slave.points[column, 2] - state.slaves["block"].points[column, 2]
    np.testing.assert_allclose(way[:-1], _hanging(8, 20.0), rtol=2e-5)
    assert way[0] == pytest.approx(DENSITY * GRAVITY * 20.0**2 / 2.0 / YOUNG, rel=0.02)
    assert state.rest is not None
    assert 0 < state.rest.steps < 5000
    assert state.rest.residual <= 1e-6
    assert not state.slaves["block"].velocities.any()


def test_what_hangs_stays_and_its_ledger_begins_at_rest() -> None:
    history = _bar().run().history
    strain = history["energy.strain"][0]
    assert strain > 1e-3
    assert history["energy.kinetic"].max() < 1e-10 * strain
    assert np.abs(history["energy.error"]).max() < 1e-10 * strain
    assert history["energy.external"][0] == 0.0
    assert _bar(None).run().history["energy.kinetic"].max() > 1e-2 * strain


def test_a_soft_block_rests_on_a_plane_with_its_weight() -> None:
    slave = block((2, 2, 3), (6.0, 6.0, 12.0), (-3.0, -3.0, 0.05), kind="hexahedron")
    plane = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])
    law = cg.PenaltyLaw(2.0, damping=0.1, per_area=True)
    contact = cg.Contact(plane, slave, law=law, friction=cg.Coulomb(0.3), quadrature=3)
    settle = cg.Settle(tolerance=2e-3)
    simulation = _simulation(
        slave, bodies={"plane": plane}, contacts=[contact], end=0.1, settling=settle
    )
    result = simulation.run(keep=1)
    weight, pressure = DENSITY * GRAVITY * 6.0 * 6.0 * 12.0, DENSITY * GRAVITY * 12.0
    force = result.history["force_z"]
    np.testing.assert_allclose(force, weight, rtol=5e-3)
    start = result.states[0]
    top = 12.05 - start.slaves["block"].points[slave.points[:, 2] > 12.0, 2].mean()
    assert top - 0.05 == pytest.approx(pressure * (12.0 / 2.0 / YOUNG + 1.0 / 2.0), rel=0.02)
    energy = start.contacts[simulation.contacts[0].name].energy
    assert energy.work == energy.stored > 0.0
    assert energy.damping == energy.friction == energy.error == 0.0
    assert result.history["energy.kinetic"].max() < 1e-5 * result.history["energy.strain"][0]


@pytest.mark.parametrize("settles", [True, False])
def test_a_free_body_comes_to_rest_where_it_is_named_and_else_waits(settles: bool) -> None:
    slave = block((2, 2, 2), (6.0, 6.0, 6.0), (-3.0, -3.0, -6.0), kind="hexahedron")
    ball = cg.Body([cg.shapes.sphere(radius=6.0, centre=(0.0, 0.0, 6.02))])
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0, per_area=True), quadrature=3)
    free = cg.motion.Free(mass=0.3, inertia=np.eye(3), centre=[0, 0, 6.02], hold=["rx", "ry"])
    simulation = _simulation(
        slave,
        {"plane": [[0, 0, -6.0], [0, 0, 1]]},
        bodies={"ball": (ball, free)},
        contacts=[contact],
        settling=cg.Settle(bodies=["ball"] if settles else []),
    )
    state = simulation.settle()
    force = state.contacts[simulation.contacts[0].name].wrench[2]
    assert force == pytest.approx(0.3 * GRAVITY if settles else 0.0, rel=5e-3)
    assert (state.bodies["ball"].pose[2, 3] < -0.02) == settles
    assert simulation.step(state).time > 0.0


def test_what_nothing_holds_does_not_come_to_rest() -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.0), kind="hexahedron")
    simulation = _simulation(slave, settling=cg.Settle(steps=30))
    with pytest.raises(RunError, match=r"not come to rest: after 30 steps .* held by nothing"):
        simulation.run()


def test_what_cannot_settle_is_refused() -> None:
    cloud = cg.Slave([[0.0, 0.0, 0.0]], area=[1.0])
    contact = cg.Contact(FAR, cloud, law=cg.PenaltyLaw(1.0))
    parts = {"bodies": {"ball": FAR}, "slaves": {"cloud": cloud}, "contacts": [contact]}
    simulation = cg.Simulation(**parts, end=1.0, step=0.1)
    with pytest.raises(InputError, match="no slave deforms"):
        simulation.settle()
    with pytest.raises(InputError, match="not free"):
        cg.Simulation(**parts, end=1.0, step=0.1, settling=cg.Settle(bodies=["ball"]))
    with pytest.raises(InputError, match="a Settle"):
        cg.Simulation(**parts, end=1.0, step=0.1, settling=0.1)
    with pytest.raises(InputError, match="steps"):
        cg.Settle(steps=0)


def test_a_run_that_only_settles_leaves_that_state_and_another_goes_on_from_it(
    tmp_path: Path,
) -> None:
    pytest.importorskip("h5py")
    at_rest = _bar(1e-3).run(tmp_path, settle_only=True)
    assert len(at_rest.history["time"]) == 1
    assert at_rest.summary["settled"]["residual"] <= 1e-3
    resumed = _bar(1e-3).run(tmp_path, resume=True)
    whole = _bar(1e-3).run()
    assert resumed.summary["settled"] == at_rest.summary["settled"] == whole.summary["settled"]
    for name in ("energy.strain", "energy.kinetic"):
        np.testing.assert_array_equal(resumed.history[name], whole.history[name])


@pytest.mark.parametrize(("settling", "rules"), [(True, set()), (False, {"apart"})])
def test_what_comes_to_rest_first_is_not_judged_by_where_it_stands_before(
    settling: bool, rules: set[str]
) -> None:
    """A block half a length above a plane, which it would not reach in the time of the run."""
    slave = block((2, 2, 3), (6.0, 6.0, 12.0), (-3.0, -3.0, 0.5), kind="hexahedron")
    plane = cg.Body([cg.shapes.plane(width=50.0, length=50.0)])
    contact = cg.Contact(plane, slave, law=cg.PenaltyLaw(1.0, per_area=True), quadrature=3)
    parts = {"bodies": {"plane": plane}, "contacts": [contact]}
    simulation = _simulation(slave, settling=settling, end=0.5, **parts)
    assert {finding.rule for finding in simulation.check()} == rules
