"""Tetrahedra in blocks of lanes: the gradient of a deformation, and forces from its stress.

F = Σ x_a ⊗ G_a with the gradients G_a of the corners' shape functions at rest, and the force on a
corner is −V P G_a (Belytschko, Liu, Moran and Elkhodary, Nonlinear Finite Elements, 4.9).
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import (
    CORNER_ROWS,
    GRADIENT,
    LANES,
    PRESSURE,
    STRESS,
    STRETCH,
)

F, P, J = GRADIENT * LANES, STRESS * LANES, STRETCH * LANES
ROW, CORNER = 3 * LANES, 3 * LANES
X = CORNER_ROWS * LANES


@inner(linked=False)
def tet_gradient(bank, gradients):
    """Write F of corners, from the gradients (9, LANES) of all but the first."""
    for lane in range(LANES):
        for i in range(3):
            at = X + i * LANES + lane
            x = bank[at]
            a, b, c = bank[at + CORNER] - x, bank[at + 2 * CORNER] - x, bank[at + 3 * CORNER] - x
            for j in range(3):
                g = j * LANES + lane
                bank[F + i * ROW + g] = (
                    a * gradients[g] + b * gradients[ROW + g] + c * gradients[2 * ROW + g]
                )


@inner(linked=False)
def determinant(bank):
    """Write J = det F."""
    for lane in range(LANES):
        at = F + lane
        xx, xy, xz = bank[at], bank[at + LANES], bank[at + 2 * LANES]
        yx, yy, yz = bank[at + ROW], bank[at + ROW + LANES], bank[at + ROW + 2 * LANES]
        zx, zy, zz = bank[at + 2 * ROW], bank[at + 2 * ROW + LANES], bank[at + 2 * ROW + 2 * LANES]
        bank[J + lane] = (
            xx * (yy * zz - yz * zy) + xy * (yz * zx - yx * zz) + xz * (yx * zy - yy * zx)
        )


@inner(linked=False)
def tet_forces(bank, gradients, volumes):
    """Write the forces of the stress P on the corners in place of the corners in the bank."""
    for lane in range(LANES):
        v = -volumes[lane]
        for i in range(3):
            at = P + i * ROW + lane
            x, y, z = v * bank[at], v * bank[at + LANES], v * bank[at + 2 * LANES]
            g = lane
            a = x * gradients[g] + y * gradients[g + LANES] + z * gradients[g + 2 * LANES]
            g += ROW
            b = x * gradients[g] + y * gradients[g + LANES] + z * gradients[g + 2 * LANES]
            g += ROW
            c = x * gradients[g] + y * gradients[g + LANES] + z * gradients[g + 2 * LANES]
            to = X + i * LANES + lane
            bank[to] = -(a + b + c)
            bank[to + CORNER] = a
            bank[to + 2 * CORNER] = b
            bank[to + 3 * CORNER] = c


@inner(linked=False)
def quarter_volumes(bank, volumes):
    """Write a quarter of the present volume in place of the x of each corner."""
    for lane in range(LANES):
        quarter = 0.25 * volumes[lane] * bank[J + lane]
        for a in range(4):
            bank[X + a * CORNER + lane] = quarter


@inner(linked=False)
def mean_pressure(bank, pressures, nodes):
    """Write the mean of the corners' pressures."""
    for lane in range(LANES):
        total = pressures[nodes[0, lane]] + pressures[nodes[1, lane]]
        total += pressures[nodes[2, lane]] + pressures[nodes[3, lane]]
        bank[PRESSURE * LANES + lane] = 0.25 * total
