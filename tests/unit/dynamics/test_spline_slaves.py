"""Slaves of splines that deform: where they are held, what they are made of, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.dynamics.places import nodes_at
from contiga.errors import InputError
from contiga.matter.iga import assemble_shell

STEEL = cg.materials.Elastic(young=1000.0, poisson=0.0)
MADE = {"material": STEEL, "density": 1.0, "thickness": 0.1}


def strip(elements: int = 8) -> cg.Slave:
    """One of length 4 and width 1."""
    inner = np.arange(1, elements) / elements
    flat = cg.shapes.plane(width=4.0, length=1.0)
    return cg.Slave(surfaces=flat.k_refined((1, 1), inner, []), name="strip")


def run(slave: cg.Slave, end: float = 1e-3, **given: Any) -> cg.SystemState:
    motion = cg.motion.Deforming(**(MADE | given))
    return (
        cg.Simulation(
            bodies={}, slaves={"strip": (slave, motion)}, contacts=[], end=end, step="auto"
        )
        .run()
        .state
    )


def test_an_edge_a_curve_and_a_plane_are_the_same_nodes() -> None:
    slave = strip()
    line = cg.shapes.line((-2.0, -0.5, 0.0), (-2.0, 0.5, 0.0))
    edge = nodes_at("edge", "u0", slave, "fixed")
    assert edge.sum() == 4
    for key, value in (("edge", ("u0", 0)), ("curve", line), ("plane", [[-2, 0, 0], [1, 0, 0]])):
        np.testing.assert_array_equal(nodes_at(key, value, slave, "fixed"), edge)


@pytest.mark.parametrize("place", [{"edge": "u0"}, {"box": [[-2, -1, -1], [-2, 1, 1]]}])
def test_what_is_held_stays_and_the_rest_goes(place: dict[str, Any]) -> None:
    slave = strip()
    state = run(slave, fixed=place, velocity=(0.0, 0.0, 1.0)).slaves["strip"]
    edge = slave.surfaces.edge("u0")
    np.testing.assert_array_equal(state.points[edge], slave.points[edge])
    far = slave.points[:, 0] > 0.0
    np.testing.assert_allclose(state.points[far, 2], 1e-3, rtol=1e-6)


def test_a_clamp_bends_as_a_cantilever() -> None:
    """Tip under a load along its edge: P L³ / (3 E I), held against turning or not at all."""
    slave = strip(4)
    load = 1e-2
    tip = {"edge": "u1"}
    motion = cg.motion.Deforming(
        **(MADE | {"thickness": 0.5}),
        fixed={"edge": "u0", "slope": True},
        loads=cg.motion.NodalForce([0.0, 0.0, load], on=tip),
        damping=1.0,
    )
    simulation = cg.Simulation(
        bodies={},
        slaves={"strip": (slave, motion)},
        contacts=[],
        end=1.0,
        step="auto",
        settling=True,
    )
    state = simulation.settle()
    deep = state.slaves["strip"].points[slave.surfaces.edge("u1"), 2].mean()
    assert deep == pytest.approx(load * 4.0**3 / (3.0 * 1000.0 * 0.5**3 / 12.0), rel=0.03)


def test_it_is_the_shell_that_assemble_shell_makes() -> None:
    slave = strip()
    shell = assemble_shell([*slave.surfaces.patches], **MADE)
    other = cg.Slave.of(shell, "strip")
    speed = {"velocity": (0.0, 0.0, 1.0), "fixed": [0, 5]}
    one = run(slave, **speed).slaves["strip"]
    motion = cg.motion.Deforming(material=shell, **speed)
    simulation = cg.Simulation(
        bodies={}, slaves={"strip": (other, motion)}, contacts=[], end=1e-3, step="auto"
    )
    np.testing.assert_array_equal(simulation.run().state.slaves["strip"].points, one.points)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"fixed": {"edge": "u2"}}, "which edge of which patch"),
        ({"fixed": {"edge": ("u0", 1)}}, "which edge of which patch"),
        ({"fixed": {"curve": 3}}, "must be a NurbsCurve"),
        ({"fixed": {"box": [[-2, 0, 0], [-1, 0.3, 0]], "slope": True}}, "no edge of a patch"),
        (
            {"material": cg.materials.Foam(loading=[[0, 0], [0.5, 1], [0.9, 9]])},
            "no material of sh",
        ),
        ({"rest": np.zeros((100, 3))}, "rest must have one row a slave point"),
        ({"masses": {"mass": 1.0}}, "masses: is for elements of a mesh"),
        ({"mass_scaling": 1.0}, "mass_scaling: is for elements of a mesh"),
        ({"thickness": None}, "thickness: is missing"),
        ({"density": None}, "density: is missing"),
    ],
)
def test_what_does_not_fit_is_told(given: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        run(strip(), **given)


def test_meshes_have_no_edges_and_no_slopes() -> None:
    mesh = cg.Slave([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="strip")
    with pytest.raises(InputError, match="only a slave of splines has edges"):
        run(mesh, fixed={"edge": "u0"})


def test_with_several_patches_an_edge_needs_the_number_of_its_patch() -> None:
    flat = cg.shapes.plane(width=4.0, length=1.0).k_refined((1, 1), [], [])
    slave = cg.Slave(surfaces=[flat, flat.translated([4.0, 0.0, 0.0])], name="strip")
    with pytest.raises(InputError, match="which edge of which patch"):
        nodes_at("edge", "u0", slave, "fixed")
    chosen = nodes_at("edge", ("u1", 0), slave, "fixed")
    np.testing.assert_array_equal(chosen, nodes_at("edge", ("u0", 1), slave, "fixed"))
