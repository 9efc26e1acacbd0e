"""Low-density foam, in lanes: independent principal nominal stresses σ(1 − λ_i).

The energy of loading in compression is W = Σ w(1 − λ_i). Below the largest W so far, Wₘ, the force
has the factor H + (1 − H) (W/Wₘ)^S: it is the gradient of the stored energy
H W + (1 − H) W (W/Wₘ)^S/(S + 1) (the unloading of LS-DYNA's MAT_57 and of Radioss' LAW90). Tension
is elastic.

Rates add the overstress X(ε_i, s_i) to each principal stress: the difference of their tables to the
first one at the strain ε_i = 1 − λ_i and its rate s_i, filtered by τ ṡ_i = ε̇_i − s_i; zero if
either is not positive. No path of strain gains work by it. With d_i = ε_i − τ s_i it is a spring
ε_i − d_i in series with a dashpot d_i, ḋ_i = s_i, which stores

    ψ(ε, d) = ∫_d^ε X(e, (e − d)/τ) de ≥ 0,    ∂ψ/∂ε = X,    ∂ψ/∂d = −(1/τ) ∫_d^ε ∂X/∂s de,

so that its work is Σ X ε̇_i = ψ̇ + Σ s_i (1/τ) ∫ ∂X/∂s de. No table is below the previous one, hence
∂X/∂s ≥ 0, and X = 0 for s ≤ 0: the second part, which is lost, is never negative. This holds if
each axis keeps its own rate while it rotates; so axes are followed from step to step: ε_i is
continuous and ε̇_i = N_i·Ė N_i. The work of the mean of both ends of a step closes the energy
balance to second order.
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
"""Three rows of principal stresses, which are free at this stage."""
ROW = 3 * LANES
# Coefficients: H, S, modulus in tension, time of the filter; then the rates of the curves, 0 first.
HYSTERESIS_FACTOR, SHAPE, TENSION, FILTER, RATES = 0, 1, 2, 3, 4
MAX_ENERGY, REACHED, STRAIN, SPEED, DIRECTION = 0, 1, 2, 5, 8
"""Columns of the memory: Wₘ and the largest strain; with rates the strain of each axis, its
filtered rate, and the axes less the identity."""
MEMORY, MEMORY_OF_RATES = 2, 17


@inner()
def _excess(numbers, curves, strain, speed):
    """Return the stress above the quasi-static one at a rate of strain.

    It is linear between rates and constant above the last; zero in tension and for rates ≤ 0.
    """
    rates = numbers[RATES:]
    if strain <= 0.0 or speed <= rates[0]:
        return 0.0
    r = min(count_up_to(rates, speed), rates.shape[0] - 1) - 1
    low, high = curve_at(curves, r, strain).value, curve_at(curves, r + 1, strain).value
    share = min((speed - rates[r]) / (rates[r + 1] - rates[r]), 1.0)
    return low + share * (high - low) - curve_at(curves, 0, strain).value


@inner(linked=False)
def _stretches(bank):
    """Write the principal stretches in three rows behind their squares."""
    for at in range(C, C + 3 * LANES):
        bank[at + 3 * LANES] = math.sqrt(max(bank[at], 0.0))


@inner(linked=False)
def _pull_forward(bank):
    """Write P = −F Σ s_i/λ_i N_i ⊗ N_i of principal stresses s_i."""
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
def _unloading(numbers, energy, max_energy):
    """Return the unloading factor of the force and the recoverable part of `energy`."""
    h, shape = numbers[HYSTERESIS_FACTOR], numbers[SHAPE]
    if energy >= max_energy:
        return 1.0, energy * (h + (1.0 - h) / (shape + 1.0))
    part = (1.0 - h) * (energy / max_energy) ** shape
    return h + part, energy * (h + part / (shape + 1.0))


@inner()
def _static_stresses(bank, lane, numbers, curves, old, new):
    """Write principal stresses, stored energy, hysteresis and memory of a lane, without rates.

    Unloading reduces the stresses in compression alone.
    """
    energy, elastic = 0.0, 0.0
    reached = old[REACHED * LANES + lane]
    for i in range(3):
        strain = 1.0 - bank[C + (3 + i) * LANES + lane]
        reached = max(reached, strain)
        if strain > 0.0:
            at = curve_at(curves, 0, strain)
            stress = at.value
            energy += at.integral
        else:
            stress = numbers[TENSION] * strain
            elastic += 0.5 * stress * strain
        bank[S + i * LANES + lane] = stress
    max_energy = old[MAX_ENERGY * LANES + lane]
    factor, stored = _unloading(numbers, energy, max_energy)
    for i in range(3):
        if bank[C + (3 + i) * LANES + lane] < 1.0:
            bank[S + i * LANES + lane] *= factor
    bank[W + lane] = stored + elastic
    _, before = _unloading(numbers, max_energy, max_energy)
    increment = max(energy - max_energy, 0.0)
    _, after = _unloading(numbers, max_energy + increment, max_energy)
    bank[HYSTERESIS * LANES + lane] = increment - (after - before)
    new[MAX_ENERGY * LANES + lane] = max(energy, max_energy)
    new[REACHED * LANES + lane] = reached


@inner()
def _overstress(bank, lane, tables, step, old, new):
    """Add the overstress of the rates to the principal stresses of a lane, and its work to losses.

    Strains, filtered rates and axes are written into the new memory.
    """
    numbers, curves = tables.numbers, tables.curves
    decay = math.exp(-step / numbers[FILTER])
    # Filter of a step with a constant strain rate; zero for a step of zero length.
    gain = -math.expm1(-step / numbers[FILTER]) / step if step > 0.0 else 0.0
    for i in range(3):
        at, to = (STRAIN + i) * LANES + lane, (SPEED + i) * LANES + lane
        strain = 1.0 - bank[C + (3 + i) * LANES + lane]
        change = strain - old[at]
        speed = decay * old[to] + gain * change
        excess = _excess(numbers, curves, strain, speed)
        if decay < 1.0:  # a step of zero length has no loss
            before = _excess(numbers, curves, old[at], old[to])
            bank[VISCOSITY * LANES + lane] += 0.5 * (before + excess) * change
        bank[S + i * LANES + lane] += excess
        new[at] = strain
        new[to] = speed
    for k in range(9):
        axis = bank[N + k * LANES + lane]
        new[(DIRECTION + k) * LANES + lane] = axis - 1.0 if k % 4 == 0 else axis


@inner(linked=False)
def solid_foam(bank, tables, step, old, new):
    """Write P, energies and the new memory from F, the step and the old memory.

    Losses by rates are added to those in the bank.
    """
    has_rates = tables.numbers.shape[0] > RATES + 1
    # The memory of bulk viscosity follows in `old`.
    first, axes = DIRECTION * LANES, 9 * LANES if has_rates else 0
    principal(bank, old[first : first + axes])
    _stretches(bank)
    for lane in range(LANES):
        _static_stresses(bank, lane, tables.numbers, tables.curves, old, new)
    if has_rates:
        for lane in range(LANES):
            _overstress(bank, lane, tables, step, old, new)
    _pull_forward(bank)
