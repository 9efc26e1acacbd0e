"""Slaves whose nodes are x = N q of matter: they move as its elements do, and keep energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.dynamics.deforming_nodes import DeformingNodes
from contiga.dynamics.mapped_nodes import MappedNodes, moved_by, nodal_masses
from contiga.errors import InputError
from contiga.matter import Part, assemble

SIDE, FINE = 7, 13
MIDDLE = (0.52, 0.47, 0.31)
RUBBER = cg.materials.Elastic(young=5e5, poisson=0.3)


def grid(side: int) -> np.ndarray:
    """Nodes of a square sheet of 1 × 1."""
    x = np.linspace(0.0, 1.0, side)
    return np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((side, side))], -1).reshape(-1, 3)


def facets(side: int) -> np.ndarray:
    i = np.arange(side * side).reshape(side, side)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    return np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])


class Refined:
    """A membrane of few nodes, seen at many: N is linear between the nodes."""

    def __init__(self, coarse: int = SIDE, fine: int = FINE) -> None:
        part = Part(
            kind="tri3", elements=facets(coarse), material=RUBBER, density=1000.0, thickness=1e-3
        )
        self.matter = assemble(grid(coarse), [part])
        self.mass, self.start, self.forces = self.matter.mass, self.matter.start, self.matter.forces
        self.stiffness = self.matter.stiffness
        at = np.linspace(0.0, coarse - 1.0, fine)
        line = np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(coarse)))
        self.weights = np.kron(line, line)

    def points(self, q: np.ndarray) -> np.ndarray:
        return self.weights @ q

    def spread(self, f: np.ndarray) -> np.ndarray:
        return self.weights.T @ f


def sheet(side: int) -> cg.Slave:
    return cg.Slave(grid(side), facets(side))


def dropped(slave: cg.Slave, motion: Any, step: float | str = 2e-5, **more: Any) -> cg.Simulation:
    """A ball that falls on the sheet."""
    ball = cg.Body([cg.shapes.sphere(radius=0.3, centre=MIDDLE)])
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(2e5, per_area=True))
    return cg.Simulation(
        bodies={
            "ball": (
                ball,
                cg.motion.Free(2.0, inertia=0.07 * np.eye(3), centre=MIDDLE, velocity=(0, 0, -3.0)),
            )
        },
        slaves={"sheet": (slave, motion)},
        contacts=[contact],
        end=0.012,
        step=step,
        **more,
    )


def held(**more: Any) -> cg.motion.Deforming:
    place = {"box": [[-1, -1, -1], [1e-9, 2, 1]]}
    return cg.motion.Deforming(material=Refined(), fixed=place, **more)


def test_the_identity_moves_as_the_elements_do() -> None:
    plain = cg.motion.Deforming(material=RUBBER, density=1000.0, thickness=1e-3)
    own = cg.motion.Deforming(material=Refined(FINE, FINE))
    one, other = (dropped(sheet(FINE), motion).run() for motion in (plain, own))
    assert isinstance(dropped(sheet(FINE), own).mechanism.nodes["sheet"], MappedNodes)
    a, b = one.state.slaves["sheet"], other.state.slaves["sheet"]
    assert one.state.energy.strain > 0.01
    np.testing.assert_allclose(b.points, a.points, rtol=0, atol=1e-9)
    np.testing.assert_allclose(b.velocities, a.velocities, rtol=0, atol=1e-5)
    np.testing.assert_allclose(other.state.energy, one.state.energy, rtol=1e-6, atol=1e-6)


def test_energy_is_kept_to_the_square_of_the_step() -> None:
    ends = [dropped(sheet(FINE), held(), step).run().state.energy for step in (4e-5, 1e-5)]
    errors = [abs(end.error) / end.initial for end in ends]
    assert ends[0].strain + ends[0].contact > 0.02 * ends[0].initial
    assert errors[1] < 1e-4
    assert errors[0] > 8.0 * errors[1]


def test_momentum_is_kept_by_a_free_sheet() -> None:
    result = dropped(sheet(FINE), cg.motion.Deforming(material=Refined())).run()
    state, matter = result.state, Refined()
    v = state.slaves["sheet"].matter["q_velocity"]
    of_sheet = (matter.mass[:, None] * v).sum(axis=0)
    of_ball = 2.0 * state.bodies["ball"].twist.velocity
    assert np.linalg.norm(of_sheet) > 0.1
    np.testing.assert_allclose(of_sheet + of_ball, [0.0, 0.0, -6.0], rtol=0, atol=1e-9)


def test_nodes_follow_their_degrees_of_freedom() -> None:
    state = dropped(sheet(FINE), held()).run().state.slaves["sheet"]
    matter = Refined()
    np.testing.assert_allclose(state.points, matter.points(state.matter["q"]), rtol=0, atol=1e-15)
    edge = grid(FINE)[:, 0] == 0.0
    np.testing.assert_array_equal(state.points[edge], grid(FINE)[edge])
    assert np.abs(state.points - grid(FINE)).max() > 0.01


def test_masses_of_nodes_are_those_of_the_matter() -> None:
    matter = Refined()
    mass = nodal_masses(matter, FINE * FINE)
    assert mass.min() > 0.0
    assert mass.sum() == pytest.approx(matter.mass.sum(), rel=1e-12)


def test_what_moves_an_edge_is_the_edge() -> None:
    matter, edge = Refined(), grid(FINE)[:, 1] == 1.0
    ways = moved_by(matter, np.repeat(edge[:, None], 3, axis=1))
    np.testing.assert_array_equal(ways.all(axis=1), grid(SIDE)[:, 1] == 1.0)


@pytest.mark.parametrize("load", [cg.motion.Pressure(-50.0), cg.motion.NodalForce((0, 0, -90.0))])
def test_loads_on_nodes_do_their_work_on_degrees_of_freedom(load: Any) -> None:
    result = dropped(sheet(FINE), held(loads=load)).run()
    energy = result.state.energy
    assert energy.external > 0.05
    assert abs(energy.error) < 1e-3 * (energy.initial + energy.external)


def test_a_driven_and_an_attached_edge_follow_their_motions() -> None:
    up = cg.motion.Translate([[0.0, 0, 0, 0], [0.012, 0, 0, 0.1]])
    motion = cg.motion.Deforming(
        material=Refined(),
        driven={"box": [[-1, -1, -1], [1e-9, 2, 1]], "motion": up},
        attached={"box": [[1 - 1e-9, -1, -1], [2, 2, 1]], "body": "ball"},
    )
    result = dropped(sheet(FINE), motion).run()
    points, rest = result.state.slaves["sheet"].points, grid(FINE)
    first, last = rest[:, 0] == 0.0, rest[:, 0] == 1.0
    np.testing.assert_allclose(points[first], rest[first] + [0, 0, 0.1], rtol=0, atol=1e-12)
    X = result.state.bodies["ball"].pose
    there = rest[last] @ X[:3, :3].T + X[:3, 3]
    np.testing.assert_allclose(points[last], there, rtol=0, atol=1e-12)
    assert abs(result.state.energy.error) < 1e-3 * result.state.energy.initial


def test_steps_are_chosen_by_the_degrees_of_freedom() -> None:
    result = dropped(sheet(FINE), held(), "auto").run()
    energy = result.state.energy
    assert abs(energy.error) < 1e-3 * energy.initial
    mover = dropped(sheet(FINE), held()).mechanism.nodes["sheet"]
    assert isinstance(mover, MappedNodes)
    assert isinstance(mover.dofs, DeformingNodes)
    # Of one spring at a node that is a degree of freedom: k/m.
    corner = np.array([0], np.int32)
    assert mover.square_bound(corner, np.array([3.0])) == pytest.approx(3.0 / mover.dofs.mass[0])


def test_a_run_resumes_with_the_same_bits(tmp_path: Any) -> None:
    whole = dropped(sheet(FINE), held(), 6e-5).run()

    def stop(state: Any) -> None:
        if state.time > 0.006:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dropped(sheet(FINE), held(), 6e-5).run(tmp_path / "out", on_step=stop)
    again = dropped(sheet(FINE), held(), 6e-5).run(tmp_path / "out", resume=True)
    one, other = (run.state.slaves["sheet"] for run in (whole, again))
    assert one.points.tobytes() == other.points.tobytes()
    assert one.matter["q_velocity"].tobytes() == other.matter["q_velocity"].tobytes()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"velocity": np.zeros((FINE * FINE, 3))}, "must be one for all points"),
        (
            {
                "fixed": {"box": [[-1, -1, -1], [0.3, 2, 1]]},
                "driven": {
                    "box": [[0.4, -1, -1], [2, 2, 1]],
                    "motion": cg.motion.Translate([[0.0, 0, 0, 0], [1.0, 0, 0, 1]]),
                },
            },
            "two places need the same control points",
        ),
    ],
)
def test_what_cannot_be_mapped_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        dropped(sheet(FINE), cg.motion.Deforming(material=Refined(), **given))


def test_matter_of_other_points_is_refused() -> None:
    motion = cg.motion.Deforming(material=Refined())
    with pytest.raises(InputError, match="its points must be those of the slave"):
        dropped(sheet(SIDE), motion)
    moved = cg.Slave(grid(FINE) + np.array([0.0, 0.0, 0.1]), facets(FINE))
    with pytest.raises(InputError, match=r"0\.1 apart"):
        dropped(moved, motion)


def test_a_section_through_a_mapped_slave_is_refused() -> None:
    """Its forces are at degrees of freedom, which lie on no side of a plane."""
    sensor = cg.SectionSensor("cut", section="sheet", plane=[[0.5, 0, 0], [1, 0, 0]])
    with pytest.raises(InputError, match="no elements whose nodes carry a force"):
        dropped(sheet(FINE), held(), sensors=[sensor])
