"""Hertz's contact: an exact rigid sphere on an elastic block, with elements of scikit-fem; mm, N.

The block is round and a thousand times as wide as the contact. Its model is plane, in r and z: a
node on top stands for a ring, whose area weighs its force.
"""

from typing import Any, NamedTuple

import numpy as np
import skfem
from scipy.sparse.linalg import spsolve
from skfem.helpers import grad

import contiga as cg

BALL, DEPTH, YOUNG, POISSON = 1000.0, 0.025, 10.0, 0.3
RADIUS = np.sqrt(BALL * DEPTH)
FORCE = 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * RADIUS * DEPTH


class Pressed(NamedTuple):
    """The contact at full depth, and the largest residual before each iteration, N."""

    state: cg.State
    residuals: list[float]


@skfem.BilinearForm
def stiffness(u: Any, v: Any, w: Any) -> Any:
    """Work of the strains rr, zz, u_r/r and 2 rz in a ring."""
    a, b = ([grad(f)[0, 0], grad(f)[1, 1], f[0] / w.x[0]] for f in (u, v))
    c, d = (grad(f)[0, 1] + grad(f)[1, 0] for f in (u, v))
    work = POISSON / (1.0 - 2.0 * POISSON) * sum(a) * sum(b) + 0.5 * c * d
    work = work + sum(p * q for p, q in zip(a, b, strict=True))
    return 2.0 * np.pi * w.x[0] * YOUNG / (1.0 + POISSON) * work


@skfem.LinearForm
def ring(v: Any, w: Any) -> Any:
    """Area that a node on top stands for."""
    return 2.0 * np.pi * w.x[0] * v


def press(n: int) -> Pressed:
    """Press the sphere into a block of n by n elements, which grow away from the contact."""
    ticks = 1e3 * RADIUS * np.sinh(np.linspace(0.0, 9.0, n + 1)) / np.sinh(9.0)
    mesh = skfem.MeshQuad.init_tensor(ticks, -ticks[::-1]).with_defaults()
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()))
    K, bottom, axis = stiffness.assemble(basis), basis.get_dofs("bottom"), basis.get_dofs("left")
    free = basis.complement_dofs(bottom.all(["u^2"]), axis.all(["u^1"]))
    area = ring.assemble(skfem.FacetBasis(mesh, skfem.ElementQuad1(), facets="top"))
    rest, move = np.zeros((mesh.nvertices, 3)), cg.motion.pose.translation
    rest[:, ::2] = mesh.p.T
    law = cg.PenaltyLaw(1e3 * YOUNG / RADIUS, per_area=True)
    contact = cg.Contact(
        cg.Body([cg.shapes.sphere(radius=BALL)]), cg.Slave(rest, area=area), law=law
    )
    start = contact.start(rest, move([0.0, 0.0, BALL]))
    u, residuals, plane = np.zeros(len(K.indptr) - 1), [], np.arange(rest.size).reshape(-1, 3)
    while len(residuals) < 20 and (not residuals or residuals[-1] > 1e-8 * FORCE):
        x = rest.copy()
        x[:, ::2] += u.reshape(-1, 2)
        state = contact.step(start, x, move([0.0, 0.0, BALL - DEPTH]))
        residual = (K @ u - state.force[:, ::2].ravel())[free]
        residuals.append(float(abs(residual).max()))
        tangent = K - contact.tangent(state)[plane[:, ::2].ravel()][:, plane[:, ::2].ravel()]
        u[free] -= spsolve(tangent[free][:, free], residual)
    return Pressed(state, residuals)


if __name__ == "__main__":
    for n in (32, 64, 128):
        state, residuals = press(n)
        print(f"{n}: {-state.total_force[2]:.4f} of {FORCE:.4f} N,", *residuals)
