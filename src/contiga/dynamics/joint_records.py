"""Arrays of joints for kernels: markers on bodies, constraint rows, and work arrays."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray

IntRows = NDArray[np.int32]

# Kinds of constraint rows, with the point difference d = p₂ − p₁ and the axes a, b of the markers.
OFFSET_W = 0
"""d · e_i = 0, world axes."""
OFFSET_A = 1
"""d · a_i = 0."""
AXES = 2
"""a_i · b_j = 0."""

# Kinds of coordinates.
ANGLE = 0
"""Angle of b₁ from a₁ about a₃."""
SECOND_ANGLE = 1
"""Rotation of the second body about b₁, zero where b₃ is a₃."""
TRAVEL = 2
"""Translation d · a₃."""
CONE = 3
"""Angle between a₃ and b₃."""
TWIST = 4
"""Rotation about a₃ that remains when b₃ is rotated to a₃ the shortest way."""


@pass_by_pointer
class JointTable(NamedTuple):
    """Constants of g joints with m constraint rows and c coordinates."""

    bodies: IntRows
    """(g, 2) numbers of the bodies; −1 for the ground."""
    rows: IntRows
    """(g, 2) rows of free bodies; −1 for driven bodies and the ground."""
    points_B: FloatArray
    """(g, 2, 3) points of the markers, length, body axes; world axes on the ground."""
    axes_B: FloatArray
    """(g, 2, 3, 3) axes of the markers, one a row, body axes; world axes on the ground."""
    constraints: IntRows
    """(m, 4) joint, kind, i, j; the rows of a joint are consecutive."""
    first: IntRows
    """(m,) envelope: first column of each row of the matrix and of its factor that may not be
    zero."""
    full: IntRows
    """(m,) envelope of a full matrix: zeros."""
    couples: IntRows
    """(p, 6) i0, i1, side, j0, j1, side: constraint rows i0 … i1 and j0 … j1, j0 ≤ i0, that share
    a free body, each with its side of the joint."""
    coordinates: IntRows
    """(c, 2) joint, kind."""
    size: FloatArray
    """(1,) size of the mechanism, length, which scales misfits of points."""


@pass_by_pointer
class JointWork(NamedTuple):
    """Work arrays of kernels; no content outlives a call."""

    points: FloatArray
    """(g, 2, 3) points of the markers, world coordinates."""
    arms: FloatArray
    """(g, 2, 3) from the centre of mass of a free body to its marker; zero for other bodies."""
    axes: FloatArray
    """(g, 2, 3, 3) axes of the markers, one a row, world axes."""
    rates: FloatArray
    """(g, 2, 6) velocity of each marker's point, and its spin."""
    accelerations: FloatArray
    """(g, 2, 6) acceleration of each marker's point, and its angular acceleration."""
    inverse: FloatArray
    """(b, 3, 3) inverse inertia tensors of the free bodies, world axes."""
    jacobian: FloatArray
    """(m, 2, 6) G: derivative of each row by the velocity of the centre and the spin of the two
    bodies."""
    weighted: FloatArray
    """(m, 2, 6) M⁻¹ Gᵀ, transposed."""
    matrix: FloatArray
    """(m, m) G M⁻¹ Gᵀ, scaled to a diagonal of ones; then its Cholesky factor L."""
    gram: FloatArray
    """(m, m) Lᵀ L where rows depend on others; then its Cholesky factor."""
    scale: FloatArray
    """(m,) factors that scale rows and columns of the matrix."""
    right: FloatArray
    """(m,) residuals of the rows."""
    multipliers: FloatArray
    """(m,) Lagrange multipliers."""
    shift: FloatArray
    """(b, 6) impulse on each free body, or its displacement, by the multipliers."""


class _WorkBySize(threading.local):
    """Work arrays that a thread keeps from one call to the next, by their sizes (g, m, b)."""

    def __init__(self) -> None:
        self.by_size: dict[tuple[int, int, int], JointWork] = {}


_work = _WorkBySize()


def work_for(table: JointTable, b: int) -> JointWork:
    """Return work arrays for the joints of `b` free bodies, valid until this thread's next call.

    They are kept for each thread and size, and hold whatever the last call left in them.
    """
    g, m = len(table.bodies), len(table.constraints)
    if (work := _work.by_size.get((g, m, b))) is not None:
        return work
    work = _work.by_size[g, m, b] = JointWork(
        np.empty((g, 2, 3)),
        np.empty((g, 2, 3)),
        np.empty((g, 2, 3, 3)),
        np.empty((g, 2, 6)),
        np.empty((g, 2, 6)),
        np.empty((b, 3, 3)),
        np.empty((m, 2, 6)),
        np.empty((m, 2, 6)),
        np.empty((m, m)),
        np.empty((m, m)),
        np.empty(m),
        np.empty(m),
        np.empty(m),
        np.empty((b, 6)),
    )
    return work
