"""Triangles of membranes in blocks of lanes: their gradient, and forces from their stress.

F (3, 2) leads from the plane of a triangle at rest to space; its rows take the first two of the
three places that those of a solid have. Stress and energy are by area: the thickness is in them.
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import CORNERS, GRADIENT, LANES, STRESS

F, P = GRADIENT * LANES, STRESS * LANES
ROW, CORNER = 3 * LANES, 3 * LANES
X = CORNERS * LANES


@inner(linked=False)
def triangle_gradient(bank, gradients):
    """F of corners, from the gradients (4, LANES) of all but the first."""
    for lane in range(LANES):
        for i in range(3):
            at = X + i * LANES + lane
            x = bank[at]
            a, b = bank[at + CORNER] - x, bank[at + 2 * CORNER] - x
            for j in range(2):
                g = j * LANES + lane
                bank[F + i * ROW + g] = a * gradients[g] + b * gradients[2 * LANES + g]


@inner(linked=False)
def triangle_forces(bank, gradients, areas):
    """Forces of the stress P on the corners, in place of the corners."""
    for lane in range(LANES):
        v, g = -areas[lane], lane
        for i in range(3):
            at = P + i * ROW + lane
            x, y = v * bank[at], v * bank[at + LANES]
            a = x * gradients[g] + y * gradients[g + LANES]
            b = x * gradients[g + 2 * LANES] + y * gradients[g + 3 * LANES]
            to = X + i * LANES + lane
            bank[to] = -(a + b)
            bank[to + CORNER] = a
            bank[to + 2 * CORNER] = b
