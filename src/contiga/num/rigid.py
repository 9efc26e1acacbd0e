"""Points and directions between a body's axes and the world's."""

from __future__ import annotations

from contiga.num.kernels import rigid_nb
from contiga.records import FloatArray


def to_body(X_WB: FloatArray, p_W: FloatArray) -> FloatArray:
    """(n, 3) points of the world in body axes."""
    result: FloatArray = rigid_nb.to_body(p_W, X_WB)
    return result


def to_world(X_WB: FloatArray, p_B: FloatArray) -> FloatArray:
    """(n, 3) points of the body in world axes."""
    result: FloatArray = rigid_nb.to_world(p_B, X_WB, 1.0)
    return result


def turn_to_world(X_WB: FloatArray, n_B: FloatArray) -> FloatArray:
    """(n, 3) directions in body axes, in world axes."""
    result: FloatArray = rigid_nb.to_world(n_B, X_WB, 0.0)
    return result
