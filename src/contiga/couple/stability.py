"""Compute rates for the critical step of contacts between bodies of a MuJoCo model."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.arrays.ordered import product
from contiga.contact.state import State
from contiga.records import FloatArray
from contiga.simulation.critical import Rates


def rates_of(
    model: Any, data: Any, state: State, point: FloatArray, bodies: tuple[int, int]
) -> Rates:
    """Return the rates of the vibration of two bodies on a contact, with all bodies joined to them.

    The springs of the contact form a stiffness K (6, 6) for relative motions at `point` (3,), world
    axes. The mobility J M⁻¹ Jᵀ, with the relative Jacobian J and the inertia M of the joints, is
    the relative acceleration by unit forces. The largest eigenvalue of their product is ω² of the
    whole system; with the viscosities in place of the springs it is the decay. Both are zero
    without points in contact, or without joints.
    """
    kept = state.kept
    rows, axial = kept.springs
    if len(rows) == 0 or model.nv == 0:
        return Rates()
    arms, normals = state.held_W.points.at(rows) - point, state.held_W.normals.at(rows)
    lateral = np.zeros(len(rows)) if kept.tangential is None else kept.tangential.at(rows)
    mobility = _mobility(model, data, point, bodies)
    square = _largest_eigenvalue(mobility, _stiffness_matrix(arms, normals, axial, lateral))
    decay = 0.0
    if kept.viscosity is not None and kept.viscosity.values.any():
        none = np.zeros(len(rows))
        decay = _largest_eigenvalue(
            mobility, _stiffness_matrix(arms, normals, kept.viscosity.at(rows), none)
        )
    return Rates(square, decay)


def _stiffness_matrix(
    arms: FloatArray, normals: FloatArray, axial: FloatArray, lateral: FloatArray
) -> FloatArray:
    """Return the stiffness (6, 6) for small displacements and rotations, of springs at points.

    `axial` (n,) acts along the `normals` (n, 3), `lateral` (n,) across them; `arms` (n, 3) are
    the points relative to the reference point.
    """
    total = _stiffness_along(arms, normals, axial - lateral)
    if lateral.any():
        for axis in np.eye(3):
            total += _stiffness_along(arms, np.broadcast_to(axis, arms.shape), lateral)
    return total


def _stiffness_along(arms: FloatArray, directions: FloatArray, stiffness: FloatArray) -> FloatArray:
    wrenches = np.concatenate((directions, np.cross(arms, directions)), axis=1)
    return product((stiffness[:, None] * wrenches).T, wrenches)


def _mobility(model: Any, data: Any, point: FloatArray, bodies: tuple[int, int]) -> FloatArray:
    """Return the relative acceleration (6, 6) of two bodies at `point` by unit wrenches on both."""
    import mujoco

    relative = np.zeros((6, model.nv))
    for sign, body in zip((-1.0, 1.0), bodies, strict=True):
        jacobian = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], point, body)
        relative += sign * jacobian
    solved = np.zeros_like(relative)
    mujoco.mj_solveM(model, data, solved, relative)
    return product(relative, solved.T)


def _largest_eigenvalue(mobility: FloatArray, stiffness: FloatArray) -> float:
    """Return the largest eigenvalue of the product, at least 0: below is rounding."""
    return max(0.0, float(np.linalg.eigvals(product(mobility, stiffness)).real.max()))
