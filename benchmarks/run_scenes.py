"""The scenes of the benchmark of whole runs: every example, and made ones of many nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import contiga as cg
from benchmarks.scene import NIST, around
from benchmarks.stepping import ball, stress_law
from contiga.errors import InputError
from contiga.simulation.model import OutputOptions

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
COUNTS = (1_000, 10_000, 100_000)
STEPS = 60
"""Of a made scene."""
OUTPUT = OutputOptions(every=4, formats=("csv", "vtkhdf"), report=False)


class RunScene(NamedTuple):
    """What is run."""

    name: str
    make: Callable[[], cg.Simulation]
    most: int | None = None
    """Steps after which it ends; None at its own end."""


def scenes(counts: tuple[int, ...], most: int | None) -> Iterator[RunScene]:
    """All whose files are there; examples end after `most` steps."""
    for file in sorted(EXAMPLES.rglob("*.toml")):
        if "out" not in file.parent.name and _is_case(file):
            yield RunScene(file.stem, lambda file=file: cg.build(cg.load_case(file)), most)
    makes = {"sphere": sphere, "sheet": sheet} | ({"NIST's part": part} if NIST.is_file() else {})
    for name, make in makes.items():
        for n in counts:
            yield RunScene(f"{name}, {n:,} nodes", lambda make=make, n=n: make(n), STEPS)


def _is_case(file: Path) -> bool:
    """Whether a file is a case whose files are there."""
    try:
        cg.load_case(file)
    except InputError:
        return False
    return True


def _grid(n: int, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and quadrilaterals of a square sheet at z = 0, about n of them."""
    side = round(n**0.5)
    row = np.arange(side * side).reshape(side, side)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    plane = cg.shapes.plane(width=width, length=width)
    return cg.clouds.sample(plane, side, side), quads.reshape(-1, 4)


def sphere(n: int) -> cg.Simulation:
    """A free ball of radius 1 that falls on a square of width 4 and comes as deep as 0.05."""
    nodes, quads = _grid(n, 4.0)
    pad = cg.Slave(nodes, quads, thickness=np.full(len(nodes), 0.5))
    free = cg.motion.Free(
        mass=1.0, inertia=0.4 * np.eye(3), centre=(0, 0, 1.001), velocity=(0, 0, -0.06)
    )
    body = ball().translated((0.0, 0.0, 1.001))
    contacts = [cg.Contact(body, pad, law=stress_law(), friction=cg.Coulomb(static=0.4))]
    return _simulation({"ball": (body, free)}, {"pad": pad}, contacts, step=1.0 / STEPS)


def sheet(n: int) -> cg.Simulation:
    """A sheet of cloth that falls on a ball, as a bag does on a head."""
    nodes, quads = _grid(n, 4.0)
    cloth = cg.Slave(nodes + np.array([0.0, 0.0, 1.001]), quads[:, ::-1])
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0, poisson=0.3),
        density=1.0,
        thickness=0.01,
        velocity=(0, 0, -1.0),
    )
    contacts = [cg.Contact(ball(), cloth, law=cg.PenaltyLaw(1.0))]
    return _simulation({"ball": ball()}, {"cloth": (cloth, motion)}, contacts, step="auto")


def part(n: int) -> cg.Simulation:
    """Points around NIST's part, of which a tenth go in within a step and then slide on."""
    body = cg.read_cad(NIST)
    outside, inside = around(body, n, 0.1)
    motion = _Sliding(outside, inside, 1e-4 * body.size)
    cloud = cg.Slave(outside, thickness=np.full(n, 0.1 * body.size))
    contacts = [cg.Contact(body, cloud, law=stress_law(), area=cg.NodalArea(1.0))]
    slaves = {"cloud": (cloud, motion)}
    return _simulation({"part": body}, slaves, contacts, step=1.0, end=float(STEPS))


class _Sliding:
    """Points from outside to inside in the first time, then along x by `way` a time."""

    span = (0.0, float(STEPS))

    def __init__(self, outside: np.ndarray, inside: np.ndarray, way: float) -> None:
        self._ends, self._way = (outside, inside), np.array([way, 0.0, 0.0])

    def points(self, t: float) -> np.ndarray:
        outside, inside = self._ends
        return outside + min(t, 1.0) * (inside - outside) + max(t - 1.0, 0.0) * self._way

    def velocities(self, t: float) -> np.ndarray:
        outside, inside = self._ends
        return inside - outside if t < 1.0 else np.broadcast_to(self._way, outside.shape).copy()


def _simulation(
    bodies: dict[str, Any],
    slaves: dict[str, Any],
    contacts: list[cg.Contact],
    step: float | str,
    end: float = 1.0,
) -> cg.Simulation:
    return cg.Simulation(
        bodies=bodies, slaves=slaves, contacts=contacts, end=end, step=step, output=OUTPUT
    )
