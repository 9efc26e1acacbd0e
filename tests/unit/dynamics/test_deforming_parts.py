"""Several materials in one slave: which elements are in which part, what the rest is made of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.errors import InputError
from contiga.matter import Part

FAR = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, -100.0))])
LOW = {"layer": ([0, 0, -1], 0.0)}


def _simulation(slave: cg.Slave, motion: cg.motion.Deforming) -> cg.Simulation:
    return cg.Simulation(
        bodies={"far": FAR}, slaves={"it": (slave, motion)}, contacts=[], end=1.0, step="auto"
    )


def _column() -> tuple[cg.Slave, np.ndarray]:
    """A column of four bricks, and which are the two upper ones."""
    slave = block((1, 1, 4), (1.0, 1.0, 4.0), kind="hexahedron")
    cells = np.asarray(slave.elements["hexahedron"])
    return slave, slave.points[cells][:, :, 2].mean(axis=1) > 2.0


def _part(elements: np.ndarray, young: float, **options: Any) -> Part:
    material = cg.materials.Elastic(young=young)
    return Part(**({"kind": "hex8", "elements": elements, "material": material} | options))


@pytest.mark.parametrize("rest", [True, False])
def test_a_column_of_two_materials_is_two_springs_in_series(rest: bool) -> None:
    slave, upper = _column()
    cells = np.asarray(slave.elements["hexahedron"])
    parts = [_part(cells[upper][:, [1, 2, 3, 0, 5, 6, 7, 4]], 4.0, density=2.0, name="upper")]
    if not rest:
        parts.append(_part(cells[~upper], 1.0, density=1.0, name="lower"))
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0) if rest else None,
        density=1.0 if rest else None,
        parts=parts,
        fixed=LOW,
        loads=cg.motion.NodalForce([0, 0, 1e-3], on={"layer": ([0, 0, 1], 0.0)}),
    )
    simulation = _simulation(slave, motion)
    way = simulation.settle().slaves["it"].points[:, 2] - slave.points[:, 2]
    heights = slave.points[:, 2]
    assert way[heights == 2.0].mean() == pytest.approx(2e-3, rel=0.01)
    assert way[heights == 4.0].mean() == pytest.approx(2.5e-3, rel=0.01)
    mass = simulation.mechanism.masses["it"]
    assert mass.sum() == pytest.approx(2.0 * 2.0 + 2.0 * 1.0)


def test_bars_are_parts_beside_the_elements_of_the_slave_and_slaves_alone() -> None:
    slave, _ = _column()
    tie = Part(
        kind="bar2",
        elements=np.array([[0, len(slave) - 1]]),
        material=cg.materials.Elastic(young=1.0),
        density=3.0,
        section=0.5,
    )
    material = cg.materials.Elastic(young=1.0)
    motion = cg.motion.Deforming(material=material, density=1.0, parts=[tie])
    length = np.linalg.norm(slave.points[-1] - slave.points[0])
    assert _simulation(slave, motion).mechanism.masses["it"].sum() == pytest.approx(
        4.0 + 3.0 * 0.5 * length
    )
    string = cg.Slave([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], elements={"line": [[0, 1], [1, 2]]})
    webbing = cg.materials.Belt(loading=10.0)
    belt = cg.motion.Deforming(material=webbing, density=1.0, section=0.5, fixed=[0, 2])
    assert _simulation(string, belt).mechanism.masses["it"].tolist() == [0.25, 0.5, 0.25]


def test_what_does_not_fit_is_refused() -> None:
    slave, upper = _column()
    cells = np.asarray(slave.elements["hexahedron"])
    one = _part(cells[upper], 1.0, density=1.0, name="one")
    other = _part(cells, 1.0, density=1.0, name="other")
    beyond = _part(cells + 8, 1.0, density=1.0, name="beyond")
    for options, text in (
        ({"parts": [one]}, "in no part, and made of nothing.*2 hex8"),
        ({"parts": [one, other]}, "element 2 of other is in one, too"),
        ({"parts": [beyond]}, "beyond.*points that the slave does not have"),
        ({}, "must be a material"),
        ({"parts": [1]}, "must be a part"),
        ({"parts": [one], "bulk_viscosity": (1.0,)}, "two numbers"),
    ):
        with pytest.raises(InputError, match=text):
            _simulation(slave, cg.motion.Deforming(**options))


def test_bulk_viscosity_takes_energy_and_membranes_have_none() -> None:
    slave, _ = _column()
    velocity = np.zeros((len(slave), 3))
    velocity[slave.points[:, 2] == 4.0, 2] = -0.1
    lost = []
    for viscosity in ((0.0, 0.0), (0.1, 1.5)):
        motion = cg.motion.Deforming(
            material=cg.materials.Elastic(young=1.0),
            density=1.0,
            velocity=velocity,
            bulk_viscosity=viscosity,
        )
        history = _simulation(slave, motion).run().history
        lost.append(history["energy.viscosity"][-1] / history["energy.total"][0])
    assert lost[0] == 0.0
    assert lost[1] > 0.01
    sheet = cg.Slave([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    soft = cg.materials.Elastic(young=1.0)
    thin = cg.motion.Deforming(material=soft, density=1.0, thickness=0.1, bulk_viscosity=(0.1, 1.5))
    assert _simulation(sheet, thin).start().time == 0.0
