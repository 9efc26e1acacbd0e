"""Shells of splines in a simulation: what they tell of their inside at the nodes of their slave."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import contiga as cg
from contiga.dynamics.nodes import ElementState
from contiga.matter.element_fields import at_nodes
from contiga.matter.iga import assemble_shell


def sheet() -> cg.Simulation:
    """A flat one that nothing holds."""
    flat = cg.shapes.plane(width=2.0, length=1.0).k_refined((1, 1), [0.5], [0.5])
    steel = cg.materials.Elastic(young=1000.0, poisson=0.25)
    shell = assemble_shell([flat], material=steel, density=1.0, thickness=0.1)
    slave = cg.Slave.of(shell, "sheet")
    motion = cg.motion.Deforming(material=shell, velocity=(1.0, 0.0, 0.0))
    return cg.Simulation(
        bodies={}, slaves={"sheet": (slave, motion)}, contacts=[], end=1e-3, step=1e-4
    )


def test_the_stress_of_a_stretched_sheet_is_the_same_at_all_nodes() -> None:
    """λ = 1.01 in x alone: S = E/(1 − ν²) (λ² − 1)/2, and σ = λ S by the thickness at rest."""
    simulation = sheet()
    slave = simulation.slaves["sheet"].slave
    inner = simulation.step(simulation.start()).slaves["sheet"].matter
    q = simulation.slaves["sheet"].motion.material.nodes * [1.01, 1.0, 1.0]
    stretched = ElementState.of(slave.points, slave.points, {"q": q, "memory": inner["memory"]})
    inside = simulation.mechanism.nodes["sheet"].inside(stretched)
    fields = at_nodes(inside, len(slave))
    along = 1000.0 / (1.0 - 0.25**2) * 0.5 * (1.01**2 - 1.0)
    np.testing.assert_allclose(fields.stress[:, 0], 1.01 * along, rtol=1e-9)
    np.testing.assert_allclose(fields.stress[:, 1], 0.25 * along / 1.01, rtol=1e-9)
    np.testing.assert_allclose(fields.strain[:, 0], 0.5 * (1.01**2 - 1.0), rtol=1e-9)
    np.testing.assert_allclose(
        fields.energy_density, 0.5 * along * 0.5 * (1.01**2 - 1.0), rtol=1e-9
    )


def test_a_run_writes_the_nodes_and_their_fields(tmp_path: Path) -> None:
    result = sheet().run(tmp_path / "out")
    nodes = result.state.slaves["sheet"].points
    np.testing.assert_allclose(
        nodes, sheet().slaves["sheet"].slave.points + np.array([1e-3, 0.0, 0.0]), atol=1e-12
    )
    assert (tmp_path / "out" / "fields.vtkhdf").stat().st_size > 0
