"""Bars of two nodes: a force along them by how much longer they are.

N of ε = ℓ/ℓ₀ − 1: linear, with or without compression, or by a curve that unloads by another one.
A bar whose nodes are at one point has no direction and pulls at neither.
"""

from __future__ import annotations

import math

from contiga.curves.kernels.hysteresis_nb import hysteretic
from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import CORNERS, ENERGY, HYSTERESIS, LANES

X, W, LOST = CORNERS * LANES, ENERGY * LANES, HYSTERESIS * LANES
CORNER = 3 * LANES
# Coefficients: stiffness E A in tension and in compression, and the slope K of hysteresis between
# the loading and the unloading curve: 0 without curves, beside which there is no stiffness.
TENSION, COMPRESSION, SLOPE = 0, 1, 2
REACHED = 2
MEMORY = 3
"""Strain, force and the largest strain, of bars by curves."""


@inner()
def _way(bank, lane):
    """Return the vector from the first to the second node, and its length."""
    at = X + lane
    x = bank[at + CORNER] - bank[at]
    y = bank[at + CORNER + LANES] - bank[at + LANES]
    z = bank[at + CORNER + 2 * LANES] - bank[at + 2 * LANES]
    return x, y, z, math.sqrt(x * x + y * y + z * z)


@inner(linked=False)
def bar_forces(bank, numbers, curves, inverse_lengths, old, new):
    """Forces in place of the nodes, energies by length at rest, and the new memory."""
    slope = numbers[SLOPE]
    for lane in range(LANES):
        x, y, z, length = _way(bank, lane)
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
        along = force / length if length > 0.0 else 0.0
        row = X + lane
        bank[row] = along * x
        bank[row + LANES] = along * y
        bank[row + 2 * LANES] = along * z
        bank[row + CORNER] = -along * x
        bank[row + CORNER + LANES] = -along * y
        bank[row + CORNER + 2 * LANES] = -along * z


@inner(linked=False)
def bar_rows(bank, numbers, inverse_lengths, measures):
    """Row sums of K = k n⊗n + N/ℓ (I − n⊗n) at both ends, in place of the nodes.

    k and N are those of the stiffest line, K, in tension: no less than any the bar has.
    """
    stiff = max(numbers[TENSION], numbers[COMPRESSION], numbers[SLOPE])
    for lane in range(LANES):
        x, y, z, length = _way(bank, lane)
        filled = 1.0 if measures[lane] > 0.0 else 0.0
        k = filled * stiff * inverse_lengths[lane]
        somewhere = length > 0.0
        across = 0.0
        if somewhere:
            across = filled * stiff * abs(length * inverse_lengths[lane] - 1.0) / length
            x, y, z = x / length, y / length, z / length
        whole = abs(x) + abs(y) + abs(z)
        for i in range(3):
            n = x if i == 0 else (y if i == 1 else z)
            along = abs(n) * whole if somewhere else 1.0
            rest = abs(n) * (whole - abs(n)) + 1.0 - n * n
            for end in range(2):
                bank[X + end * CORNER + i * LANES + lane] = 2.0 * (k * along + across * rest)
