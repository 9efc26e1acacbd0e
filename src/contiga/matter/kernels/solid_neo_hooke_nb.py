"""Neo-Hookean solid, in lanes: W = μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)².

P = μ F + (λ (J − 1) − μ/J) cof F. Only the energy needs the logarithm. It is a series in
(J − 1)/(J + 1), since a library call would take a third of the time of the element, and has not the
same bits on all machines; lanes with J far from 1 use the eighth root of J.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner
from contiga.matter.kernels.lanes_nb import ENERGY, GRADIENT, LANES, PRESSURE, STRESS, STRETCH

F, P, W, J = GRADIENT * LANES, STRESS * LANES, ENERGY * LANES, STRETCH * LANES
ROW = 3 * LANES


@inlined()
def log_series(s):
    """Return ln((1 + s)/(1 − s)) to 1e-15 for |s| ≤ 1/3, which is J from 1/2 to 2."""
    q = s * s
    p = 1.0 / 29.0
    p = p * q + 1.0 / 27.0
    p = p * q + 1.0 / 25.0
    p = p * q + 1.0 / 23.0
    p = p * q + 1.0 / 21.0
    p = p * q + 1.0 / 19.0
    p = p * q + 1.0 / 17.0
    p = p * q + 1.0 / 15.0
    p = p * q + 1.0 / 13.0
    p = p * q + 1.0 / 11.0
    p = p * q + 1.0 / 9.0
    p = p * q + 1.0 / 7.0
    p = p * q + 1.0 / 5.0
    p = p * q + 1.0 / 3.0
    return 2.0 * s * (p * q + 1.0)


@inner(linked=False)
def solid_neo_hooke(bank, numbers):
    """Write P and W from F and J; numbers are μ and the λ that is not averaged at nodes.

    P includes the pressure averaged at nodes, W does not.
    """
    mu, lam = numbers[0], numbers[1]
    for lane in range(LANES):
        f, p = F + lane, P + lane
        xx, xy, xz = bank[f], bank[f + LANES], bank[f + 2 * LANES]
        yx, yy, yz = bank[f + ROW], bank[f + ROW + LANES], bank[f + ROW + 2 * LANES]
        zx, zy, zz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES], bank[f + 2 * ROW + 2 * LANES]
        j = bank[J + lane]
        k = lam * (j - 1.0) + bank[PRESSURE * LANES + lane] - mu / j
        bank[p] = mu * xx + k * (yy * zz - yz * zy)
        bank[p + LANES] = mu * xy + k * (yz * zx - yx * zz)
        bank[p + 2 * LANES] = mu * xz + k * (yx * zy - yy * zx)
        bank[p + ROW] = mu * yx + k * (xz * zy - xy * zz)
        bank[p + ROW + LANES] = mu * yy + k * (xx * zz - xz * zx)
        bank[p + ROW + 2 * LANES] = mu * yz + k * (xy * zx - xx * zy)
        bank[p + 2 * ROW] = mu * zx + k * (xy * yz - xz * yy)
        bank[p + 2 * ROW + LANES] = mu * zy + k * (xz * yx - xx * yz)
        bank[p + 2 * ROW + 2 * LANES] = mu * zz + k * (xx * yy - xy * yx)
        square = xx * xx + xy * xy + xz * xz + yx * yx + yy * yy + yz * yz
        square += zx * zx + zy * zy + zz * zz
        is_far = j > 2.0 or j < 0.5
        root = math.sqrt(math.sqrt(math.sqrt(j))) if is_far else j
        log = log_series((root - 1.0) / (root + 1.0)) * (8.0 if is_far else 1.0)
        change = j - 1.0
        bank[W + lane] = 0.5 * mu * (square - 3.0) - mu * log + 0.5 * lam * change * change
