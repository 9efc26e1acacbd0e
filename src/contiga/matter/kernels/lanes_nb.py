"""Blocks of elements: corners gathered to lanes, and forces of lanes summed at nodes.

A block has LANES elements, whose numbers are contiguous: row r of a block's bank is
``bank[r * LANES : (r + 1) * LANES]``. Each stage is a loop over lanes without branches, which
becomes vector code if the stage is compiled by itself. The forces of a block are summed at the
block's nodes while they are in the cache, then the sums of the blocks at the nodes, both in a fixed
order: the same bits on any number of threads. Summing all elements at the nodes in one go took 1.6
times as long for 10⁵ tetrahedra, mostly to write and read the elements' forces.
"""

from __future__ import annotations

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import inner, kernel

LANES = 64
# Rows of a bank: corners, three rows each, which forces overwrite; F, 3 × 3; the first
# Piola-Kirchhoff stress P, 3 × 3; energies.
CORNER_ROWS, GRADIENT, STRESS = 0, 24, 33
ENERGY, HOURGLASS, VISCOSITY, HYSTERESIS = 42, 43, 44, 45
"""Energies by reference volume (area of membranes, length of bars)."""
N_ENERGIES = 4
STRETCH = 46
"""J = det F of solids, above zero unless an element is inverted."""
RATE = 47
SECOND, TANGENT = 47, 50
"""For membranes, in rows of rates and springs of solids: the second Piola-Kirchhoff stress S₁₁,
S₂₂, S₁₂, and six rows of ∂S/∂E."""
STRAIN = 56
"""For membranes, in rows of springs of solids: Green's strain E₁₁, E₂₂, E₁₂."""
SPRINGS = 56
"""Twelve rows: the forces of hourglass modes, by reference volume."""
SQUARE, AXES = 68, 74
"""C = FᵀF, six rows, then its eigenvalues; nine rows of its eigenvectors, the columns of a matrix.
"""
PRESSURE = 83
"""λ (J − 1) averaged at the corners of tetrahedra; zero for other elements."""
ROWS = 84
SIZE = ROWS * LANES


@inner(linked=False)
def gather(points, nodes, corners, bank):
    """Copy the rows of `points` at nodes (corners, LANES) into the bank."""
    for a in range(corners):
        row = (CORNER_ROWS + 3 * a) * LANES
        for lane in range(LANES):
            n = nodes[a, lane]
            bank[row + lane] = points[n, 0]
            bank[row + LANES + lane] = points[n, 1]
            bank[row + 2 * LANES + lane] = points[n, 2]


@inner(linked=False)
def blank(bank):
    """Set energies and pressure to zero."""
    for at in range(ENERGY * LANES, (ENERGY + N_ENERGIES) * LANES):
        bank[at] = 0.0
    for lane in range(LANES):
        bank[PRESSURE * LANES + lane] = 0.0


@inner(linked=False)
def copy_to_rate(bank):
    """Copy the gradient of velocities to the rows of rates."""
    for at in range(9 * LANES):
        bank[RATE * LANES + at] = bank[GRADIENT * LANES + at]


@inner(linked=False)
def total(bank, row):
    """Return the sum of a row by pairwise halving; overwrites the row."""
    width = LANES // 2
    first = row * LANES
    while width > 0:
        for lane in range(width):
            bank[first + lane] += bank[first + width + lane]
        width //= 2
    return bank[first]


@inner(linked=False)
def inverted(bank):
    """Return the number of lanes whose J is not above zero."""
    count = 0
    for lane in range(LANES):
        count += 0 if bank[STRETCH * LANES + lane] > 0.0 else 1
    return count


@inner(linked=False)
def sum_in_block(bank, sums, b, partial):
    """Write the forces in rows of corners, summed at nodes of block b, into rows of `partial`."""
    m = sums.starts[sums.blocks[b]]
    for k in range(sums.blocks[b], sums.blocks[b + 1]):
        x, y, z = 0.0, 0.0, 0.0
        while m < sums.starts[k + 1]:
            at = sums.places[m]
            x += bank[at]
            y += bank[at + LANES]
            z += bank[at + 2 * LANES]
            m += 1
        partial[k, 0] = x
        partial[k, 1] = y
        partial[k, 2] = z


@kernel()
def sum_at_nodes(partial, starts, rows, out, start, stop):
    """Write the sums of rows of `partial` at nodes start … stop into `out` (n, 3).

    The rows of node n are `rows` starts[n] … starts[n + 1], summed in this order.
    """
    for n in range(start, stop):
        x, y, z = 0.0, 0.0, 0.0
        for m in range(starts[n], starts[n + 1]):
            k = rows[m]
            x += partial[k, 0]
            y += partial[k, 1]
            z += partial[k, 2]
        out[n, 0] = x
        out[n, 1] = y
        out[n, 2] = z
