"""Principal stretches, in lanes: C = FᵀF rotated to its axes by Jacobi's method.

Four sweeps over three pairs reduce the off-diagonal entries to zero in the last bit (Golub and Van
Loan, Matrix Computations, 8.5.4: once they are small, each sweep squares them). Unlike closed forms
they are exact for nearly equal stretches, as in a foam close to rest.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner
from contiga.matter.kernels.lanes_nb import AXES, GRADIENT, LANES, SQUARE

F, C, N = GRADIENT * LANES, SQUARE * LANES, AXES * LANES
ROW = 3 * LANES
N_SWEEPS = 4


@inner(linked=False)
def _rotate_to(bank, axes):
    """Write the axes from `axes` (9 · LANES), less the identity, and C in these axes."""
    for lane in range(LANES):
        for i in range(3):
            n, at = N + i * LANES + lane, i * LANES + lane
            a = axes[at] + (1.0 if i == 0 else 0.0)
            b = axes[at + ROW] + (1.0 if i == 1 else 0.0)
            c = axes[at + 2 * ROW] + (1.0 if i == 2 else 0.0)
            # Normalised by a step of Newton's method: each rotation loses the last bit.
            factor = 1.5 - 0.5 * (a * a + b * b + c * c)
            bank[n], bank[n + ROW], bank[n + 2 * ROW] = factor * a, factor * b, factor * c
        at = C + lane
        xx, yy, zz = bank[at], bank[at + LANES], bank[at + 2 * LANES]
        at += 3 * LANES
        yz, zx, xy = bank[at], bank[at + LANES], bank[at + 2 * LANES]
        for i in range(3):
            j = (i + 1) % 3
            n, m = N + i * LANES + lane, N + j * LANES + lane
            a, b, c = bank[n], bank[n + ROW], bank[n + 2 * ROW]
            x, y, z = xx * a + xy * b + zx * c, xy * a + yy * b + yz * c, zx * a + yz * b + zz * c
            bank[C + i * LANES + lane] = a * x + b * y + c * z
            # C_ij is in the row of the third axis.
            off_diagonal = bank[m] * x + bank[m + ROW] * y + bank[m + 2 * ROW] * z
            bank[C + (3 + (i + 2) % 3) * LANES + lane] = off_diagonal


@inner(linked=False)
def _square(bank, to, i, j):
    """Write C_ij into a row."""
    for lane in range(LANES):
        a, b = F + i * LANES + lane, F + j * LANES + lane
        x, y, z = bank[a] * bank[b], bank[a + ROW] * bank[b + ROW], 0.0
        z = bank[a + 2 * ROW] * bank[b + 2 * ROW]
        bank[to + lane] = x + y + z


@inlined()
def _rotate(bank, p, q):
    """Rotate axes p and q, literal numbers, so that C_pq is zero."""
    r = 3 - p - q
    at_p, at_q, at_pq = C + p * LANES, C + q * LANES, C + (3 + r) * LANES
    at_pr, at_qr = C + (3 + q) * LANES, C + (3 + p) * LANES
    for lane in range(LANES):
        difference, off = bank[at_q + lane] - bank[at_p + lane], 2.0 * bank[at_pq + lane]
        root = math.sqrt(difference * difference + off * off)
        divisor = difference + root if difference >= 0.0 else difference - root
        t = off / (divisor if divisor != 0.0 else 1.0)
        c = 1.0 / math.sqrt(1.0 + t * t)
        s = t * c
        bank[at_p + lane] -= 0.5 * t * off
        bank[at_q + lane] += 0.5 * t * off
        bank[at_pq + lane] = 0.0
        x, y = bank[at_pr + lane], bank[at_qr + lane]
        bank[at_pr + lane] = c * x - s * y
        bank[at_qr + lane] = s * x + c * y
        for i in range(3):
            n = N + i * ROW + lane
            x, y = bank[n + p * LANES], bank[n + q * LANES]
            bank[n + p * LANES] = c * x - s * y
            bank[n + q * LANES] = s * x + c * y


@inner(linked=False)
def _rotate_01(bank):
    _rotate(bank, 0, 1)


@inner(linked=False)
def _rotate_02(bank):
    _rotate(bank, 0, 2)


@inner(linked=False)
def _rotate_12(bank):
    _rotate(bank, 1, 2)


@inner()
def principal(bank, axes):
    """Write the squared principal stretches, three rows from SQUARE, and their directions at rest.

    The directions are the columns of AXES; stretches are in no order of size.
    Rotations begin at the last `axes` (9 · LANES), less the identity, so that each axis is
    followed; at the coordinate axes if `axes` is empty (0).
    """
    for i in range(3):
        _square(bank, C + i * LANES, i, i)
        _square(bank, C + (3 + i) * LANES, (i + 1) % 3, (i + 2) % 3)
        for j in range(3):
            for lane in range(LANES):
                bank[N + i * ROW + j * LANES + lane] = 1.0 if i == j else 0.0
    if len(axes) > 0:
        _rotate_to(bank, axes)
    for _ in range(N_SWEEPS):
        _rotate_01(bank)
        _rotate_02(bank)
        _rotate_12(bank)
