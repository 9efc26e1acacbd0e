"""Gas in the slaves of a simulation: forces, energy, steps, checkpoints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError, RunError
from contiga.gas import Chamber, IdealGas, Inflator, Surroundings, Vent
from contiga.simulation.critical import find_limit
from contiga.simulation.gas import Skin

AIR = IdealGas(1.4, 287.05)
AROUND = Surroundings(101_325.0, 293.15, AIR)
CLOTH = cg.materials.Elastic(young=1e6, poisson=0.3)
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(parts: int = 2, size: float = 0.4) -> cg.Slave:
    """A cube of facets, its normals outward."""
    points, facets = [], []
    for a, b, c, d in (CORNERS[list(side)] for side in SIDES):
        first, line = len(points), np.linspace(0.0, 1.0, parts + 1)
        for u in line:
            points += [(1 - u) * ((1 - v) * a + v * d) + u * ((1 - v) * b + v * c) for v in line]
        grid = first + np.arange((parts + 1) ** 2).reshape(parts + 1, -1)
        p, q, r, s = (
            g.ravel() for g in (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
        )
        facets += [np.stack(t, -1) for t in ((p, q, r), (p, r, s))]
    rounded, place = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    return cg.Slave(size * rounded, place.ravel()[np.concatenate(facets)])


def bag(chamber: Chamber, bodies: Any = None, contacts: Any = (), **given: Any) -> cg.Simulation:
    motion = cg.motion.Deforming(material=CLOTH, density=800.0, thickness=1e-3)
    options = {"end": 0.02, "step": 2e-5} | given
    slaves = {"bag": (box(), motion)}
    return cg.Simulation(
        bodies=bodies or {}, slaves=slaves, contacts=contacts, gas=[chamber], **options
    )


def test_volume_and_its_gradient() -> None:
    slave = box()
    skin = Skin(np.arange(len(slave.points), dtype=np.int32), slave.facets)
    rng = np.random.default_rng(1)
    points = slave.points + 0.05 * rng.normal(size=slave.points.shape)
    assert skin.closed(slave.points).volume == pytest.approx(0.064, rel=1e-12)
    assert skin.closed(slave.points).areas.sum() == pytest.approx(0.96, rel=1e-12)
    way, h = rng.normal(size=points.shape), 1e-6
    change = (skin.closed(points + h * way).volume - skin.closed(points - h * way).volume) / (2 * h)
    assert (skin.closed(points).gradient * way).sum() == pytest.approx(change, rel=1e-9)
    np.testing.assert_allclose(skin.closed(points).gradient.sum(axis=0), 0.0, atol=1e-15)
    # Row sums of the second derivative are no more than their bound.
    second = np.zeros((len(points), 3))
    for a in range(len(points)):
        for d in range(3):
            to = points.copy()
            to[a, d] += h
            second += np.abs(skin.closed(to).gradient - skin.closed(points).gradient) / h
    assert (second.max(axis=1) <= 2.0 * skin.closed(points).stiffness * (1 + 1e-6)).all()


def test_nothing_moves_at_the_pressure_around() -> None:
    result = bag(Chamber("bag", AROUND)).run()
    np.testing.assert_allclose(result.state.slaves["bag"].points, box().points, atol=1e-12)
    assert result.history["gas.pressure"][-1] == pytest.approx(101_325.0, rel=1e-12)


def test_a_bag_that_is_blown_up_keeps_the_energy() -> None:
    """Enthalpy that comes in is in the gas, the cloth and its motion; the error falls as h²."""
    blown = Chamber(
        "bag", AROUND, inflators=[Inflator([[0.0, 0.0], [0.01, 5.0], [0.02, 0.0]], 600.0)]
    )
    ends = [bag(blown, step=step).run() for step in (4e-5, 1e-5)]
    energy = ends[1].state.energy
    came = ends[1].history["gas.flow_in"][-1]
    assert came == pytest.approx(0.05 * AIR.c_p * 600.0, rel=1e-6)
    assert energy.strain + energy.kinetic > 5e-4 * came
    errors = [abs(end.state.energy.error) / came for end in ends]
    assert errors[1] < 1e-6
    assert errors[0] > 6.0 * errors[1]
    assert ends[1].history["gas.volume"][-1] > 1.02 * 0.064


def test_momentum_is_kept() -> None:
    blown = Chamber("bag", AROUND, inflators=[Inflator(0.3, 600.0)], vents=[Vent(1e-3)])
    simulation = bag(blown)
    state = simulation.run().state.slaves["bag"]
    mass = simulation.mechanism.masses["bag"]
    assert np.abs(state.velocities).max() > 0.1
    np.testing.assert_allclose(mass @ state.velocities, 0.0, atol=1e-10)


def test_the_gas_stiffens_the_bag() -> None:
    """Of heavy nodes on stiff gas the critical step is that of the gas, 2/√(γ p/V Σ |∂V/∂x|²/m)."""
    stiff, plain = (bag(Chamber("bag", AROUND._replace(pressure=p))) for p in (1e9, 101_325.0))
    start = stiff.start()
    gradient = stiff.chambers.closed("gas", start.slaves["bag"].points).gradient
    swing = (np.square(gradient).sum(axis=1) / stiff.mechanism.masses["bag"]).sum()
    of_gas = 2.0 / np.sqrt(1.4 * 1e9 / 0.064 * swing)
    limit = find_limit(stiff, start)
    assert limit.critical == pytest.approx(of_gas, rel=0.05)
    assert limit.critical < of_gas
    assert find_limit(plain, plain.start()).critical > 10.0 * of_gas


def test_a_ball_is_caught_by_a_bag(tmp_path: Any) -> None:
    """A bag on the ground catches a ball and gives back what the vent does not let go."""
    centre = (0.2, 0.2, 0.56)
    ball = cg.Body([cg.shapes.sphere(radius=0.15, centre=centre)])
    moving = cg.motion.Free(4.0, inertia=0.04 * np.eye(3), centre=centre, velocity=(0, 0, -3.0))
    floor = cg.Body([cg.shapes.plane(width=3.0, length=3.0)])
    slave = box()
    motion = cg.motion.Deforming(material=CLOTH, density=800.0, thickness=1e-3)
    law = cg.PenaltyLaw(2e6, per_area=True)

    def made() -> cg.Simulation:
        return cg.Simulation(
            bodies={"ball": (ball, moving), "floor": floor},
            slaves={"bag": (slave, motion)},
            contacts=[cg.Contact(ball, slave, law=law), cg.Contact(floor, slave, law=law)],
            gas=[Chamber("bag", AROUND, vents=[Vent(3e-4)])],
            end=0.025,
            step=5e-5,
        )

    result = made().run()
    assert result.history["gas.pressure"].max() > 101_325.0 + 50.0
    assert result.history["gas.flow_out"][-1] > 1.0
    energy = result.state.energy
    assert abs(energy.error) < 2e-3 * 0.5 * 4.0 * 9.0
    assert "energy.gas" in result.history

    def stop(state: Any) -> None:
        if state.time > 0.01:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        made().run(tmp_path / "out", on_step=stop)
    again = made().run(tmp_path / "out", resume=True)
    one, other = (run.state.slaves["bag"].points for run in (result, again))
    assert one.tobytes() == other.tobytes()
    assert again.state.gas["gas"].gas.energy == result.state.gas["gas"].gas.energy


def test_a_chamber_without_room_ends_the_run_with_its_name() -> None:
    class Collapsing:
        def points(self, t: float) -> np.ndarray:
            return box().points * [1.0, 1.0, 1.0 - 2.0 * t]

        def velocities(self, t: float) -> np.ndarray:
            return box().points * [0.0, 0.0, -2.0]

    ball = cg.Body([cg.shapes.sphere(radius=0.1, centre=(0, 0, 9))])
    simulation = cg.Simulation(
        bodies={"ball": (ball, cg.motion.Free(1.0, inertia=np.eye(3), centre=(0, 0, 9)))},
        slaves={"bag": (box(), Collapsing())},
        contacts=[],
        gas=[Chamber("bag", AROUND, name="airbag")],
        end=1.0,
        step=0.05,
    )
    with pytest.raises(RunError, match="gas 'airbag' has no room left"):
        simulation.run()


def test_a_bag_settles_with_its_gas_squeezed() -> None:
    """Cloth that was cut smaller squeezes the air until both balance, and the run begins there."""
    slave = box()
    motion = cg.motion.Deforming(
        material=CLOTH, density=800.0, thickness=1e-3, rest=0.9 * slave.points
    )
    blow = Inflator([[1e-3, 5.0], [2e-3, 5.0]], 600.0)
    chamber = Chamber("bag", AROUND, inflators=[blow], vents=[Vent(1e-3)], leak=1e-3)
    simulation = cg.Simulation(
        bodies={},
        slaves={"bag": (slave, motion)},
        contacts=[],
        gas=[chamber],
        end=2e-3,
        step=1e-5,
        settling=cg.Settle(tolerance=1e-6),
    )
    start = simulation.settle()
    gas = start.gas["gas"].gas
    assert gas.volume < 0.0639
    squeezed = (0.064 / gas.volume) ** 1.4
    assert gas.pressure == pytest.approx(101_325.0 * squeezed, rel=1e-10)
    assert (gas.came, gas.left, gas.stored, start.energy.gas) == (0.0, 0.0, 0.0, 0.0)
    assert start.energy.strain > 0.0
    history = simulation.run().history
    assert history["gas.pressure"][0] == gas.pressure
    assert history["gas.flow_in"][-1] == pytest.approx(5e-3 * AIR.c_p * 600.0, rel=1e-6)
    assert np.abs(history["energy.error"]).max() < 1e-4 * history["gas.flow_in"][-1]


def on_floor(quadrature: str | int, width: float, **gas: Any) -> float:
    """What comes out of a blown box that is held on a floor up to x = width, in a short time."""
    centre = (0.5 * width - 0.5, 0.0, -1e-4)
    floor = cg.Body([cg.shapes.plane(width=width + 1.0, length=3.0, centre=centre)])
    slave = box(4)
    motion = cg.motion.Deforming(
        material=CLOTH, density=800.0, thickness=1e-3, fixed=np.ones(len(slave), bool)
    )
    law = cg.PenaltyLaw(1e4, per_area=True)
    contact = cg.Contact(floor, slave, law=law, quadrature=quadrature)
    chamber = Chamber("bag", AROUND, inflators=[Inflator(1.0, 600.0)], **gas)
    simulation = cg.Simulation(
        bodies={"floor": (floor, cg.motion.Translate([[0, 0, 0, 0], [1e-6, 0, 0, 2e-3]]))},
        slaves={"bag": (slave, motion)},
        contacts=[contact],
        gas=[chamber],
        end=2e-4,
        step=2e-6,
    )
    return float(simulation.run().history["gas.flow_out"][-1])


def test_fabric_that_a_body_covers_does_not_leak() -> None:
    """A side of six, or half of one; by nodes their share of the sides beside it, too."""
    whole = on_floor(3, -0.9, leak=1e-4)
    assert whole > 0.0
    assert on_floor(3, 1.0, leak=1e-4) == pytest.approx(5 / 6 * whole, rel=1e-4)
    assert on_floor(3, 0.2, leak=1e-4) == pytest.approx(11 / 12 * whole, rel=1e-4)
    assert 0.6 * whole < on_floor("nodes", 1.0, leak=1e-4) < 5 / 6 * whole


def test_a_vent_that_a_body_covers_is_closed() -> None:
    vent = Vent(1e-4, on={"plane": [[0, 0, 0], [0, 0, 1]]})
    whole = on_floor(3, -0.9, vents=[vent])
    assert on_floor(3, 1.0, vents=[vent]) == 0.0
    assert on_floor(3, 0.2, vents=[vent]) == pytest.approx(0.5 * whole, rel=1e-3)
    assert on_floor(3, 1.0, vents=[Vent(1e-4)]) == pytest.approx(whole, rel=1e-12)


def test_a_slave_that_a_motion_squeezes_has_gas_beside_a_contact() -> None:
    """Nothing is free: the gas is there, and the work of the motion in it."""

    class Squeezed:
        def points(self, t: float) -> np.ndarray:
            return box().points * [1.0, 1.0, 1.0 - 0.2 * t]

        def velocities(self, t: float) -> np.ndarray:
            return box().points * [0.0, 0.0, -0.2]

    floor, slave = cg.Body([cg.shapes.plane(width=3.0, length=3.0)]), box()
    result = cg.Simulation(
        bodies={"floor": floor},
        slaves={"bag": (slave, Squeezed())},
        contacts=[cg.Contact(floor, slave, law=cg.PenaltyLaw(1e4, per_area=True))],
        gas=[Chamber("bag", AROUND)],
        end=1.0,
        step=0.01,
    ).run()
    history = result.history
    assert history["gas.pressure"][-1] == pytest.approx(101_325.0 * 0.8**-1.4, rel=1e-12)
    assert history["energy.gas"][-1] == pytest.approx(history["energy.external"][-1], rel=1e-4)


def open_box() -> cg.Slave:
    whole = box()
    return cg.Slave(whole.points, np.delete(whole.facets, [0, 4], axis=0))


def turned_box() -> cg.Slave:
    whole = box()
    facets = whole.facets.copy()
    facets[3] = facets[3, ::-1]
    return cg.Slave(whole.points, facets)


@pytest.mark.parametrize(
    ("slave", "chamber", "said"),
    [
        (box(), Chamber("sack", AROUND), "no slave of this name"),
        (open_box(), Chamber("bag", AROUND), r"4 sides are open: 4 from \[.*\] to \[.*\]"),
        (turned_box(), Chamber("bag", AROUND), "3 sides join facets whose normals disagree"),
        (
            box(),
            Chamber("bag", AROUND, vents=[Vent(1.0, on={"box": [[0, 0, 0], [0.1, 0.1, 0.1]]})]),
            "on no fabric",
        ),
        (cg.Slave(box().points, box().facets[:, ::-1]), Chamber("bag", AROUND), "point into"),
        (cg.Slave(box().points), Chamber("bag", AROUND), "no facets"),
    ],
)
def test_what_does_not_hold_gas_is_refused(slave: Any, chamber: Chamber, said: str) -> None:
    with pytest.raises(InputError, match=said):
        cg.Simulation(
            bodies={},
            slaves={"bag": (slave, cg.motion.Free(1.0))},
            contacts=[],
            gas=[chamber],
            end=1.0,
            step=0.1,
        )
