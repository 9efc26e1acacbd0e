"""Blocks of elements: corners gathered to lanes, and forces of lanes summed at nodes.

A block holds LANES elements, whose numbers lie one after the other: row r of a block's bank is
``bank[r * LANES : (r + 1) * LANES]``, and each stage is a loop over lanes without branches, which
becomes vector code as long as the stage is compiled by itself. The forces of a block are summed at
the block's own nodes while they are in the cache, then the sums of the blocks at the nodes, both
in a fixed order: the same bits on any number of threads. With a sum of all elements at the nodes
in one go 10⁵ tetrahedra took 1.6 times as long, mostly to write and read the elements' forces.
"""

from __future__ import annotations

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import inner, kernel

LANES = 64
# Rows of a bank. The corners, three rows each; forces take their place. What a solid's gradient
# stage finds, three by three, is F, the material's stress P (first Piola-Kirchhoff) and energy.
CORNERS, GRADIENT, STRESS = 0, 24, 33
ENERGY, HOURGLASS, VISCOSITY, HYSTERESIS = 42, 43, 44, 45
"""Densities by reference volume (of membranes: area, of bars: length), but of HOURGLASS."""
KINDS = 4
STRETCH = 46
"""J = det F of solids; what may not fall to zero."""
RATE = 47
SECOND, TANGENT = 47, 50
"""Of membranes, in rows that rates and springs of solids have: three rows of the second stress S₁₁,
S₂₂, S₁₂, and six of ∂S/∂E."""
STRAIN = 56
"""Of membranes, in rows that springs of solids have: Green's strain E₁₁, E₂₂, E₁₂."""
SPRINGS = 56
"""Twelve rows: the forces of hourglass modes, by reference volume."""
SQUARE, AXES = 68, 74
"""C = FᵀF, six rows, which becomes its eigenvalues; nine rows: its eigenvectors, one a column."""
PRESSURE = 83
"""λ (J − 1) averaged at the corners of tetrahedra, zero of others."""
ROWS = 84
SIZE = ROWS * LANES


@inner(linked=False)
def gather(points, nodes, corners, bank):
    """Copy the rows of `points` at nodes (corners, LANES) into the bank."""
    for a in range(corners):
        row = (CORNERS + 3 * a) * LANES
        for lane in range(LANES):
            n = nodes[a, lane]
            bank[row + lane] = points[n, 0]
            bank[row + LANES + lane] = points[n, 1]
            bank[row + 2 * LANES + lane] = points[n, 2]


@inner(linked=False)
def blank(bank):
    """Zero energies and pressure."""
    for at in range(ENERGY * LANES, (ENERGY + KINDS) * LANES):
        bank[at] = 0.0
    for lane in range(LANES):
        bank[PRESSURE * LANES + lane] = 0.0


@inner(linked=False)
def take_as_rate(bank):
    """The gradient of velocities into its own rows."""
    for at in range(9 * LANES):
        bank[RATE * LANES + at] = bank[GRADIENT * LANES + at]


@inner(linked=False)
def total(bank, row):
    """Return the sum of a row, which is overwritten: halves are added until one number is left."""
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
    """Forces of a block's lanes, summed at its own nodes, into its rows of `partial`."""
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
    """Rows of `partial` that belong to nodes start … stop, summed in their order."""
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
