"""What rests, is stacked or strikes takes about as many steps of "auto" as of one that is fixed."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.scenes import box, square_sheet

import contiga as cg
from contiga.simulation.critical import limit_of

Free, Attached = cg.motion.Free, cg.motion.Attached
G = 9.81e-3
"""Of gravity; mm, kg, ms."""
STEEL = 7.8e-6
GRIP = {"law": cg.PenaltyLaw(1e-3, per_area=True, damping=1e-3), "friction": cg.Coulomb(0.4)}
HEAD = cg.ForceLaw([[0, 0], [10, 3], [60, 5], [90, 12]], unloading=[[0, 0], [60, 0.5], [90, 3]],
                   hysteresis_slope=2.0)  # fmt: skip


def skin(body: cg.Body, size: float) -> cg.Slave:
    """A sampled surface."""
    mesh = body.tessellate(0.01 * body.size, size=size)
    return cg.Slave(mesh.vertices, mesh.triangles)


def stack(heights: int, tilt: float, end: float) -> cg.Simulation:
    """Blocks of 40 × 40 × 20 a little above a table and each other; gravity tilted by degrees."""
    blocks = {
        f"b{k}": box((-20.0, -20.0, 20.0 * k + 0.01), (20.0, 20.0, 20.0 * k + 20.0))
        for k in range(heights)
    }
    table = box((-60.0, -60.0, -10.0), (60.0, 60.0, 0.0))
    points, quads = square_sheet(39.0, 3)
    slaves = {
        name: cg.Slave(points + np.array([0.0, 0.0, 20.0 * k + 0.01]), quads)
        for k, name in enumerate(blocks)
    }
    masters = [table, *blocks.values()]
    down = np.array([np.sin(np.deg2rad(tilt)), 0.0, -np.cos(np.deg2rad(tilt))])
    return cg.Simulation(
        bodies={"table": table}
        | {name: (body, Free(body.mass_properties(STEEL))) for name, body in blocks.items()},
        slaves={f"s{name}": (slave, Attached(name)) for name, slave in slaves.items()},
        contacts=[
            cg.Contact(master, slave, **GRIP)
            for master, slave in zip(masters, slaves.values(), strict=False)
        ],
        end=end,
        step="auto",
        gravity=G * down,
    )


def bonnet() -> cg.Body:
    """A sheet with a crown, its free side up."""
    x, y = np.meshgrid([-300.0, 0.0, 300.0], [-400.0, 0.0, 400.0], indexing="ij")
    z = -60.0 * (x / 300.0) ** 2 - 80.0 * (y / 400.0) ** 2
    knots = [0, 0, 0, 1, 1, 1]
    return cg.Body([cg.NurbsSurface((2, 2), (knots, knots), np.stack([x, y, z], axis=-1))])


def head_on_bonnet() -> cg.Simulation:
    """A headform that strikes a sheet obliquely with a soft skin by the default of its law."""
    head = cg.Body([cg.shapes.sphere(radius=82.5, centre=(0.0, 0.0, 83.0))])
    motion = Free(head.mass_properties(4.5 / 2.352e6), velocity=[4.7, 0.0, -10.07])
    contact = cg.Contact(bonnet(), skin(head, 12.0), law=HEAD, friction=cg.Coulomb(0.3))
    return cg.Simulation(
        bodies={"bonnet": contact.master, "head": (head, motion)},
        slaves={"skin": (contact.slave, Attached("head"))},
        contacts=[contact],
        end=20.0,
        step="auto",
    )


def head_on_pad() -> cg.Simulation:
    """The same headform with the points on the other side."""
    head = cg.Body([cg.shapes.sphere(radius=82.5, centre=(0.0, 0.0, 84.0))])
    motion = Free(head.mass_properties(4.5 / 2.352e6), velocity=[4.7, 0.0, -10.07])
    pad = cg.Slave(*square_sheet(400.0, 41))
    contact = cg.Contact(head, pad, law=HEAD, friction=cg.Coulomb(0.3))
    return cg.Simulation(
        bodies={"head": (head, motion)}, slaves={"pad": pad}, contacts=[contact], end=20.0,
        step="auto",
    )  # fmt: skip


REST, STACK = "a block at rest on 20 degrees", "a stack of three"
BONNET, PAD = "a head on a bonnet", "a head on a pad"
SCENES = {
    REST: lambda: stack(1, 20.0, 100.0 if FULL else 70.0),
    STACK: lambda: stack(3, 0.0, 40.0),
    BONNET: head_on_bonnet,
    PAD: head_on_pad,
}


@pytest.mark.parametrize("name", [REST, PAD, *full(STACK, BONNET)])
def test_steps_are_as_many_as_fixed_ones_and_keep_the_energy(name: str) -> None:
    """Fixed ones: 0.9 of the least critical step, no longer than the longest "auto" may take."""
    simulation = SCENES[name]()
    result = simulation.run(keep=1)
    critical = min(limit_of(simulation, state).critical for state in result.states)
    fixed = min(0.9 * critical, simulation.stepping.most)
    count = len(result.history["time"]) - 1
    assert count <= 1.3 * simulation.stepping.end / fixed
    assert result.summary["energy"]["relative"] < 1e-3
