"""A rubber membrane that an exact cylinder presses and irons: Newton's method in plain NumPy.

The roller goes down 10 mm, then along 20 mm, in steps of 1 mm, without friction. The membrane is of
triangles of St. Venant-Kirchhoff's material; its ends are held 10 % apart, its sides in y. mm, N.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import spsolve

import contiga as cg

WIDTH, LENGTH, RADIUS, STRETCH = 120.0, 60.0, 25.0, 1.1
YOUNG, POISSON, THICK, STIFFNESS = 2.0, 0.4, 1.0, 0.1


class LoadStep(NamedTuple):
    """Places of the nodes, force on the roller, largest residual before each iteration."""

    x: np.ndarray
    wrench: np.ndarray
    residuals: list[float]


class Membrane:
    """Triangles that resist strain in their plane, and no bending."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray) -> None:
        sides = points[triangles[:, 1:], :2] - points[triangles[:, :1], :2]
        self.triangles, self.volume = triangles, 0.5 * THICK * np.linalg.det(sides)
        self.gradient = np.linalg.inv(sides) @ [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]
        modulus = [[1, POISSON, 0], [POISSON, 1, 0], [0, 0, 0.5 - 0.5 * POISSON]]
        self.elastic = YOUNG / (1.0 - POISSON**2) * np.array(modulus)
        self.rows = (3 * triangles[:, :, None] + np.arange(3)).reshape(-1, 9)

    def respond(self, x: np.ndarray) -> tuple[np.ndarray, csr_array]:
        """Internal forces (3 n,) and their derivative (3 n, 3 n)."""
        G, F = self.gradient, self.gradient @ x[self.triangles]  # F transposed, (m, 2, 3)
        E = 0.5 * (F @ F.transpose(0, 2, 1) - np.eye(2))
        stress = np.stack([E[:, 0, 0], E[:, 1, 1], 2.0 * E[:, 0, 1]], axis=1) @ self.elastic
        a = np.einsum("mia,mjk->mijak", G, F).reshape(-1, 2, 2, 9)
        B = np.stack([a[:, 0, 0], a[:, 1, 1], a[:, 0, 1] + a[:, 1, 0]], axis=1)  # dE/dx
        S = stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
        K = np.kron(G.transpose(0, 2, 1) @ S @ G, np.eye(3)[None])
        K = (K + B.transpose(0, 2, 1) @ self.elastic @ B) * self.volume[:, None, None]
        force = np.einsum("m,msr,ms->mr", self.volume, B, stress)
        i, j = np.repeat(self.rows, 9, axis=1), np.tile(self.rows, 9)
        matrix = coo_array((K.ravel(), (i.ravel(), j.ravel())), shape=(x.size, x.size)).tocsr()
        return np.bincount(self.rows.ravel(), force.ravel(), x.size), matrix


def iron(size: float = 6.0, down: int = 10, along: int = 20) -> list[LoadStep]:
    """Press and iron a membrane of triangles with sides of `size`."""
    mesh = cg.Body([cg.shapes.plane(width=WIDTH, length=LENGTH)]).tessellate(1.0, size=size)
    rest, membrane = mesh.vertices, Membrane(mesh.vertices, mesh.triangles)
    roller = cg.Body([cg.shapes.cylinder(radius=RADIUS, height=2.0 * LENGTH, axis="y")])
    slave, law = cg.Slave(rest, mesh.triangles), cg.PenaltyLaw(STIFFNESS, per_area=True)
    contact = cg.Contact(roller, slave, law=law, shell_thickness=THICK)
    inner = abs(rest[:, :2]) < [0.499 * WIDTH, 0.499 * LENGTH]
    free = np.stack([inner[:, 0], inner.all(axis=1), inner[:, 0]], axis=1).ravel()
    move = cg.motion.pose.translation
    x, top, steps = rest * [STRETCH, 1.0, 1.0], RADIUS + 0.5 * THICK, []
    state = contact.start(x, move([0.0, 0.0, top]))
    for k in range(1, down + along + 1):
        pose, residuals = move([max(0, k - down), 0.0, top - min(k, down)]), []
        while len(residuals) < 20 and (not residuals or residuals[-1] > 1e-9):
            after, (force, K) = contact.step(state, x, pose), membrane.respond(x)
            residual = (force - after.force.ravel())[free]
            residuals.append(abs(residual).max())
            x.ravel()[free] -= spsolve((K - contact.tangent(after))[free][:, free], residual)
        state = after
        steps.append(LoadStep(x.copy(), state.wrench, residuals))
    return steps


if __name__ == "__main__":
    for step in iron():
        print(step.wrench[[0, 2]].round(3), " ".join(f"{size:.0e}" for size in step.residuals))
