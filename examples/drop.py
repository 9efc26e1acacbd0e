"""A free body dropped on an elastic pad, and where its energy goes. No damping: it must come back.

python drop.py [headform.step]     a ball of 82.5 mm without a file

The body moves by the force of the contact, by the velocity Verlet method: twenty lines of any
explicit code. mm, g, ms: forces are in N, energies in mJ.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

import contiga as cg

MASS, SPEED = 4540.0, 6.7
RADIUS = 82.5


class Course(NamedTuple):
    """What a drop gives, one entry a step."""

    depth: np.ndarray
    force: np.ndarray
    kinetic: np.ndarray
    stored: np.ndarray

    @property
    def error(self) -> np.ndarray:
        """Change of kinetic and stored energy, relative to the energy at the start."""
        whole = self.kinetic + self.stored
        return whole / whole[0] - 1.0


def pad(mesh: float, half: float = 150.0) -> cg.Slave:
    """A plane pad of quadrilaterals with sides of `mesh`, its face at z = 0."""
    sheet = cg.shapes.plane(width=2.0 * half, length=2.0 * half)
    n = round(2.0 * half / mesh) + 1
    row = np.arange(n * n).reshape(n, n)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    return cg.Slave(cg.clouds.sample(sheet, n, n), quads.reshape(-1, 4), name="pad")


def drop(
    body: cg.Master, slave: cg.Slave, law: cg.StressLaw, step: float, **options: str
) -> Course:
    """Drop `body`, whose lowest point is at z = 0 in its own axes, until it is back above."""
    contact = cg.Contact(body, slave, law=law, **options)
    above, velocity = 0.5 * SPEED * step, -SPEED
    pose = cg.motion.pose.translation([0.0, 0.0, above])
    state = contact.start(slave.points, pose)
    rows, acceleration = [], 0.0
    while above <= 0.5 * SPEED * step or not rows:
        rows.append((-above, state.wrench[2], 0.5 * MASS * velocity**2, state.energy.stored))
        velocity += 0.5 * step * acceleration
        above += step * velocity
        pose = cg.motion.pose.translation([0.0, 0.0, above])
        state = contact.step(state, slave.points, pose, step)
        acceleration = state.wrench[2] / MASS
        velocity += 0.5 * step * acceleration
    rows.append((-above, state.wrench[2], 0.5 * MASS * velocity**2, state.energy.stored))
    return Course(*np.array(rows).T)


def main(file: str | None) -> None:
    """Drop it with two steps, print what becomes of the energy."""
    if file is None:
        body = cg.Body([cg.shapes.sphere(radius=RADIUS, centre=(0.0, 0.0, RADIUS))])
    else:
        body = cg.read_cad(file)
        low = body.bounds()[0]
        centre = body.bounds().mean(axis=0)
        body = body.transformed(cg.motion.pose.translation([-centre[0], -centre[1], -low[2]]))
    law = cg.StressLaw(2.0, thickness=60.0)
    for step in (0.02, 0.01):
        course = drop(body, pad(10.0), law, step)
        print(
            f"step {step} ms: {course.depth.max():.2f} mm deep, "
            f"{course.force.max() / 1000:.2f} kN, energy at the end "
            f"{100 * course.error[-1]:+.4f} %, at most {100 * np.abs(course.error).max():.4f} %"
        )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
