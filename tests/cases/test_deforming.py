"""What deforms against exact bodies: energy, momentum, a scene carried along, the same bits."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from examples import make_foam_block
from tests.blocks import block
from tests.sample import full
from tests.scenes import square_sheet
from tests.unit.simulation.sameness import same_history, same_states

import contiga as cg
from contiga.simulation.critical import limit_of

RUBBER = cg.materials.NeoHooke(young=1.0, poisson=0.3)
SIDE, DENSITY = 10.0, 1e-3


class _StoppedError(Exception):
    pass


def _scene(
    step: float | str, end: float = 1.5, carried: float = 0.0, **options: object
) -> cg.Simulation:
    """A block of rubber that hits an exact ball of CAD, all of it `carried` along x."""
    ball = cg.Body([cg.shapes.sphere(radius=20.0, centre=(0.0, 0.0, 20.0))])
    slave = block((4, 4, 4), (SIDE,) * 3, (-0.5 * SIDE, -0.5 * SIDE, -SIDE - 0.01))
    motion = cg.motion.Deforming(material=RUBBER, density=DENSITY, velocity=[carried, 0.0, 2.0])
    way = cg.motion.Translate([[0.0, 0.0, 0.0, 0.0], [end, carried * end, 0.0, 0.0]])
    law = cg.PenaltyLaw(1.0, per_area=True)
    contact = cg.Contact(ball, slave, law=law, quadrature=3, **options)
    return cg.Simulation(
        bodies={"ball": (ball, way) if carried else ball},
        slaves={"block": (slave, motion)},
        contacts=[contact],
        end=end,
        step=step,
    )


def test_the_ledger_closes_and_its_error_is_of_second_order() -> None:
    errors = []
    for step in (0.01, 0.005):
        history = _scene(step).run().history
        assert history["force"].max() > 5.0
        errors.append(np.abs(history["energy.error"]).max() / history["energy.total"][0])
    assert errors[0] < 5e-4
    assert errors[1] < errors[0] / 3.0


def test_steps_that_choose_themselves_keep_a_thousandth_of_the_energy() -> None:
    history = _scene("auto", 3.0, friction=cg.Coulomb(0.3)).run().history
    assert history["energy.friction"][-1] > 0.0
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def test_the_ledger_of_foam_with_rates_is_of_second_order() -> None:
    """Thrown at a ball: what rates take is the work of the mean of both ends of a step."""
    rest = np.array([[0.0, 0.0], [0.05, 0.1], [0.6, 0.2], [0.9, 3.0]])
    rates = tuple((rate, rest * [1.0, times]) for rate, times in ((0.01, 1.5), (0.1, 3.0)))
    foam = cg.materials.Foam(loading=rest, hysteresis=0.1, rates=rates, filter=0.2)
    slave = block((1, 1, 3), (30.0, 30.0, 60.0), (-15.0, -15.0, 0.01), kind="hexahedron")
    motion = cg.motion.Deforming(material=foam, density=6e-5, velocity=[0.0, 0.0, -6.7])
    ball = cg.Body([cg.shapes.sphere(radius=200.0, centre=(0.0, 0.0, -200.0))])
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(0.05, per_area=True), quadrature=3)
    bodies, slaves = {"ball": ball}, {"foam": (slave, motion)}
    errors = []
    for step in (0.02, 0.01):
        simulation = cg.Simulation(
            bodies=bodies, slaves=slaves, contacts=[contact], end=6.0, step=step
        )
        history = simulation.run().history
        assert history["energy.viscosity"][-1] > 0.05 * history["energy.total"][0]
        errors.append(np.abs(history["energy.error"]).max() / history["energy.total"][0])
    assert errors[1] < min(errors[0] / 3.0, 5e-4)


def _thick_cloth(step: float | str) -> cg.Simulation:
    """A thick membrane that falls on a ball and sticks and slides there."""
    points, quads = square_sheet(10.0, 9)
    ball = cg.Body([cg.shapes.sphere(radius=4.0)])
    motion = cg.motion.Deforming(
        material=RUBBER, density=DENSITY, thickness=1.0, velocity=[1.0, 0.0, -2.0]
    )
    slave = cg.Slave(np.add(points, [0.0, 0.0, 4.6]), quads)
    contact = cg.Contact(
        ball,
        slave,
        law=cg.PenaltyLaw(0.2, per_area=True),
        friction=cg.Coulomb(0.3),
        quadrature=6,
        shell_thickness=motion.nodal_thickness(slave),
    )
    return cg.Simulation(
        bodies={"ball": ball},
        slaves={"cloth": (slave, motion)},
        contacts=[contact],
        end=1.5,
        step=step,
    )


@pytest.mark.full
def test_the_ledger_of_a_thick_shell_closes_in_second_order() -> None:
    errors = []
    for step in (0.01, 0.005, 0.0025):
        history = _thick_cloth(step).run().history
        assert history["max_penetration"].max() > 0.01
        assert history["energy.friction"][-1] > 0.0
        errors.append(np.abs(history["energy.error"]).max() / history["energy.total"][0])
    assert errors[1] < errors[0] / 3.5
    assert errors[2] < min(errors[1] / 3.5, 3e-4)


def test_a_slack_cloth_lies_flat_on_a_table_half_its_thickness_up() -> None:
    """A membrane does not resist bending: what its thickness does must not crumple it."""
    table = cg.Body([cg.shapes.plane(width=10.0, length=10.0)])
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1e3, poisson=0.3, compression=False),
        density=1.0,
        thickness=0.2,
        damping=5.0,
    )
    points, quads = square_sheet(1.0, 9)
    uneven = 1e-3 * np.random.default_rng(0).normal(size=len(points))
    points = points + np.c_[np.zeros((len(points), 2)), 0.105 + uneven]
    slave = cg.Slave(points, quads)
    law = cg.PenaltyLaw(500.0, per_area=True)
    contact = cg.Contact(table, slave, law=law, quadrature=3, shell_thickness=0.2)
    simulation = cg.Simulation(
        bodies={"table": table},
        slaves={"cloth": (slave, motion)},
        contacts=[contact],
        gravity=[0.0, 0.0, -10.0],
        end=2.0,
        step="auto",
    )
    height = simulation.run().state.slaves["cloth"].points[:, 2]
    # Its weight, 2 a unit of area, sinks it in by 2 / 500.
    np.testing.assert_allclose(height, 0.1 - 0.004, atol=1e-3)


@pytest.mark.parametrize("stiffness", [2.0, *full(20.0)])
def test_light_foam_that_rebounds_keeps_its_energy(stiffness: float) -> None:
    """All of a face of light nodes hits at once; steps that went to and fro gave it 121 %."""
    foam = cg.materials.Foam(
        loading=[[0.0, 0.0], [0.05, 0.3], [0.4, 0.45], [0.6, 0.8], [0.8, 3.0], [0.95, 20.0]],
        hysteresis=1.0,
    )
    slave = block((3, 3, 6), (30.0, 30.0, 60.0), (-15.0, -15.0, 0.01), kind="hexahedron")
    motion = cg.motion.Deforming(material=foam, density=6e-5, velocity=[0.0, 0.0, -6.7])
    floor = cg.Body([cg.shapes.plane(width=1e3, length=1e3)])
    law = cg.PenaltyLaw(stiffness, per_area=True)
    simulation = cg.Simulation(
        bodies={"floor": floor},
        slaves={"foam": (slave, motion)},
        contacts=[cg.Contact(floor, slave, law=law, quadrature=3)],
        end=2.0,
        step="auto",
    )
    history = simulation.run().history
    assert history["force"].max() > 50.0
    assert np.abs(history["energy.error"]).max() < 5e-3 * history["energy.total"][0]


def test_nodes_that_strike_a_plate_gain_nothing_by_that() -> None:
    """Foam that is as good as massless on a stiff contact: its nodes come and go all the time."""
    foam = block((1, 1, 1), (50.0,) * 3, (0.0, 0.0, 1e-6), "hexahedron")
    plate = cg.Body([cg.shapes.plane(width=200.0, length=200.0)])
    pad = cg.materials.Foam(loading=[[0.0, 0.0], [0.05, 0.3], [0.635, 0.82]])
    top = {"layer": ([0, 0, 1], 0.0)}
    thrown = cg.motion.Free(
        1000.0, inertia=1e6 * np.eye(3), velocity=[0, 0, 6.7], hold=("x", "y", "rx", "ry", "rz")
    )
    simulation = cg.Simulation(
        bodies={"plate": (plate, thrown)},
        slaves={"foam": (foam, cg.motion.Deforming(material=pad, density=4e-6, fixed=top))},
        contacts=[cg.Contact(plate, foam, law=cg.PenaltyLaw(10.0, per_area=True))],
        end=1.5,
        step="auto",
    )
    history = simulation.run().history
    assert history["force"].max() > 750.0
    assert np.abs(history["energy.error"]).max() < 5e-3 * history["energy.total"][0]


def test_foam_that_is_soft_in_tension_has_the_critical_step_of_its_compression() -> None:
    brick = block((1, 1, 1), (1.0,) * 3, kind="hexahedron")

    def critical(tension: float) -> float:
        pad = cg.materials.Foam(loading=[[0.0, 0.0], [0.9, 0.9]], tension=tension)
        falls = cg.motion.Deforming(material=pad, density=1e-3, velocity=[0, 0, -1.0])
        simulation = cg.Simulation(
            bodies={}, slaves={"brick": (brick, falls)}, contacts=[], end=1.0, step="auto"
        )
        return limit_of(simulation, simulation.start()).critical

    assert critical(0.01) == pytest.approx(critical(1.0), rel=1e-3)


def test_the_impulse_of_the_contact_is_the_change_of_momentum() -> None:
    simulation = _scene(0.01, friction=cg.Coulomb(0.3))
    result = simulation.run()
    force = np.stack([result.history[f"force_{axis}"] for axis in "xyz"], axis=1)
    impulse = 0.01 * 0.5 * (force[1:] + force[:-1]).sum(axis=0)
    mass = simulation.mechanism.masses["block"]
    momentum = mass @ result.state.slaves["block"].velocities
    before = np.array([0.0, 0.0, 2.0 * DENSITY * SIDE**3])
    np.testing.assert_allclose(momentum - before, impulse, atol=1e-12)
    assert np.linalg.norm(impulse) > 1.0


def test_a_scene_carried_along_deforms_alike() -> None:
    speed, end = 8.0, 1.5
    still, carried = (_scene(0.01, end, v).run() for v in (0.0, speed))
    one, other = (run.state.slaves["block"] for run in (still, carried))
    scale = SIDE + speed * end
    np.testing.assert_allclose(other.points - [speed * end, 0, 0], one.points, atol=1e-12 * scale)
    np.testing.assert_allclose(other.velocities - [speed, 0, 0], one.velocities, atol=1e-11)
    for name in ("force", "energy.strain", "energy.contact"):
        off = np.abs(still.history[name] - carried.history[name]).max()
        assert off < 1e-11 * np.abs(still.history[name]).max()


@pytest.mark.parametrize("step", [0.02, "auto"])
def test_stopped_and_resumed_it_is_the_same_run(tmp_path, step: float | str) -> None:
    end = 0.5

    def stop(done: int, *_: object) -> None:
        if done == 15:
            raise _StoppedError

    whole = _scene(step, end, friction=cg.Coulomb(0.3)).run(tmp_path / "whole")
    with pytest.raises(_StoppedError):
        _scene(step, end, friction=cg.Coulomb(0.3)).run(tmp_path / "parts", progress=stop)
    parts = _scene(step, end, friction=cg.Coulomb(0.3)).run(tmp_path / "parts", resume=True)
    assert whole.history["n_contact"].max() > 0
    same_history(whole.history, parts.history)
    same_states(whole.state, parts.state)


def test_a_steel_bar_hits_a_wall_with_the_stress_of_a_wave() -> None:
    """σ = ρ c v, and it leaves after 2 L/c; of a bar without lateral strain that is exact."""
    young, density, length, speed, n = 210e9, 7850.0, 1.0, 1.0, 50
    celerity = np.sqrt(young / density)
    bar = block((1, 1, n), (length / n, length / n, length), kind="hexahedron")
    wall = cg.Body([cg.shapes.plane(width=1.0, length=1.0)])
    steel = cg.materials.Elastic(young=young, poisson=0.0)
    motion = cg.motion.Deforming(material=steel, density=density, velocity=[0.0, 0.0, -speed])
    law = cg.PenaltyLaw(2.0 * young * n / length, per_area=True)
    step = 0.4 * length / n / celerity
    simulation = cg.Simulation(
        bodies={"wall": wall},
        slaves={"bar": (bar, motion)},
        contacts=[cg.Contact(wall, bar, law=law, quadrature=1)],
        end=2.4 * length / celerity,
        step=step,
    )
    history = simulation.run().history
    time, stress = history["time"], history["force"] * (n / length) ** 2
    plateau = (time > 0.3 * length / celerity) & (time < 1.7 * length / celerity)
    wave = density * celerity * speed
    assert wave == pytest.approx(40.602e6, rel=1e-4)
    assert stress[plateau].mean() == pytest.approx(wave, rel=0.01)
    # Its end is as sharp as the elements let it be: it is where the stress has fallen by half.
    assert time[stress > 0.5 * wave][-1] == pytest.approx(386.68e-6, rel=0.025)
    assert not history["n_contact"][time > 2.3 * length / celerity].any()
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def test_the_example_takes_the_head_up_with_its_energy_closed(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    make_foam_block.write_block(tmp_path / "generated" / "foam_block.vtu")
    example = Path(make_foam_block.__file__).with_name("05_foam_block.toml")
    shutil.copy(example, tmp_path)
    case = cg.load_case(tmp_path / example.name, set={"time.end": 0.6})
    result = cg.build(case).run()
    history = result.history
    head = 4540.0 * (6.7 + history["head.vz"][-1])
    impulse = np.sum(
        0.5 * (history["force_z"][1:] + history["force_z"][:-1]) * np.diff(history["time"])
    )
    assert head == pytest.approx(-impulse, rel=1e-9)
    assert history["n_contact"].max() > 20
    assert np.abs(history["energy.error"]).max() < 1e-5 * history["energy.total"][0]
    assert result.summary["depths"] == {"head-block": "head.travel"}
