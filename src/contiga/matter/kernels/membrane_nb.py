"""Triangles of membranes in blocks of lanes: their gradient, and forces from their stress.

F (3, 2) maps the plane of a triangle at rest to space; its rows use the first two of the three
places of a solid's rows. Stress and energy are by area, and include the thickness.
"""

from __future__ import annotations

from contiga.jit import inlined, inner
from contiga.matter.kernels.lanes_nb import CORNER_ROWS, GRADIENT, LANES, SECOND, STRAIN, STRESS

F, P, E, S = GRADIENT * LANES, STRESS * LANES, STRAIN * LANES, SECOND * LANES
ROW, CORNER = 3 * LANES, 3 * LANES
X = CORNER_ROWS * LANES


@inner(linked=False)
def triangle_gradient(bank, gradients):
    """Write F of triangles, from the gradients (4, LANES) of all corners but the first."""
    for lane in range(LANES):
        for i in range(3):
            at = X + i * LANES + lane
            x = bank[at]
            a, b = bank[at + CORNER] - x, bank[at + 2 * CORNER] - x
            for j in range(2):
                g = j * LANES + lane
                bank[F + i * ROW + g] = a * gradients[g] + b * gradients[2 * LANES + g]


@inner(linked=False)
def green_strain(bank):
    """Write Green's strain E = ½ (FᵀF − I)."""
    for lane in range(LANES):
        f = F + lane
        xa, xb = bank[f], bank[f + LANES]
        ya, yb = bank[f + ROW], bank[f + ROW + LANES]
        za, zb = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES]
        bank[E + lane] = 0.5 * (xa * xa + ya * ya + za * za - 1.0)
        bank[E + LANES + lane] = 0.5 * (xb * xb + yb * yb + zb * zb - 1.0)
        bank[E + 2 * LANES + lane] = 0.5 * (xa * xb + ya * yb + za * zb)


@inlined()
def strain(bank, lane):
    """Return E₁₁, E₂₂ and E₁₂ of a lane."""
    return bank[E + lane], bank[E + LANES + lane], bank[E + 2 * LANES + lane]


@inlined()
def put_stress(bank, lane, s_a, s_b, s_ab):
    """Write S₁₁, S₂₂ and S₁₂ of a lane."""
    bank[S + lane] = s_a
    bank[S + LANES + lane] = s_b
    bank[S + 2 * LANES + lane] = s_ab


@inner(linked=False)
def first_stress(bank):
    """Write P = F S."""
    for lane in range(LANES):
        s_a, s_b, s_ab = bank[S + lane], bank[S + LANES + lane], bank[S + 2 * LANES + lane]
        for i in range(3):
            f, p = F + i * ROW + lane, P + i * ROW + lane
            a, b = bank[f], bank[f + LANES]
            bank[p] = a * s_a + b * s_ab
            bank[p + LANES] = a * s_ab + b * s_b


@inner(linked=False)
def triangle_forces(bank, gradients, areas):
    """Write the forces of the stress P on the corners in place of the corners in the bank."""
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
