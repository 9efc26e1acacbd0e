"""Slaves that deform against exact bodies: a bar on a wall, at rest and carried along."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, relative, zero
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import History, run_of
from contiga_validation.engine.arrays import FloatArray

GROUP = "Slaves that deform"
CASES = Cases(GROUP)
YOUNG, DENSITY, LENGTH, SPEED = 210e9, 7850.0, 1.0, 1.0
"""Steel bar, in m, kg and s: modulus, density, length, impact speed."""
CELLS = 60
CELERITY = math.sqrt(YOUNG / DENSITY)
WAVE = DENSITY * CELERITY * SPEED
"""Stress of the wave, Pa."""
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
"""Corners of a hexahedron of sides 1, in the order of its nodes."""
_LOWER, _UPPER = (0, 3, 2, 1), (4, 5, 6, 7)


def column(cells: int, length: float) -> cg.Slave:
    """Return a bar of hexahedra along z from 0, with square sections and facets at both ends."""
    side = length / cells
    heights = np.linspace(0.0, length, cells + 1)
    corners = side * np.array(CORNERS[:4], np.float64)
    points = np.concatenate([corners + np.array([0.0, 0.0, z]) for z in heights])
    elements = np.arange(8) + 4 * np.arange(cells)[:, None]
    ends = [elements[0, list(_LOWER)], elements[-1, list(_UPPER)]]
    return cg.Slave(points, ends, elements={"hexahedron": elements}, name="bar")


def _bar_on_wall(carried: float = 0.0) -> dict[str, FloatArray]:
    """Return the history of the bar that hits a wall; both move along x at the speed `carried`."""
    bar, side = column(CELLS, LENGTH), LENGTH / CELLS
    wall = cg.Body([cg.shapes.plane(width=1.0, length=1.0)])
    end = 2.4 * LENGTH / CELERITY
    wall_motion = cg.motion.Translate([[0.0, 0.0, 0.0, 0.0], [end, carried * end, 0.0, 0.0]])
    steel = cg.materials.Elastic(young=YOUNG, poisson=0.0)
    motion = cg.motion.Deforming(material=steel, density=DENSITY, velocity=[carried, 0.0, -SPEED])
    law = cg.PenaltyLaw(2.0 * YOUNG / side, per_area=True)
    contact = cg.Contact(wall, bar, law=law, quadrature=1)
    return run_of(
        bodies={"wall": (wall, wall_motion)},
        slaves={"bar": (bar, motion)},
        contacts=[contact],
        end=end,
        step=0.4 * side / CELERITY,
    ).history


@CASES.add(
    "matter-bar",
    "A bar of steel hits a wall",
    "σ = ρ c v,  t = 2 L / c,  c = √(E/ρ)",
    f"{CELLS} hexahedra of ν = 0, L = 1 m, at 1 m/s on an exact plane; contact by a penalty of "
    "twice the stiffness of an element. Elements round off the ends of the pulse.",
)
def _bar() -> Answer:
    history = _bar_on_wall()
    time, stress = history["time"], history["force"] * (CELLS / LENGTH) ** 2
    leave_time = 2.0 * LENGTH / CELERITY
    plateau = (time > 0.15 * leave_time) & (time < 0.85 * leave_time)
    energy = history["energy.total"][0]
    checks = (
        relative("stress on the wall", stress[plateau].mean(), WAVE, 0.01),
        relative("time until it leaves, at half the stress", time[stress > 0.5 * WAVE][-1],
                 leave_time, 0.025),
        zero("energy balance error, by the energy",
             np.abs(history["energy.error"]).max() / energy, 1e-3),
    )  # fmt: skip
    exact = (
        np.array([0.0, 0.0, leave_time, leave_time, 1.2 * leave_time]),
        WAVE * np.array([0.0, 1, 1, 0, 0]),
    )
    draw = comparison(("t", "stress"), [("formula", *exact)], [("run", time, stress)])
    return Answer(checks, draw)


def carried_along(at_rest: History, carried: History, sizes: Mapping[str, float]) -> Answer:
    """Compare columns of the histories of a scene at rest and of the same scene carried along.

    `sizes` gives the columns and the size by which the difference of each is divided; 1e-9 of it is
    allowed.
    """
    checks = tuple(
        zero(
            f"{name}, largest difference by its size",
            float(np.abs(carried[name] - at_rest[name]).max() / size),
            1e-9,
        )
        for name, size in sizes.items()
    )
    time = at_rest["time"]
    draw = comparison(
        ("t", "force"),
        [("at rest", time, at_rest["force"])],
        [("carried along", time, carried["force"])],
    )
    return Answer(checks, draw)


@CASES.add(
    "matter-carried",
    "The same scene, carried along",
    "F(t), U(t) as at rest",
    "Wall and bar move along at 64 m/s, as many times faster than they meet: forces and "
    "energies are the same but for rounding, which is 1e-10 of a penetration of 2 µm.",
)
def _carried() -> Answer:
    at_rest, carried = _bar_on_wall(), _bar_on_wall(64.0)
    energy = at_rest["energy.total"][0]
    sizes = {"force": at_rest["force"].max(), "energy.strain": energy, "energy.contact": energy}
    return carried_along(at_rest, carried, sizes)
