"""A linear elastic solid and Newton's method on it in contact: an implicit code to test by."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import spsolve

import contiga as cg

_CORNERS = np.array(
    [
        [-1, -1, -1],
        [1, -1, -1],
        [1, 1, -1],
        [-1, 1, -1],
        [-1, -1, 1],
        [1, -1, 1],
        [1, 1, 1],
        [-1, 1, 1],
    ]
)


def stiffness(points: np.ndarray, cells: np.ndarray, young: float, poisson: float) -> csr_array:
    """(3 n, 3 n) of trilinear hexahedra (e, 8), by eight points of Gauss."""
    shear, bulk = 0.5 * young / (1 + poisson), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    moduli = np.zeros((6, 6))
    moduli[:3, :3] = bulk
    moduli += np.diag([2 * shear] * 3 + [shear] * 3)
    whole = np.zeros((len(cells), 24, 24))
    for gauss in _CORNERS / np.sqrt(3.0):
        q = 1.0 + _CORNERS * gauss
        slopes = (
            _CORNERS * np.stack([q[:, 1] * q[:, 2], q[:, 0] * q[:, 2], q[:, 0] * q[:, 1]], 1) / 8
        )
        jacobian = np.einsum("ni,enj->eij", slopes, points[cells])
        grad = np.einsum("ni,eji->enj", slopes, np.linalg.inv(jacobian))
        strain = np.zeros((len(cells), 6, 24))
        for k in range(3):
            strain[:, k, k::3] = grad[:, :, k]
        for row, (i, j) in enumerate(((0, 1), (1, 2), (2, 0)), 3):
            strain[:, row, i::3], strain[:, row, j::3] = grad[:, :, j], grad[:, :, i]
        volume = np.linalg.det(jacobian)[:, None, None]
        whole += volume * (np.swapaxes(strain, 1, 2) @ moduli @ strain)
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel()
    size = 3 * len(points)
    return csr_array(coo_array((whole.ravel(), (rows, columns)), shape=(size, size)))


class Solved(NamedTuple):
    """Equilibrium at the end of a load step."""

    state: cg.State
    points: np.ndarray
    residuals: list[float]
    """The largest force out of balance, at each iterate."""


def solved(
    contact: cg.Contact,
    inner: Callable[[np.ndarray], tuple[np.ndarray, csr_array]],
    free: np.ndarray,
    start: tuple[cg.State, np.ndarray],
    pose: np.ndarray,
    most: int = 20,
) -> Solved:
    """Newton's method, full steps: `inner` are forces (3 n,) and stiffness at points (n, 3), `free`
    are the unknowns."""
    state, points = start
    residuals: list[float] = []
    for _ in range(most):
        trial = contact.step(state, points, pose=pose, dt=0.0)
        forces, elastic = inner(points)
        out_of_balance = (trial.force.ravel() - forces)[free]
        residuals.append(float(np.abs(out_of_balance).max()))
        if residuals[-1] <= 1e-9 * np.abs(trial.force).max(initial=1e-9):
            return Solved(trial, points, residuals)
        matrix = (elastic - contact.tangent(trial))[free][:, free]
        points = points.copy()
        points.ravel()[free] += spsolve(matrix.tocsc(), out_of_balance)
    raise AssertionError(f"no equilibrium: {residuals}")
