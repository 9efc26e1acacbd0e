"""A shell of splines that an exact cylinder presses: Newton's method with SciPy.

A quarter of a cylinder stands on its straight edges, which are clamped. A roller along its top
goes down 6 mm in steps of 0.25 mm, with friction. Control points are solved for: x = N q, so
that forces on nodes go back as Nᵀ f, and the stiffness of contact as Nᵀ K N. mm, N.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import kron
from scipy.sparse.linalg import splu

import contiga as cg
from contiga.matter.iga import Shell, Symmetry, assemble_shell

RADIUS, WIDTH, THICK, ROLLER = 50.0, 40.0, 2.0, 20.0
RUBBER = cg.materials.Elastic(young=50.0, poisson=0.4)
STIFFNESS = 5.0
FRICTION = cg.Coulomb(0.3)


class LoadStep(NamedTuple):
    """Control points, force on the roller, largest residual before each iteration, energy stored
    and rubbed off."""

    q: np.ndarray
    force: float
    residuals: list[float]
    energy: float


def arch(elements: tuple[int, int]) -> cg.NurbsSurface:
    """A quarter of a cylinder about y, its top at z = 0."""
    centre, turn = (0.0, -0.5 * WIDTH, -RADIUS), 0.25 * np.pi
    curve = cg.shapes.arc(radius=RADIUS, centre=centre, axis="y", start=-turn, end=turn)
    patch = cg.shapes.extruded(curve, (0.0, WIDTH, 0.0)).elevate(1, 2)
    across, along = (np.arange(1, n) / n for n in elements)
    (low, high), (first, last) = patch.domain
    return patch.insert_knots(low + (high - low) * across, first + (last - first) * along)


def press(
    elements: tuple[int, int] = (16, 8), down: float = 6.0, step: float = 0.25
) -> tuple[Shell, list[LoadStep]]:
    """Press the arch of so many elements; return its shell and the load steps."""
    clamps = [Symmetry("u0"), Symmetry("u1")]
    made = {"material": RUBBER, "density": 1e-3, "thickness": THICK}
    shell = assemble_shell([arch(elements)], **made, symmetry=clamps)
    slave = cg.Slave.of(shell)
    N = kron(shell.contact.rows.matrix(len(shell.mass)), np.eye(3)).tocsr()
    roller = cg.Body([cg.shapes.cylinder(radius=ROLLER, height=3.0 * WIDTH, axis="y")])
    law = cg.PenaltyLaw(STIFFNESS, per_area=True)
    contact = cg.Contact(roller, slave, law=law, friction=FRICTION, shell_thickness=THICK)
    free = np.ones((len(shell.mass), 3), bool)
    for edge in ("u0", "u1"):
        free[shell.net.edge(edge)] = False
    free, now, steps = free.ravel(), shell.start(), []
    top = ROLLER + 0.5 * THICK
    state = contact.start(slave.points, cg.motion.pose.translation([0.0, 0.0, top]))
    for depth in np.arange(step, down + 0.5 * step, step):
        pose, residuals = cg.motion.pose.translation([0.0, 0.0, top - depth]), []
        while len(residuals) < 20 and (not residuals or residuals[-1] > 1e-8):
            after = contact.step(state, shell.points(now.points), pose)
            inside = shell.forces(now, now.points, 0.0 * now.points, 0.0)
            residual = (inside.force + shell.spread(after.force)).ravel()[free]
            residuals.append(abs(residual).max())
            K = (shell.tangent(now) - N.T @ contact.tangent(after) @ N)[free][:, free]
            q = now.points.copy()
            q.ravel()[free] += splu(K.tocsc()).solve(residual)
            now = now._replace(points=q)
        state = after
        energy = inside.energy.strain + after.energy.stored + after.energy.friction
        steps.append(LoadStep(now.points, float(after.wrench[2]), residuals, energy))
    return shell, steps


if __name__ == "__main__":
    for one in press()[1]:
        print(round(one.force, 4), " ".join(f"{size:.0e}" for size in one.residuals))
