"""Stiffness of the contacts of a body, and its fastest vibration."""

from __future__ import annotations

import math

import numpy as np

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.dynamics.kernels.rigid_body_nb import direction
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.rigid.rigid_lanes import (
    AXES,
    CENTRE,
    FREE_DIRECTIONS,
    FREE_ROTATIONS,
    MASS,
    MOMENTS,
    TURN,
)

MAX_SWEEPS = 30
ROUNDING = 1e-15


@inner(error_model="numpy")
def _largest_eigenvalue(a):
    """Return the largest eigenvalue of a symmetric matrix, at least 0; overwrites the matrix.

    Jacobi's sweeps end when the off-diagonal norm is `ROUNDING` of the diagonal's, or after
    `MAX_SWEEPS`.
    """
    n = a.shape[0]
    for _ in range(MAX_SWEEPS):
        off_diagonal, diagonal = 0.0, 0.0
        for i in range(n):
            diagonal += a[i, i] * a[i, i]
            for j in range(i):
                off_diagonal += a[i, j] * a[i, j]
        if off_diagonal <= ROUNDING * ROUNDING * diagonal:
            break
        for i in range(n):
            for j in range(i):
                if a[i, j] == 0.0:
                    continue
                half = 0.5 * (a[j, j] - a[i, i]) / a[i, j]
                t = 1.0 / (abs(half) + math.sqrt(half * half + 1.0))
                if half < 0.0:
                    t = -t
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                for k in range(n):
                    x, y = a[k, i], a[k, j]
                    a[k, i], a[k, j] = c * x - s * y, s * x + c * y
                for k in range(n):
                    x, y = a[i, k], a[j, k]
                    a[i, k], a[j, k] = c * x - s * y, s * x + c * y
    largest = 0.0
    for i in range(n):
        largest = max(largest, a[i, i])
    return largest


@inner(error_model="numpy")
def _mass_weighted(constants, axes, d, arm, y):
    """Write the mass-weighted six components of a direction `d` at `arm` from the centre into `y`.

    `axes` are principal axes over the roots of their moments. Held directions and rotations do not
    count.
    """
    root = math.sqrt(constants[MASS])
    x0 = (arm[1] * d[2] - arm[2] * d[1]) * constants[FREE_ROTATIONS]
    x1 = (arm[2] * d[0] - arm[0] * d[2]) * constants[FREE_ROTATIONS + 1]
    x2 = (arm[0] * d[1] - arm[1] * d[0]) * constants[FREE_ROTATIONS + 2]
    for k in range(3):
        y[k] = d[k] * constants[FREE_DIRECTIONS + k] / root
        y[3 + k] = axes[k, 0] * x0 + axes[k, 1] * x1 + axes[k, 2] * x2


@inner(error_model="numpy")
def _add_outer(matrix, y, weight):
    """Add weight y yᵀ to a matrix (6, 6)."""
    for i in range(6):
        for j in range(6):
            matrix[i, j] += weight * y[i] * y[j]


@kernel(error_model="numpy")
def fastest(points, normals, along, across, row, constants):
    """Return ω² of the fastest vibration of a body on springs, the largest eigenvalue of M⁻¹ K.

    At each of the `points` (k, 3) there is a spring of stiffness `along` (k,) the direction in
    `normals` (k, 3) and `across` (k,) at right angles to it. With damping coefficients in place of
    stiffnesses it is the fastest decay rate. With held rotations it is an upper bound.
    """
    matrix, axes = np.zeros((6, 6)), scratch(3, 3)
    y, d, arm = scratch(6), scratch(3), scratch(3)
    q = row[TURN : TURN + 4]
    for k in range(3):
        a = direction(q, constants[AXES + k], constants[AXES + 3 + k], constants[AXES + 6 + k])
        for j in range(3):
            axes[k, j] = a[j] / math.sqrt(constants[MOMENTS + k])
    for i in range(points.shape[0]):
        for j in range(3):
            arm[j] = points[i, j] - row[CENTRE + j]
        for k in range(3):
            d[:] = 0.0
            d[k] = 1.0
            if across[i] != 0.0:
                _mass_weighted(constants, axes, d, arm, y)
                _add_outer(matrix, y, across[i])
        for k in range(3):
            d[k] = normals[i, k]
        _mass_weighted(constants, axes, d, arm, y)
        _add_outer(matrix, y, along[i] - across[i])
    return _largest_eigenvalue(matrix)
