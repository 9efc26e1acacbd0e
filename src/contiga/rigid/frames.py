"""Points and directions between a body's axes and the world's."""

from __future__ import annotations

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.records import FloatArray
from contiga.rigid.kernels import rigid_nb
from contiga.rigid.pose import RIGID, as_pose
from contiga.rigid.transform import PoseLike

# Points below which a second thread does not pay.
POINTS = 32768


def standing(X: PoseLike, where: str = "pose") -> FloatArray:
    """`X` checked to be a rigid pose, a copy; see `as_pose`, which says what is wrong with others.

    Arrays are looked at by a kernel: four times as fast, and once in every step.
    """
    if type(X) is np.ndarray and X.shape == (4, 4) and X.dtype == np.float64:
        pose = X.copy()
        if rigid_nb.is_rigid(pose, RIGID):
            return pose
    return as_pose(X, where)


def to_body(X_WB: FloatArray, p_W: FloatArray, out: FloatArray | None = None) -> FloatArray:
    """(n, 3) points of the world in body axes, written into `out` (n, 3) where there is one."""
    out = np.empty(p_W.shape) if out is None else out
    run_ranges(rigid_nb.to_body, len(out), POINTS, locked(p_W), X_WB, out)
    return out


def to_world(X_WB: FloatArray, p_B: FloatArray) -> FloatArray:
    """(n, 3) points of the body in world axes."""
    return _to_world(X_WB, p_B, 1.0)


def turn_to_world(X_WB: FloatArray, n_B: FloatArray) -> FloatArray:
    """(n, 3) directions in body axes, in world axes."""
    return _to_world(X_WB, n_B, 0.0)


def _to_world(X_WB: FloatArray, p_B: FloatArray, shift: float) -> FloatArray:
    rows = locked(np.ascontiguousarray(p_B))  # what friction remembers is some columns of more
    out = np.empty(p_B.shape)
    run_ranges(rigid_nb.to_world, len(out), POINTS, rows, X_WB, shift, out)
    return out
