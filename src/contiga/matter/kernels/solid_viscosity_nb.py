"""Bulk viscosity of solids, in lanes: a pressure against fast compression.

q = ρ ℓ (b c |ε̇| + a ℓ ε̇²) while the volume shrinks at ε̇ = J̇/J < 0, with the density ρ = ρ₀/J, the
length ℓ = V^⅓ at rest and the speed c of pressure waves at rest (von Neumann and Richtmyer, 1950;
Landshoff, 1955). It dissipates q |J̇| ≥ 0 by volume at rest; in a step, the mean of q at both ends
times the change of J, which closes the energy balance to second order.
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import GRADIENT, LANES, RATE, STRESS, STRETCH, VISCOSITY

F, P, V = GRADIENT * LANES, STRESS * LANES, RATE * LANES
J, LOST = STRETCH * LANES, VISCOSITY * LANES
ROW = 3 * LANES
MEMORY = 2
"""Last columns of the memory: q and J − 1."""


@inner(linked=False)
def bulk_viscosity(bank, numbers, sizes, step, old, new):
    """Subtract the viscous pressure from P, add the loss of a step, and write the `new` memory.

    Numbers are b c, a and ρ₀; the memory is its last two columns.
    """
    first = len(old) - MEMORY * LANES
    linear, quadratic, density = numbers[0], numbers[1], numbers[2]
    for lane in range(LANES):
        f, v, p = F + lane, V + lane, P + lane
        xx, xy, xz = bank[f], bank[f + LANES], bank[f + 2 * LANES]
        yx, yy, yz = bank[f + ROW], bank[f + ROW + LANES], bank[f + ROW + 2 * LANES]
        zx, zy, zz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES], bank[f + 2 * ROW + 2 * LANES]
        a, b, c = yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx
        d, e, g = xz * zy - xy * zz, xx * zz - xz * zx, xy * zx - xx * zy
        h, k, m = xy * yz - xz * yy, xz * yx - xx * yz, xx * yy - xy * yx
        rate = bank[v] * a + bank[v + LANES] * b + bank[v + 2 * LANES] * c
        v += ROW
        rate += bank[v] * d + bank[v + LANES] * e + bank[v + 2 * LANES] * g
        v += ROW
        rate += bank[v] * h + bank[v + LANES] * k + bank[v + 2 * LANES] * m
        strain_rate = max(-rate, 0.0) / bank[J + lane]
        size = sizes[lane]
        speed = linear + quadratic * size * strain_rate
        q = density / bank[J + lane] * size * strain_rate * speed
        change, at = bank[J + lane] - 1.0, first + lane
        if step > 0.0:
            bank[LOST + lane] += 0.5 * (old[at] + q) * (old[at + LANES] - change)
        new[at] = q
        new[at + LANES] = change
        bank[p] -= q * a
        bank[p + LANES] -= q * b
        bank[p + 2 * LANES] -= q * c
        p += ROW
        bank[p] -= q * d
        bank[p + LANES] -= q * e
        bank[p + 2 * LANES] -= q * g
        p += ROW
        bank[p] -= q * h
        bank[p + LANES] -= q * k
        bank[p + 2 * LANES] -= q * m
