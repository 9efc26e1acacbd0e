"""Low-density foam, in lanes: principal nominal stresses σ(1 − λ_i) that do not feel each other.

What is taken in compression is W = Σ w(1 − λ_i). Below the largest W so far, Wₘ, it is given back
by the factor H + (1 − H) (W/Wₘ)^S: the gradient of H W + (1 − H) W (W/Wₘ)^S/(S + 1), which is
what is stored (the unloading of LS-DYNA's MAT_57 and of Radioss' LAW90). Tension is elastic.

Rates add the overstress X(ε_i, s_i) to each principal stress: what their tables have above the
first one at the strain ε_i = 1 − λ_i and its rate s_i, smoothed by τ ṡ_i = ε̇_i − s_i, zero where
either is not above zero. No path of strain gains work by it. With d_i = ε_i − τ s_i it is a
spring ε_i − d_i in series with a dashpot d_i, ḋ_i = s_i, which stores

    ψ(ε, d) = ∫_d^ε X(e, (e − d)/τ) de ≥ 0,    ∂ψ/∂ε = X,    ∂ψ/∂d = −(1/τ) ∫_d^ε ∂X/∂s de,

so that the work it takes is Σ X ε̇_i = ψ̇ + Σ s_i (1/τ) ∫ ∂X/∂s de. No table is below that before
it, hence ∂X/∂s ≥ 0, and X = 0 where s ≤ 0: the second part, which is lost, is never negative. This
holds as each axis keeps its own rate while it turns, for which it is followed from step to step:
ε_i is continuous and ε̇_i = N_i·Ė N_i. Since the work is that of the mean of both ends of a step,
it closes the balance to second order.
"""

from __future__ import annotations

import math

from contiga.arrays.kernels.sort_nb import count_up_to
from contiga.curves.kernels.curve_nb import curve_at
from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import (
    AXES,
    ENERGY,
    GRADIENT,
    HYSTERESIS,
    LANES,
    SPRINGS,
    SQUARE,
    STRESS,
    VISCOSITY,
)
from contiga.matter.kernels.solid_principal_nb import principal

F, P, W = GRADIENT * LANES, STRESS * LANES, ENERGY * LANES
C, N = SQUARE * LANES, AXES * LANES
S = SPRINGS * LANES
"""Three rows that nothing else has at that stage: principal stresses."""
ROW = 3 * LANES
# Coefficients: H, S, modulus in tension, time of the filter; then the rates of the curves, of which
# the first is at rest.
KEPT, SHAPE, TENSION, FILTER, RATES = 0, 1, 2, 3, 4
MAX_ENERGY, REACHED, STRAIN, SPEED, DIRECTION = 0, 1, 2, 5, 8
"""Columns of the memory: Wₘ and the largest strain; with rates the strain of each axis, its
smoothed rate, and the axes less those of coordinates."""
MEMORY, MEMORY_OF_RATES = 2, 17


@inner()
def _excess(numbers, curves, strain, speed):
    """Return the stress above that at rest, at a rate."""
    rates = numbers[RATES:]
    if strain <= 0.0 or speed <= rates[0]:
        return 0.0
    r = min(count_up_to(rates, speed), rates.shape[0] - 1) - 1
    low, high = curve_at(curves, r, strain).value, curve_at(curves, r + 1, strain).value
    share = min((speed - rates[r]) / (rates[r + 1] - rates[r]), 1.0)
    return low + share * (high - low) - curve_at(curves, 0, strain).value


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
    """Return the unloading factor of the force and the recoverable part of `energy`."""
    kept, shape = numbers[KEPT], numbers[SHAPE]
    if energy >= most:
        return 1.0, energy * (kept + (1.0 - kept) / (shape + 1.0))
    part = (1.0 - kept) * (energy / most) ** shape
    return kept + part, energy * (kept + part / (shape + 1.0))


@inner()
def _lane(bank, lane, numbers, curves, old, new):
    """Principal stresses and energies of a lane, without rates."""
    taken, elastic = 0.0, 0.0
    reached = old[REACHED * LANES + lane]
    for i in range(3):
        strain = 1.0 - bank[C + (3 + i) * LANES + lane]
        reached = max(reached, strain)
        if strain > 0.0:
            at = curve_at(curves, 0, strain)
            stress = at.value
            taken += at.integral
        else:
            stress = numbers[TENSION] * strain
            elastic += 0.5 * stress * strain
        bank[S + i * LANES + lane] = stress
    most = old[MAX_ENERGY * LANES + lane]
    factor, stored = _kept(numbers, taken, most)
    for i in range(3):
        if bank[C + (3 + i) * LANES + lane] < 1.0:
            bank[S + i * LANES + lane] *= factor
    bank[W + lane] = stored + elastic
    _, before = _kept(numbers, most, most)
    above = max(taken - most, 0.0)
    _, whole = _kept(numbers, most + above, most)
    bank[HYSTERESIS * LANES + lane] = above - (whole - before)
    new[MAX_ENERGY * LANES + lane] = max(taken, most)
    new[REACHED * LANES + lane] = reached


@inner()
def _overstress(bank, lane, tables, step, old, new):
    """Add the overstress of the rates to the principal stresses of a lane, and account its work."""
    numbers, curves = tables.numbers, tables.curves
    held = math.exp(-step / numbers[FILTER])
    # of a step in which the strain changes evenly; nothing moves in one of no length
    gain = -math.expm1(-step / numbers[FILTER]) / step if step > 0.0 else 0.0
    for i in range(3):
        at, to = (STRAIN + i) * LANES + lane, (SPEED + i) * LANES + lane
        strain = 1.0 - bank[C + (3 + i) * LANES + lane]
        way = strain - old[at]
        speed = held * old[to] + gain * way
        excess = _excess(numbers, curves, strain, speed)
        if held < 1.0:  # nothing is lost in no time
            before = _excess(numbers, curves, old[at], old[to])
            bank[VISCOSITY * LANES + lane] += 0.5 * (before + excess) * way
        bank[S + i * LANES + lane] += excess
        new[at] = strain
        new[to] = speed
    for k in range(9):
        axis = bank[N + k * LANES + lane]
        new[(DIRECTION + k) * LANES + lane] = axis - 1.0 if k % 4 == 0 else axis


@inner(linked=False)
def solid_foam(bank, tables, step, old, new):
    """P, energies and the new memory from F, the step and the old memory."""
    rated = tables.numbers.shape[0] > RATES + 1
    # what bulk viscosity remembers follows in `old`
    first, axes = DIRECTION * LANES, 9 * LANES if rated else 0
    principal(bank, old[first : first + axes])
    _stretches(bank)
    for lane in range(LANES):
        _lane(bank, lane, tables.numbers, tables.curves, old, new)
    if rated:
        for lane in range(LANES):
            _overstress(bank, lane, tables, step, old, new)
    _pull_forward(bank)
