"""Whole steps of what deforms: beside Kratos', beside internal forces alone, with gas beside forces
and contact; memory an element.

`python -m benchmarks matter_steps`. Goals are ratios, measured in one run and in turns: what else
the machine does falls on both sides alike.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from time import process_time
from typing import Any

import numpy as np

import contiga as cg
from benchmarks.matter import (
    PAD,
    RUBBER,
    SIDE,
    STEEL,
    bent,
    corners,
    cube,
    membrane,
    nodes_of,
    sheet,
    solid,
)
from benchmarks.timing import in_turns, means_in_turns, on_threads
from contiga.dynamics.deforming_nodes import MAX_INTERVAL, DeformingNodes
from contiga.gas import Chamber, IdealGas, Inflator, Surroundings, Vent
from contiga.matter import Assembled, MatterState

ROUNDS = 9
SHEET, BLOCK = 71, 46  # 2 · 71² = 10,082 triangles, 46³ = 97,336 hexahedra
BAG = 24  # 12 · 24² = 6,912 triangles
TIMES_KRATOS, TIMES_FORCES, TIMES_BOTH, BYTES = 8.0, 3.0, 1.5, 1000.0
"""Goals: a step of Kratos' takes at least so many of ours, a step with contact at most so many
times its internal forces, one with gas at most so many times these and its contact, and an element
at most so many bytes."""
TENTH = np.sqrt(0.1 / np.pi)
"""Radius of the tenth of a unit square."""
STEP = 1e-6
VARIABLES = (
    "DISPLACEMENT VELOCITY ACCELERATION REACTION VOLUME_ACCELERATION FORCE_RESIDUAL "
    "RESIDUAL_VECTOR NODAL_MASS"
)
OF_SCHEME = "MIDDLE_VELOCITY FRACTIONAL_ACCELERATION NODAL_DISPLACEMENT_STIFFNESS"
"""What Kratos keeps at nodes."""
PACKAGES = "KratosMultiphysics", "KratosStructuralMechanicsApplication"


def _verdict(reached: bool) -> str:
    return " (goal reached)" if reached else " (goal missed)"


def run(
    side: int = SIDE, sheet_side: int = SHEET, block_side: int = BLOCK, bag_side: int = BAG
) -> list[str]:
    """The lines of the table."""
    return [
        *beside_forces(sheet_side, block_side),
        *beside_forces_and_contact(bag_side),
        *memory(side),
        *beside_kratos(side),
    ]


def beside_forces(sheet_side: int, block_side: int) -> list[str]:
    """Whole steps of what moves, with their part of the row sums, beside their forces alone."""
    q, cells = nodes_of(block_side), corners(block_side)
    block = cg.Slave(q, elements={"hexahedron": cells})
    bodies, membrane_of, contacts = _touching(sheet_side)
    scenes = {
        f"{2 * sheet_side**2} tri3": Stepped(bodies, membrane_of, contacts, 2e-4),
        f"{len(cells)} hex8 of rubber": Stepped({}, (block, _moving(RUBBER, q)), [], 1e-3),
        f"{len(cells)} hex8 of foam": Stepped({}, (block, _moving(PAD, q)), [], 5e-4),
    }
    lines = []
    for name, stepped in scenes.items():
        forces = OfStep(stepped)
        with on_threads(1):
            for k in range(MAX_INTERVAL):  # until row sums are taken as often as in a run
                stepped(k)
            step, alone = means_in_turns((stepped, forces), 2 * MAX_INTERVAL, process_time)
        touching = stepped.state.n_contact / len(stepped.state.slaves["it"].points)
        lines.append(
            f"{name}, {touching:.0%} of the nodes in contact: a whole step takes "
            f"{1e3 * step:.2f} ms, {step / alone:.2f} times its forces"
            f"{_verdict(step <= TIMES_FORCES * alone)}"
        )
    return lines


def _touching(side: int) -> tuple[Any, Any, Any]:
    """A membrane with a ball on a tenth of it."""
    nodes, triangles = sheet(side)
    ball = cg.Body([cg.shapes.sphere(radius=2.0, centre=(0.5, 0.5, _height(2.0)))])
    slave = cg.Slave(nodes, triangles)
    speeds = 1e-3 * np.random.default_rng(0).normal(size=nodes.shape)
    motion = cg.motion.Deforming(material=STEEL, density=1.0, thickness=0.1, velocity=speeds)
    law = cg.PenaltyLaw(1.0, per_area=True)
    return {"ball": ball}, (slave, motion), [cg.Contact(ball, slave, law=law, search="penetration")]


def beside_forces_and_contact(side: int) -> list[str]:
    """A step of a bag that a ball has come into, beside its internal forces and its contact."""
    points, facets = _round_bag(side)
    head = cg.Body([cg.shapes.sphere(radius=0.3, centre=(0.0, 0.0, 0.77))])
    cloth = cg.materials.Elastic(young=380e6, poisson=0.3, compression=False)
    motion = cg.motion.Deforming(material=cloth, density=800.0, thickness=3.5e-4)
    slave = motion.with_masses(cg.Slave(0.5 * points, facets))
    law = cg.PenaltyLaw(1e7, per_area=True, damping_ratio=0.5)
    friction = cg.Coulomb(0.3)
    contact = cg.Contact(
        head, slave, law=law, friction=friction, quadrature=3, search="penetration"
    )
    whole = head.mass_properties(4.54 / head.mass_properties(1.0).mass)
    falls = cg.motion.Free(whole, velocity=(0.0, 0.0, -20.0))
    air = Surroundings(101_325.0, 293.15, IdealGas(1.4, 287.05))
    inflator = Inflator(20.0, 600.0)
    bag = Chamber("it", air, inflators=[inflator], vents=[Vent(8e-4), Vent(8e-4)], leak=1e-4)
    stepped = Stepped({"head": (head, falls)}, (slave, motion), [contact], 2e-6, gas=[bag])
    works = stepped, OfStep(stepped), OfContact(stepped, contact)
    with on_threads(1):
        for k in range(MAX_INTERVAL):
            stepped(k)
        step, forces, touching = means_in_turns(works, 4 * MAX_INTERVAL, process_time)
    ratio = step / (forces + touching)
    state = next(iter(stepped.state.contacts.values()))
    return [
        f"bag of {len(facets)} tri3, {state.n_contact} of {len(state.status)} points in contact: a "
        f"whole step takes {1e3 * step:.2f} ms, {ratio:.2f} times its forces, {1e3 * forces:.2f}, "
        f"and its contact, {1e3 * touching:.2f}{_verdict(ratio <= TIMES_BOTH)}"
    ]


def _round_bag(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (12 side², 3) of a sphere of radius 1, normals outward: a cube
    of sheets that are welded and blown up."""
    flat, triangles = sheet(side)
    up = 2.0 * flat - [1.0, 1.0, -1.0]
    down = up[:, [1, 0, 2]] * [1.0, 1.0, -1.0]
    sides = [way[:, order] for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]) for way in (up, down)]
    every, place = np.unique(np.round(np.concatenate(sides), 9), axis=0, return_inverse=True)
    facets = np.concatenate([triangles + k * len(flat) for k in range(6)])
    return every / np.linalg.norm(every, axis=1)[:, None], place.ravel()[facets]


def _moving(material: Any, nodes: np.ndarray) -> cg.motion.Deforming:
    """A motion whose elements strain by some per cent."""
    return cg.motion.Deforming(
        material=material, density=1.0, velocity=10.0 * (bent(nodes) - nodes)
    )


def _height(radius: float) -> float:
    """Of a ball's centre whose lowest part below z = 0 has a tenth of the unit square."""
    return float(np.sqrt(radius**2 - TENTH**2))


class Stepped:
    """A work that goes on with a simulation of one slave by a step; its state has two behind it."""

    def __init__(
        self, bodies: Any, slave: Any, contacts: Any, step: float = STEP, gas: Any = ()
    ) -> None:
        self.simulation = cg.Simulation(
            bodies=bodies, slaves={"it": slave}, contacts=contacts, gas=gas, end=1.0, step=step
        )
        self.before = self.simulation.step(self.simulation.start())
        self.state = self.simulation.step(self.before)

    def __call__(self, _: int) -> None:
        self.before, self.state = self.state, self.simulation.step(self.state)


class OfStep:
    """A work that asks for the forces of the step that was last."""

    def __init__(self, stepped: Stepped) -> None:
        self.stepped = stepped
        nodes = stepped.simulation.mechanism.nodes["it"]
        assert isinstance(nodes, DeformingNodes)
        self.matter = nodes.matter

    def __call__(self, _: int) -> None:
        before, now = (state.slaves["it"] for state in (self.stepped.before, self.stepped.state))
        state = MatterState(before.points, before.matter["memory"])
        self.matter.forces(state, now.points, now.velocities, self.stepped.state.step)


class OfContact:
    """A work that asks a contact with its only body for the step that was last."""

    def __init__(self, stepped: Stepped, contact: cg.Contact) -> None:
        self.stepped, self.contact = stepped, contact

    def __call__(self, _: int) -> None:
        before, now = self.stepped.before, self.stepped.state
        (last,) = before.contacts.values()
        (body,), (slave,) = now.bodies.values(), now.slaves.values()
        speeds = {"velocity": slave.velocities, "twist": tuple(body.twist)}
        self.contact.step(last, slave.points, body.pose, now.step, **speeds)


def memory(side: int) -> list[str]:
    """What elements take with all their tables and a state."""
    lines = []
    for name, make in (
        ("tet4 neo-Hooke", lambda: solid("tet4", *cube(side), RUBBER)),
        ("tri3 elastic", lambda: membrane(*sheet(8 * side), STEEL)),
    ):
        tracemalloc.start()
        matter: Assembled = make()
        answer = matter.forces(matter.start(), matter.nodes, np.zeros_like(matter.nodes), 0.0)
        taken = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        each = taken / sum(len(group.elements) for group in matter.groups)
        assert len(answer.force) == len(matter.nodes)
        lines.append(
            f"{name}: {each:.0f} bytes an element, nodes included{_verdict(each <= BYTES)}"
        )
    return lines


def beside_kratos(side: int) -> list[str]:
    """An explicit step of the same tetrahedra on one thread of Kratos'."""
    if find_spec("KratosMultiphysics") is None:
        return [f"beside Kratos: not measured: pip install {' '.join(PACKAGES)}"]
    nodes, elements = cube(side)
    slave = cg.Slave(bent(nodes), elements={"tetra": elements})
    motion = cg.motion.Deforming(material=STEEL, density=1.0, rest=nodes)
    ours, (theirs, forces) = Stepped({}, (slave, motion), []), kratos(nodes, elements)
    expected = ours.simulation.start().slaves["it"].matter["force"]
    theirs(0)
    difference = np.abs(forces() - expected).max() / np.abs(expected).max()
    with on_threads(1):
        times = in_turns({"ours": ours, "theirs": theirs}, ROUNDS, process_time)
    ratio = times["theirs"] / times["ours"]
    return [
        f"Kratos' explicit step of {len(elements)} tetrahedra takes {ratio:.1f} times a whole step "
        f"here, each on one thread{_verdict(ratio >= TIMES_KRATOS)}; after it forces differ by "
        f"{difference:.0e} of the largest"
    ]


def kratos(
    nodes: np.ndarray, elements: np.ndarray
) -> tuple[Callable[[int], None], Callable[[], np.ndarray]]:
    """Central differences on total Lagrangian tetrahedra, and forces (n, 3) of the last step."""
    km = import_module("KratosMultiphysics")
    mechanics = import_module("KratosMultiphysics.StructuralMechanicsApplication")

    km.Logger.GetDefaultOutput().SetSeverity(km.Logger.Severity.WARNING)
    km.ParallelUtilities.SetNumThreads(1)
    model = km.Model()
    part = model.CreateModelPart("it", 2)
    for room, names in ((km, VARIABLES), (mechanics, OF_SCHEME)):
        for name in names.split():
            part.AddNodalSolutionStepVariable(getattr(room, name))
    part.ProcessInfo[km.DOMAIN_SIZE] = 3
    steel = part.CreateNewProperties(1)
    steel[km.DENSITY], steel[km.YOUNG_MODULUS] = 1.0, STEEL.young
    steel[km.POISSON_RATIO] = STEEL.poisson
    steel[km.CONSTITUTIVE_LAW] = mechanics.LinearElastic3DLaw()
    for k, place in enumerate(nodes.tolist()):
        part.CreateNewNode(k + 1, *place)
    for k, four in enumerate((elements + 1).tolist()):
        part.CreateNewElement("TotalLagrangianElement3D4N", k + 1, four, steel)
    for axis in "XYZ":
        ways = (getattr(km, f"{what}_{axis}") for what in ("DISPLACEMENT", "REACTION"))
        km.VariableUtils().AddDof(*ways, part)
    for node, way in zip(part.Nodes, (bent(nodes) - nodes).tolist(), strict=True):
        node.SetSolutionStepValue(km.DISPLACEMENT, 0, way)
        node.SetSolutionStepValue(km.DISPLACEMENT, 1, way)
        node.X, node.Y, node.Z = node.X0 + way[0], node.Y0 + way[1], node.Z0 + way[2]
    scheme = mechanics.ExplicitCentralDifferencesScheme(STEP, 0.9, 0.0)
    strategy = mechanics.MechanicalExplicitStrategy(part, scheme, False, False, True)
    strategy.Initialize()

    def step(_: int, kept: Any = model) -> None:
        part.CloneTimeStep(part.ProcessInfo[km.TIME] + STEP)
        strategy.InitializeSolutionStep()
        strategy.Predict()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()

    def forces() -> np.ndarray:
        return np.array([[*node.GetSolutionStepValue(km.FORCE_RESIDUAL)] for node in part.Nodes])

    return step, forces
