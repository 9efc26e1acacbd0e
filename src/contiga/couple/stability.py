"""The critical step of contacts between bodies of a MuJoCo model."""

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
    """Return how fast a contact makes its two bodies vibrate, with all that hangs on them.

    The springs of the contact are a stiffness K (6, 6) of the way that one body goes against the
    other at `point` (3,), world axes; J M⁻¹ Jᵀ says how far unit forces there drive them apart, J
    their relative Jacobian and M the inertia of the joints. The largest eigenvalue of the product
    is that of the whole system.
    """
    kept = state.kept
    rows, along = kept.springs
    if len(rows) == 0 or model.nv == 0:
        return Rates()
    arms, normals = state.held_W.points.at(rows) - point, state.held_W.normals.at(rows)
    across = np.zeros(len(rows)) if kept.tangential is None else kept.tangential.at(rows)
    mobility = _mobility(model, data, point, bodies)
    square = _largest(mobility, _springs(arms, normals, along, across))
    decay = 0.0
    if kept.viscosity is not None and kept.viscosity.values.any():
        none = np.zeros(len(rows))
        decay = _largest(mobility, _springs(arms, normals, kept.viscosity.at(rows), none))
    return Rates(square, decay)


def _springs(
    arms: FloatArray, normals: FloatArray, along: FloatArray, across: FloatArray
) -> FloatArray:
    """Return force and moment (6, 6) over a small way and turn, of springs along and across."""
    total = _added(arms, normals, along - across)
    if across.any():
        for axis in np.eye(3):
            total += _added(arms, np.broadcast_to(axis, arms.shape), across)
    return total


def _added(arms: FloatArray, ways: FloatArray, stiffness: FloatArray) -> FloatArray:
    felt = np.concatenate((ways, np.cross(arms, ways)), axis=1)
    return product((stiffness[:, None] * felt).T, felt)


def _mobility(model: Any, data: Any, point: FloatArray, bodies: tuple[int, int]) -> FloatArray:
    """Return the acceleration (6, 6) of the second body against the first by a wrench between."""
    import mujoco

    relative = np.zeros((6, model.nv))
    for sign, body in zip((-1.0, 1.0), bodies, strict=True):
        jacobian = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], point, body)
        relative += sign * jacobian
    solved = np.zeros_like(relative)
    mujoco.mj_solveM(model, data, solved, relative)
    return product(relative, solved.T)


def _largest(mobility: FloatArray, stiffness: FloatArray) -> float:
    """The largest eigenvalue of the product, which has none below zero."""
    return max(0.0, float(np.linalg.eigvals(product(mobility, stiffness)).real.max()))
