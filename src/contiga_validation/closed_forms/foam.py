"""Foam: the energy returned by a cycle, and the compression of a block by a plate."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.matter import CORNERS, GROUP
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import ROTATIONS, floor, run_of
from contiga_validation.engine.arrays import FloatArray, IntArray

CASES = Cases(GROUP)

HYSTERESIS, SHAPE = 0.2, 4.0
"""Parameters `hysteresis` H and `shape` S of the foam's unloading."""


def _cycled(step: float) -> dict[str, FloatArray]:
    """Return the history of a cube of foam of 1000 mm³ that is compressed by 40 % and released."""
    motion = cg.motion.Deforming(
        material=cg.materials.Foam(
            loading=np.array([[0.0, 0.0], [0.9, 0.9]]), hysteresis=HYSTERESIS, shape=SHAPE
        ),
        density=1e-3,
        fixed={"layer": ([0, 0, -1], 0.0)},
        driven={
            "layer": ([0, 0, 1], 0.0),
            "motion": cg.motion.Translate(np.array([[0, 0, 0, 0], [1, 0, 0, -4.0], [2, 0, 0, 0]])),
        },
    )
    cube = cg.Slave(
        10.0 * np.array(CORNERS),
        [[0, 3, 2, 1], [4, 5, 6, 7]],
        elements={"hexahedron": [list(range(8))]},
    )
    return run_of(slaves={"cube": (cube, motion)}, end=2.0, step=step).history


@CASES.add(
    "matter-foam",
    "A cycle of foam",
    "share that comes back: H + (1 − H)/(S + 1)",
    "One hexahedron of a linear loading curve, pressed by 40 % and let go by what drives its "
    "upper nodes.",
)
def _cycle() -> Answer:
    share = HYSTERESIS + (1.0 - HYSTERESIS) / (SHAPE + 1.0)

    def returned(step: float) -> float:
        work = _cycled(step)["energy.external"]
        return float((work.max() - work[-1]) / work.max())

    history = _cycled(0.005)
    work = history["energy.external"]
    checks = (
        relative("energy given", work.max(), 0.5 * 0.4**2 * 1000.0),
        relative("share that comes back", returned(0.0025), share),
        relative("share that is lost", history["energy.hysteresis"][-1] / work.max(), 1.0 - share),
        zero("strain energy left, by that given", history["energy.strain"][-1] / work.max(),
             1e-12),
    )  # fmt: skip
    time = history["time"]
    down = 0.04 * np.minimum(time, 2.0 - time) / 0.1
    loading = 0.5 * down**2 * 1000.0
    returned_work = share * 80.0
    exact = [
        ("given, then what comes back of it", np.array([0.0, 2.0]), np.array([80.0, 80.0])),
        (
            "at the end",
            np.array([0.0, 2.0]),
            np.array([80.0 - returned_work, 80.0 - returned_work]),
        ),
    ]
    draw = comparison(
        ("t", "energy"),
        [*exact, ("½ E ε² V", time[time <= 1.0], loading[time <= 1.0])],
        [("work of what drives it", time, work)],
    )
    order = order_of("share that comes back", 0.02, lambda step: abs(returned(step) - share))
    return Answer(checks, draw, order)


LOADING = np.array([[0.0, 0.0], [0.05, 0.3], [0.635, 0.82]])
"""Loading curve of the README's foam, MPa over strain."""
SIDES, MASS, SPEED = (100.0, 100.0, 60.0), 4540.0, 6.7
"""Sides of the block, mm; mass and speed of the plate, g and mm/ms."""
COUNTS = (3, 3, 2)
LIGHT, STIFF = 2e-6, 5.0
"""Density of the block, which has 1.2 g, and stiffness of the contact, MPa/mm."""


def bricks(lines: tuple[FloatArray, FloatArray, FloatArray]) -> tuple[FloatArray, IntArray]:
    """Return points (n, 3) and hexahedra (m, 8) of a grid with planes at given x, y and z.

    Points and elements are in the order of x, then y, then z.
    """
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    nx, ny, nz = (len(line) - 1 for line in lines)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corners = [number[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in CORNERS]
    return points, np.stack(corners, axis=1)


def _hit_block() -> tuple[dict[str, FloatArray], FloatArray]:
    """Return the history of a plate that hits a block of foam from below, and displacements (k,).

    These are the mean displacements along z of the block's lower nodes, mm, at each step.
    """
    x, y, z = (np.linspace(0.0, side, n + 1) for side, n in zip(SIDES, COUNTS, strict=True))
    points, elements = bricks((x - 0.5 * SIDES[0], y - 0.5 * SIDES[1], z))
    sides = elements[:, [0, 3, 2, 1]]
    facets = sides[(points[sides, 2] == 0.0).all(axis=1)]
    block = cg.Slave(points + np.array([0.0, 0.0, 1e-6]), facets, elements={"hexahedron": elements})
    motion = cg.motion.Deforming(
        material=cg.materials.Foam(loading=LOADING),
        density=LIGHT,
        bulk_viscosity=(0.06, 0.0),
        fixed={"layer": ([0, 0, 1], 0.0)},
    )
    plate = floor(2.0 * SIDES[0])
    thrown = cg.motion.Free(
        MASS, inertia=1e7 * np.eye(3), velocity=[0.0, 0.0, SPEED], hold=("x", "y", *ROTATIONS)
    )
    result = run_of(
        bodies={"plate": (plate, thrown)},
        slaves={"block": (block, motion)},
        contacts=[cg.Contact(plate, block, law=cg.PenaltyLaw(STIFF, per_area=True))],
        end=6.2,
        step="auto",
        keep=1,
    )
    lower = np.unique(facets)
    displacements = [state.slaves["block"].points[lower, 2].mean() for state in result.states]
    return result.history, np.array(displacements)


@CASES.add(
    "matter-pad",
    "A plate of 4.54 kg on a block of foam",
    "½ m v² = V ∫₀^ε σ dε,  F = A σ(ε)",
    "The foam of the README's pad as 18 hexahedra, 100 × 100 × 60 mm, without Poisson's ratio "
    "and as good as massless. Of the energy 0.4 % is in the contact, which presses in by "
    "0.12 mm, and 0.2 % is taken by the bulk viscosity that keeps light nodes from ringing.",
)
def _plate() -> Answer:
    def stress(strain: FloatArray | float) -> FloatArray:
        return np.interp(strain, LOADING[:, 0], LOADING[:, 1])

    def absorbed(strain: float) -> float:
        """Return the energy over volume up to a strain: areas of trapezia under the curve."""
        line = np.union1d([0.0, strain], LOADING[LOADING[:, 0] < strain, 0])
        y = stress(line)
        return float((0.5 * (y[1:] + y[:-1]) * np.diff(line)).sum())

    area = SIDES[0] * SIDES[1]
    energy_density = 0.5 * MASS * SPEED**2 / (area * SIDES[2])
    strain = float(brentq(lambda x: absorbed(x) - energy_density, 0.0, 0.63))
    history, displacements = _hit_block()
    energy = history["energy.total"][0]
    checks = (
        relative("largest strain", displacements.max() / SIDES[2], strain, 6e-3),
        relative("way of the block's lower side", displacements.max(), strain * SIDES[2], 6e-3),
        relative("largest force", history["force"].max(), area * float(stress(strain)), 4e-3),
        zero("energy balance error, by the energy",
             np.abs(history["energy.error"]).max() / energy, 1e-3),
        zero("hourglass energy, by the energy", history["energy.hourglass"].max() / energy, 1e-5),
    )  # fmt: skip
    x = np.linspace(0.0, strain, 100)
    draw = comparison(
        ("way", "force"),
        [("curve", SIDES[2] * x, area * stress(x))],
        [
            (
                "run",
                displacements[: displacements.argmax()],
                history["force"][: displacements.argmax()],
            )
        ],
    )
    return Answer(checks, draw)
