"""Stiffness of the contacts of a body, and its fastest vibration."""

from __future__ import annotations

import math

import numpy as np

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.dynamics.kernels.rigid_body_nb import direction
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.rigid.rigid_lanes import AXES, CENTRE, MASS, MOMENTS, SPINS, TURN, WAYS

SWEEPS = 30
ROUNDING = 1e-15


@inner(error_model="numpy")
def _largest(a):
    """The largest eigenvalue of a symmetric matrix, which is changed: Jacobi's cyclic method."""
    n = a.shape[0]
    for _ in range(SWEEPS):
        off, whole = 0.0, 0.0
        for i in range(n):
            whole += a[i, i] * a[i, i]
            for j in range(i):
                off += a[i, j] * a[i, j]
        if off <= ROUNDING * ROUNDING * whole:
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
    most = 0.0
    for i in range(n):
        most = max(most, a[i, i])
    return most


@inner(error_model="numpy")
def _felt(one, axes, d, arm, y):
    """A direction `d` at `arm` from the centre as the body's six masses feel it."""
    root = math.sqrt(one[MASS])
    x0 = (arm[1] * d[2] - arm[2] * d[1]) * one[SPINS]
    x1 = (arm[2] * d[0] - arm[0] * d[2]) * one[SPINS + 1]
    x2 = (arm[0] * d[1] - arm[1] * d[0]) * one[SPINS + 2]
    for k in range(3):
        y[k] = d[k] * one[WAYS + k] / root
        y[3 + k] = axes[k, 0] * x0 + axes[k, 1] * x1 + axes[k, 2] * x2


@inner(error_model="numpy")
def _add(matrix, y, weight):
    for i in range(6):
        for j in range(6):
            matrix[i, j] += weight * y[i] * y[j]


@kernel(error_model="numpy")
def fastest(points, normals, along, across, row, one):
    """ω² of the fastest vibration of a body on springs: the largest eigenvalue of M⁻¹ K.

    At each of the `points` (k, 3) a spring of stiffness `along` (k,) the direction in `normals`
    (k, 3) and `across` (k,) at right angles to it. With rates of damping for stiffnesses it is the
    fastest decay. Held rotations may only make it too large.
    """
    matrix, axes = np.zeros((6, 6)), scratch(3, 3)
    y, d, arm = scratch(6), scratch(3), scratch(3)
    q = row[TURN : TURN + 4]
    for k in range(3):
        a = direction(q, one[AXES + k], one[AXES + 3 + k], one[AXES + 6 + k])
        for j in range(3):
            axes[k, j] = a[j] / math.sqrt(one[MOMENTS + k])
    for i in range(points.shape[0]):
        for j in range(3):
            arm[j] = points[i, j] - row[CENTRE + j]
        for k in range(3):
            d[:] = 0.0
            d[k] = 1.0
            if across[i] != 0.0:
                _felt(one, axes, d, arm, y)
                _add(matrix, y, across[i])
        for k in range(3):
            d[k] = normals[i, k]
        _felt(one, axes, d, arm, y)
        _add(matrix, y, along[i] - across[i])
    return _largest(matrix)
