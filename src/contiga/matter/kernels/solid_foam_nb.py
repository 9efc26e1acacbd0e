"""Low-density foam, in lanes: principal nominal stresses σ(1 − λ_i) that do not feel each other.

What is taken in compression is W = Σ w(1 − λ_i). Below the largest W so far, Wₘ, it is given back
by the factor H + (1 − H) (W/Wₘ)^S: the gradient of H W + (1 − H) W (W/Wₘ)^S/(S + 1), which is
what is stored (the unloading of LS-DYNA's MAT_57 and of Radioss' LAW90). Tension is elastic.
Rates add to the stress what their tables have above the first one, at a rate that is smoothed by
an exponential filter: that of the stretch that is shortest.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner
from contiga.matter.kernels.curve_nb import curve_at, on_piece, piece_of
from contiga.matter.kernels.lanes_nb import (
    AXES,
    ENERGY,
    GRADIENT,
    HYSTERESIS,
    LANES,
    RATE,
    SPRINGS,
    SQUARE,
    STRESS,
    VISCOSITY,
)
from contiga.matter.kernels.solid_principal_nb import principal

F, P, W = GRADIENT * LANES, STRESS * LANES, ENERGY * LANES
C, N, V = SQUARE * LANES, AXES * LANES, RATE * LANES
S = SPRINGS * LANES
"""Three rows that nothing else has at that stage: principal stresses."""
ROW = 3 * LANES
# Coefficients: H, S, modulus in tension, time of the filter, points of each curve, curves; then the
# curve of rest (x, y, ∫y), the rates, and y of each curve.
KEPT, SHAPE, TENSION, FILTER, POINTS, CURVES, TABLE = 0, 1, 2, 3, 4, 5, 6
MOST, SPEED, REACHED = 0, 1, 2
"""What is remembered: Wₘ, the smoothed rate and the largest strain."""
MEMORY = 3


@inlined()
def _direction(bank, lane, i):
    """N_i of a lane, and F N_i."""
    a, b, c = bank[N + i * LANES + lane], 0.0, 0.0
    b, c = bank[N + ROW + i * LANES + lane], bank[N + 2 * ROW + i * LANES + lane]
    f = F + lane
    x = bank[f] * a + bank[f + LANES] * b + bank[f + 2 * LANES] * c
    f += ROW
    y = bank[f] * a + bank[f + LANES] * b + bank[f + 2 * LANES] * c
    f += ROW
    z = bank[f] * a + bank[f + LANES] * b + bank[f + 2 * LANES] * c
    return a, b, c, x, y, z


@inlined()
def _shortening(bank, lane, i, stretch):
    """−dλ/dt of a principal stretch."""
    a, b, c, x, y, z = _direction(bank, lane, i)
    v = V + lane
    u = bank[v] * a + bank[v + LANES] * b + bank[v + 2 * LANES] * c
    v += ROW
    w = bank[v] * a + bank[v + LANES] * b + bank[v + 2 * LANES] * c
    v += ROW
    t = bank[v] * a + bank[v + LANES] * b + bank[v + 2 * LANES] * c
    return -(u * x + w * y + t * z) / stretch


@inner()
def _excess(numbers, strain, speed):
    """Stress above that at rest, at a rate."""
    n, curves = int(numbers[POINTS]), int(numbers[CURVES])
    rates = TABLE + 3 * n
    if curves == 1 or strain <= 0.0 or speed <= numbers[rates]:
        return 0.0
    k = piece_of(numbers, TABLE, n, strain)
    r = min(piece_of(numbers, rates, curves, speed), curves - 2)
    low, _ = on_piece(numbers, TABLE, rates + curves + r * n, k, strain)
    high, _ = on_piece(numbers, TABLE, rates + curves + (r + 1) * n, k, strain)
    start, end = numbers[rates + r], numbers[rates + r + 1]
    share = min((speed - start) / (end - start), 1.0)
    rest, _ = on_piece(numbers, TABLE, TABLE + n, k, strain)
    return low + share * (high - low) - rest


@inner(linked=False)
def _stretches(bank):
    """Principal stretches in three rows behind their squares."""
    for at in range(C, C + 3 * LANES):
        bank[at + 3 * LANES] = math.sqrt(max(bank[at], 0.0))


@inner(linked=False)
def _pull_forward(bank):
    """P = −F Σ s_i/λ_i N_i ⊗ N_i of principal stresses s_i."""
    for lane in range(LANES):
        a, b, c = C + 3 * LANES + lane, C + 4 * LANES + lane, C + 5 * LANES + lane
        s_a, s_b, s_c = S + lane, S + LANES + lane, S + 2 * LANES + lane
        u, v, w = -bank[s_a] / bank[a], -bank[s_b] / bank[b], -bank[s_c] / bank[c]
        x, y, z = N + lane, N + ROW + lane, N + 2 * ROW + lane
        xa, xb, xc = bank[x], bank[x + LANES], bank[x + 2 * LANES]
        ya, yb, yc = bank[y], bank[y + LANES], bank[y + 2 * LANES]
        za, zb, zc = bank[z], bank[z + LANES], bank[z + 2 * LANES]
        xx, yy = u * xa * xa + v * xb * xb + w * xc * xc, u * ya * ya + v * yb * yb + w * yc * yc
        zz, xy = u * za * za + v * zb * zb + w * zc * zc, u * xa * ya + v * xb * yb + w * xc * yc
        yz, zx = u * ya * za + v * yb * zb + w * yc * zc, u * za * xa + v * zb * xb + w * zc * xc
        for i in range(3):
            f, p = F + i * ROW + lane, P + i * ROW + lane
            f_x, f_y, f_z = bank[f], bank[f + LANES], bank[f + 2 * LANES]
            bank[p] = f_x * xx + f_y * xy + f_z * zx
            bank[p + LANES] = f_x * xy + f_y * yy + f_z * yz
            bank[p + 2 * LANES] = f_x * zx + f_y * yz + f_z * zz


@inner()
def _kept(numbers, energy, most):
    """The factor of the force, and what is stored of `energy`."""
    kept, shape = numbers[KEPT], numbers[SHAPE]
    if energy >= most:
        return 1.0, energy * (kept + (1.0 - kept) / (shape + 1.0))
    part = (1.0 - kept) * (energy / most) ** shape
    return kept + part, energy * (kept + part / (shape + 1.0))


@inner()
def _lane(bank, lane, numbers, step, old, new):
    """Principal stresses and energies of a lane."""
    n, taken, elastic, least, shortest = int(numbers[POINTS]), 0.0, 0.0, math.inf, 0
    for i in range(3):
        stretch = bank[C + (3 + i) * LANES + lane]
        if stretch < least:
            least, shortest = stretch, i
        strain = 1.0 - stretch
        if strain > 0.0:
            stress, w = curve_at(numbers, TABLE, n, strain)
            taken += w
        else:
            stress = numbers[TENSION] * strain
            elastic += 0.5 * stress * strain
        bank[S + i * LANES + lane] = stress
    most, speed = old[MOST * LANES + lane], old[SPEED * LANES + lane]
    if numbers[CURVES] > 1.0:
        share = 1.0 - math.exp(-step / numbers[FILTER])
        speed += share * (_shortening(bank, lane, shortest, least) - speed)
    factor, stored = _kept(numbers, taken, most)
    viscous = 0.0
    for i in range(3):
        stretch = bank[C + (3 + i) * LANES + lane]
        strain, stress = 1.0 - stretch, bank[S + i * LANES + lane]
        if strain > 0.0:
            excess = _excess(numbers, strain, speed)
            if excess != 0.0:
                viscous += excess * _shortening(bank, lane, i, stretch)
            bank[S + i * LANES + lane] = factor * stress + excess
    bank[W + lane] = stored + elastic
    _, before = _kept(numbers, most, most)
    above = max(taken - most, 0.0)
    _, whole = _kept(numbers, most + above, most)
    bank[HYSTERESIS * LANES + lane] = above - (whole - before)
    bank[VISCOSITY * LANES + lane] += viscous * step
    new[MOST * LANES + lane] = max(taken, most)
    new[SPEED * LANES + lane] = speed
    new[REACHED * LANES + lane] = max(old[REACHED * LANES + lane], 1.0 - least)


@inner(linked=False)
def solid_foam(bank, numbers, step, old, new):
    """P, energies and the new memory from F, its rate and the old memory."""
    principal(bank)
    _stretches(bank)
    for lane in range(LANES):
        _lane(bank, lane, numbers, step, old, new)
    _pull_forward(bank)
