"""Hexahedra in blocks of lanes: one mean gradient, and springs against hourglass modes.

F = Σ x_a ⊗ B_a with the mean gradients B_a of the corners' shape functions over the element at
rest. The four hourglass modes h_α have the vectors γ_α = h_α − Σ_j (h_α·X_j) B_j, which vanish for
linear fields (Flanagan and Belytschko, Int. J. Numer. Methods Eng. 17, 1981). With γ_α at rest, the
springs store Σ c_α/2 |γ_α·x|² by volume, which no rotation changes. As γ_α·x = h_α·x − F (h_α·X),
the twelve numbers h_α·X are sufficient.
"""

from __future__ import annotations

from contiga.jit import inlined, inner
from contiga.matter.kernels.lanes_nb import CORNER_ROWS, GRADIENT, HOURGLASS, LANES, SPRINGS, STRESS

F, P, X = GRADIENT * LANES, STRESS * LANES, CORNER_ROWS * LANES
Q, HOURGLASS_ENERGY = SPRINGS * LANES, HOURGLASS * LANES
ROW = 3 * LANES
STIFF, ROW_SUMS = 12, 16
"""Rows of the hourglass table behind the h_α·X: c of each mode, and row sums at eight corners."""


@inner(linked=False)
def hex_gradient(bank, gradients):
    """Write F of corners, from the mean gradients (24, LANES)."""
    for i in range(3):
        for lane in range(LANES):
            x, y, z = 0.0, 0.0, 0.0
            for a in range(8):
                p, g = bank[X + a * ROW + i * LANES + lane], a * ROW + lane
                x += p * gradients[g]
                y += p * gradients[g + LANES]
                z += p * gradients[g + 2 * LANES]
            to = F + i * ROW + lane
            bank[to] = x
            bank[to + LANES] = y
            bank[to + 2 * LANES] = z


@inlined()
def modes(x):
    """Return h·x of the modes ξη, ηζ, ζξ, ξηζ for numbers x of eight corners in VTK's order."""
    a, b = x[0] + x[2] - x[1] - x[3], x[4] + x[6] - x[5] - x[7]
    c, d = x[0] + x[1] - x[2] - x[3], x[4] + x[5] - x[6] - x[7]
    e, f = x[0] + x[3] - x[1] - x[2], x[4] + x[7] - x[5] - x[6]
    return a + b, c - d, e - f, b - a


@inner(linked=False)
def hourglass(bank, table):
    """Write the modal spring forces by reference volume, and subtract their part from P.

    Their energy by volume is added to the hourglass energy.
    """
    for i in range(3):
        for lane in range(LANES):
            at = X + i * LANES + lane
            h = modes((
                bank[at], bank[at + ROW], bank[at + 2 * ROW], bank[at + 3 * ROW],
                bank[at + 4 * ROW], bank[at + 5 * ROW], bank[at + 6 * ROW], bank[at + 7 * ROW],
            ))  # fmt: skip
            f, p = F + i * ROW + lane, P + i * ROW + lane
            x, y, z = bank[f], bank[f + LANES], bank[f + 2 * LANES]
            energy = 0.0
            for mode in range(4):
                t, stiffness = mode * ROW + lane, table[(STIFF + mode) * LANES + lane]
                u, v, w = table[t], table[t + LANES], table[t + 2 * LANES]
                amplitude = h[mode] - x * u - y * v - z * w
                q = stiffness * amplitude
                energy += 0.5 * q * amplitude
                bank[Q + mode * ROW + i * LANES + lane] = q
                bank[p] -= q * u
                bank[p + LANES] -= q * v
                bank[p + 2 * LANES] -= q * w
            bank[HOURGLASS_ENERGY + lane] += energy


@inner(linked=False)
def hex_forces(bank, gradients, volumes):
    """Write the forces of P and of the springs in place of the corners in the bank."""
    for i in range(3):
        for lane in range(LANES):
            v, p, q = -volumes[lane], P + i * ROW + lane, Q + i * LANES + lane
            x, y, z = v * bank[p], v * bank[p + LANES], v * bank[p + 2 * LANES]
            a, b = v * bank[q], v * bank[q + ROW]
            c, d = v * bank[q + 2 * ROW], v * bank[q + 3 * ROW]
            by_springs = (
                a + b + c - d, b + d - a - c, a - b - c - d, c + d - a - b,
                a + d - b - c, c - a - b - d, a + b + c + d, b - a - c - d,
            )  # fmt: skip
            for corner in range(8):
                g = corner * ROW + lane
                bank[X + g + i * LANES] = (
                    x * gradients[g]
                    + y * gradients[g + LANES]
                    + z * gradients[g + 2 * LANES]
                    + by_springs[corner]
                )
