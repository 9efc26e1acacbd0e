"""Bars of two nodes, with an axial force N over the strain ε = ℓ/ℓ₀ − 1.

N is linear, with or without compression, or given by curves with hysteresis. A bar whose nodes
coincide has no direction and no force.
"""

from __future__ import annotations

import math

from contiga.curves.kernels.hysteresis_nb import hysteretic
from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import CORNER_ROWS, ENERGY, HYSTERESIS, LANES

X, W, LOST = CORNER_ROWS * LANES, ENERGY * LANES, HYSTERESIS * LANES
CORNER = 3 * LANES
# Coefficients: stiffness E A in tension and in compression, and the slope K of hysteresis between
# the loading and the unloading curve: 0 without curves, beside which there is no stiffness.
TENSION, COMPRESSION, SLOPE = 0, 1, 2
REACHED = 2
MEMORY = 3
"""Strain, force and the largest strain, for bars with curves."""


@inner()
def _axis(bank, lane):
    """Return the vector from the first to the second node, and its length."""
    at = X + lane
    x = bank[at + CORNER] - bank[at]
    y = bank[at + CORNER + LANES] - bank[at + LANES]
    z = bank[at + CORNER + 2 * LANES] - bank[at + 2 * LANES]
    return x, y, z, math.sqrt(x * x + y * y + z * z)


@inner(linked=False)
def bar_forces(bank, numbers, curves, inverse_lengths, old, new):
    """Write forces in place of the nodes, and energies by length at rest, into the bank.

    With curves, SLOPE > 0, losses and the `new` memory are written, too.
    """
    slope = numbers[SLOPE]
    for lane in range(LANES):
        x, y, z, length = _axis(bank, lane)
        strain = length * inverse_lengths[lane] - 1.0
        linear = numbers[TENSION] if strain > 0.0 else numbers[COMPRESSION]
        force = linear * strain
        energy = 0.5 * force * strain
        if slope > 0.0:
            at = hysteretic(curves, 0, slope, old[lane], old[LANES + lane], strain)
            new[lane] = strain
            new[LANES + lane] = at.force
            new[REACHED * LANES + lane] = max(old[REACHED * LANES + lane], strain)
            force, energy = force + at.force, energy + at.stored
            bank[LOST + lane] = at.lost
        bank[W + lane] = energy
        factor = force / length if length > 0.0 else 0.0
        row = X + lane
        bank[row] = factor * x
        bank[row + LANES] = factor * y
        bank[row + 2 * LANES] = factor * z
        bank[row + CORNER] = -factor * x
        bank[row + CORNER + LANES] = -factor * y
        bank[row + CORNER + 2 * LANES] = -factor * z


@inner(linked=False)
def bar_rows(bank, numbers, inverse_lengths, measures):
    """Write row sums of |K| in place of the nodes, K = k n⊗n + N/ℓ (I − n⊗n) between both ends.

    k and |N| are those of the steepest line, upper bounds of those of the bar. A bar without length
    has n in all directions; lanes that fill a block get zero.
    """
    stiffness = max(numbers[TENSION], numbers[COMPRESSION], numbers[SLOPE])
    for lane in range(LANES):
        x, y, z, length = _axis(bank, lane)
        is_element = 1.0 if measures[lane] > 0.0 else 0.0
        k = is_element * stiffness * inverse_lengths[lane]
        has_length = length > 0.0
        tension = 0.0
        if has_length:
            tension = is_element * stiffness * abs(length * inverse_lengths[lane] - 1.0) / length
            x, y, z = x / length, y / length, z / length
        total = abs(x) + abs(y) + abs(z)
        for i in range(3):
            n = x if i == 0 else (y if i == 1 else z)
            axial = abs(n) * total if has_length else 1.0
            transverse = abs(n) * (total - abs(n)) + 1.0 - n * n
            for end in range(2):
                row_sum = 2.0 * (k * axial + tension * transverse)
                bank[X + end * CORNER + i * LANES + lane] = row_sum
