"""Joints as kernels take them: markers on bodies, rows of constraints, and work arrays."""

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
"""Turn of b₁ about a₃, from a₁."""
SECOND_ANGLE = 1
"""Turn of the second body about b₁, from where b₃ is a₃."""
TRAVEL = 2
"""d · a₃."""
CONE = 3
"""Angle between a₃ and b₃."""
TWIST = 4
"""Turn about a₃ that is left when b₃ is turned back to a₃ the shortest way."""


@pass_by_pointer
class JointTable(NamedTuple):
    """What never changes of g joints, m constraint rows and c coordinates."""

    bodies: IntRows
    """(g, 2) numbers of the bodies; −1 for the ground."""
    rows: IntRows
    """(g, 2) rows of free bodies; −1 where forces move nothing."""
    points_B: FloatArray
    """(g, 2, 3) the markers' points, axes of the bodies."""
    axes_B: FloatArray
    """(g, 2, 3, 3) the markers' axes, one a row, axes of the bodies."""
    constraints: IntRows
    """(m, 4) joint, kind, i, j; those of a joint stand together."""
    first: IntRows
    """(m,) first row that each one is coupled with, by bodies or in the factor: its envelope."""
    full: IntRows
    """(m,) the same of a full matrix."""
    couples: IntRows
    """(p, 6) rows i0 to i1 at their side of a free body, and rows j0 to j1 at theirs, j0 ≤ i0."""
    coordinates: IntRows
    """(c, 2) joint, kind."""
    size: FloatArray
    """(1,) length that misfits of points are measured by."""


@pass_by_pointer
class JointWork(NamedTuple):
    """Arrays that kernels work in; nothing of them outlives a call."""

    points: FloatArray
    """(g, 2, 3) the markers' points, world."""
    arms: FloatArray
    """(g, 2, 3) from the centres of mass of free bodies to them; zero of others."""
    axes: FloatArray
    """(g, 2, 3, 3) the markers' axes, one a row, world axes."""
    rates: FloatArray
    """(g, 2, 6) velocity of each marker's point, and its spin."""
    accelerations: FloatArray
    """(g, 2, 6) acceleration of each marker's point, and its angular acceleration."""
    inverse: FloatArray
    """(b, 3, 3) spin by angular momentum, world axes."""
    jacobian: FloatArray
    """(m, 2, 6) derivative of each row by velocity of the centre and spin of both bodies."""
    weighted: FloatArray
    """(m, 2, 6) the same over the masses."""
    matrix: FloatArray
    """(m, m) G M⁻¹ Gᵀ, scaled to a diagonal of ones; then its factor."""
    gram: FloatArray
    """(m, m) Lᵀ L of that factor, where rows depend on others; then its own."""
    scale: FloatArray
    """(m,) of rows and columns of the matrix."""
    right: FloatArray
    """(m,) residuals of the rows."""
    multipliers: FloatArray
    """(m,)."""
    shift: FloatArray
    """(b, 6) what multipliers move each free body by."""


class _Kept(threading.local):
    """Work arrays that a thread keeps from one call to the next, by their sizes."""

    def __init__(self) -> None:
        self.by_size: dict[tuple[int, int, int], JointWork] = {}


_kept = _Kept()


def work_for(table: JointTable, b: int) -> JointWork:
    """Return work arrays for the joints between `b` free bodies and others, the thread's until it
    asks for the next."""
    g, m = len(table.bodies), len(table.constraints)
    if (work := _kept.by_size.get((g, m, b))) is not None:
        return work
    work = _kept.by_size[g, m, b] = JointWork(
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
