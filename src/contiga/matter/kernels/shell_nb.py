"""Kirchhoff-Love shells in blocks of lanes: strains of a Gauss point, and forces of its stresses.

Kiendl et al., Isogeometric shell analysis with Kirchhoff-Love elements, CMAME 198 (2009), in axes
of the rest surface that are orthonormal at each Gauss point: F = [f₁, f₂] maps these axes to space,
a₃ = f₁ × f₂/J with J = |f₁ × f₂|, E = ½ (FᵀF − I), b_ij = f_ij·a₃, κ = B − b. A basis has five rows
for each control point I, its derivatives along these axes: G₁, G₂, H₁₁, H₂₂, H₁₂. Forces n and
moments m are by length at rest, δW = n:δE + m:δκ; with c = m_ij (f_ij − b_ij a₃)/J

    ∂W/∂x_I = G₁ (n₁₁ f₁ + n₁₂ f₂ − f₂ × c) + G₂ (n₂₂ f₂ + n₁₂ f₁ − c × f₁) − (m:H) a₃.

A membrane is a shell without moments. The forces n are in the rows of the stress S of membranes.
"""

from __future__ import annotations

import math

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import (
    ENERGY,
    GRADIENT,
    HYSTERESIS,
    LANES,
    ROWS,
    SECOND,
    STRAIN,
    STRESS,
)

MAX_CORNERS = 36
"""Control points of an element of degree 5."""
NET = 3 * MAX_CORNERS * LANES
"""Size of the control points of a block, and of the forces on them."""
INSIDE = 19
"""Number of output rows of a Gauss point."""
WIDTH = 5
"""Rows of a control point in a basis."""
# Rows of the bank beyond those of other elements.
CURVED = ROWS
"""f₁₁, f₂₂, f₁₂: nine rows."""
KAPPA, BENT, MOMENT = ROWS + 9, ROWS + 12, ROWS + 15
"""κ, b and m: 11, 22, 12."""
NORMAL, COUPLE = ROWS + 18, ROWS + 21
"""a₃ and c."""
STRETCHED = ROWS + 24
"""1/J, zero without area."""
MIDDLE, FORCE = ROWS + 25, ROWS + 28
"""E of the middle surface, and the sum n over the thickness."""
STORED, LOST = ROWS + 31, ROWS + 32
"""Sums over the thickness of the energies by area of a Gauss point."""
ALL_STORED, ALL_LOST = ROWS + 33, ROWS + 34
"""Energies of elements."""
SHELL_ROWS = ROWS + 35
SHELL_SIZE = SHELL_ROWS * LANES

F, P, E, S = GRADIENT * LANES, STRESS * LANES, STRAIN * LANES, SECOND * LANES
X, K, B, M = CURVED * LANES, KAPPA * LANES, BENT * LANES, MOMENT * LANES
N, C, R = NORMAL * LANES, COUPLE * LANES, STRETCHED * LANES
ROW = 3 * LANES


@inner(linked=False)
def clear(rows, count):
    """Set rows of a block to zero."""
    for at in range(count * LANES):
        rows[at] = 0.0


@inner(linked=False)
def shell_derivatives(net, basis, first, count, bank):
    """Write F and f₁₁, f₂₂, f₁₂ of `count` control points, whose basis begins at `first`."""
    for lane in range(LANES):
        for i in range(3):
            bank[F + i * ROW + lane] = 0.0
            bank[F + i * ROW + LANES + lane] = 0.0
            bank[X + i * LANES + lane] = 0.0
            bank[X + ROW + i * LANES + lane] = 0.0
            bank[X + 2 * ROW + i * LANES + lane] = 0.0
    for k in range(count):
        at, row = k * ROW, first + k * WIDTH * LANES
        for lane in range(LANES):
            g, x = row + lane, at + lane
            g_1, g_2 = basis[g], basis[g + LANES]
            h_11, h_22 = basis[g + 2 * LANES], basis[g + 3 * LANES]
            h_12 = basis[g + 4 * LANES]
            for i in range(3):
                place = net[x + i * LANES]
                bank[F + i * ROW + lane] += g_1 * place
                bank[F + i * ROW + LANES + lane] += g_2 * place
                bank[X + i * LANES + lane] += h_11 * place
                bank[X + ROW + i * LANES + lane] += h_22 * place
                bank[X + 2 * ROW + i * LANES + lane] += h_12 * place


@inner(linked=False)
def curvature(bank, rest, first):
    """Write a₃, 1/J, b and κ = B − b into the bank; B begins at `first` of `rest`.

    Without area a₃, 1/J and b are zero.
    """
    for lane in range(LANES):
        f = F + lane
        ax, bx = bank[f], bank[f + LANES]
        ay, by = bank[f + ROW], bank[f + ROW + LANES]
        az, bz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES]
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        area = math.sqrt(x * x + y * y + z * z)
        has_area = area > 0.0
        inverse = 1.0 / (area if has_area else 1.0)
        inverse = inverse if has_area else 0.0
        x, y, z = x * inverse, y * inverse, z * inverse
        bank[R + lane] = inverse
        bank[N + lane] = x
        bank[N + LANES + lane] = y
        bank[N + 2 * LANES + lane] = z
        for i in range(3):
            at = X + i * ROW + lane
            b = bank[at] * x + bank[at + LANES] * y + bank[at + 2 * LANES] * z
            bank[B + i * LANES + lane] = b
            bank[K + i * LANES + lane] = rest[first + i * LANES + lane] - b


@inner(linked=False)
def flat_lanes(bank):
    """Return the number of lanes whose area is zero or not finite."""
    count = 0
    for lane in range(LANES):
        count += 0 if bank[R + lane] > 0.0 else 1
    return count


@inner(linked=False)
def moments(bank, bending):
    """Write m = D κ, and add its energy to the membrane's.

    `bending` (4,) are D₁₁₁₁, D₂₂₂₂, D₁₁₂₂ and D₁₂₁₂.
    """
    d_1, d_2, d_both, shear = bending[0], bending[1], bending[2], bending[3]
    for lane in range(LANES):
        k = K + lane
        k_1, k_2, k_12 = bank[k], bank[k + LANES], bank[k + 2 * LANES]
        m_1, m_2, m_12 = d_1 * k_1 + d_both * k_2, d_both * k_1 + d_2 * k_2, 2.0 * shear * k_12
        bank[M + lane] = m_1
        bank[M + LANES + lane] = m_2
        bank[M + 2 * LANES + lane] = m_12
        bank[ENERGY * LANES + lane] += 0.5 * (m_1 * k_1 + m_2 * k_2) + m_12 * k_12


@inner(linked=False)
def begin_thickness(bank):
    """Copy E of the middle surface, and set n, m and energies to zero."""
    for lane in range(LANES):
        for i in range(3):
            bank[(MIDDLE + i) * LANES + lane] = bank[E + i * LANES + lane]
            bank[(FORCE + i) * LANES + lane] = 0.0
            bank[M + i * LANES + lane] = 0.0
        bank[STORED * LANES + lane] = 0.0
        bank[LOST * LANES + lane] = 0.0


@inner(linked=False)
def strain_at_height(bank, height):
    """Write E at a height, that of the middle surface plus height times κ."""
    for at in range(ROW):
        bank[E + at] = bank[MIDDLE * LANES + at] + height * bank[K + at]


@inner(linked=False)
def add_layer(bank, height, share):
    """Add a layer's part of n, m and energies, with its share of the thickness."""
    lever = share * height
    for at in range(ROW):
        stress = bank[S + at]
        bank[FORCE * LANES + at] += share * stress
        bank[M + at] += lever * stress
    for lane in range(LANES):
        bank[STORED * LANES + lane] += share * bank[ENERGY * LANES + lane]
        bank[LOST * LANES + lane] += share * bank[HYSTERESIS * LANES + lane]


@inner(linked=False)
def end_thickness(bank):
    """Copy n and energies to the rows of a shell without layers."""
    for at in range(ROW):
        bank[S + at] = bank[FORCE * LANES + at]
    for lane in range(LANES):
        bank[ENERGY * LANES + lane] = bank[STORED * LANES + lane]
        bank[HYSTERESIS * LANES + lane] = bank[LOST * LANES + lane]


@inner(linked=False)
def shell_stress(bank, weights, first):
    """Write the actions along f₁, f₂ and a₃, and add the energies, times weights from `first` on.

    m is overwritten with its weighted components; the twisting one is doubled.
    """
    for lane in range(LANES):
        w, inverse = weights[first + lane], bank[R + lane]
        m_1, m_2 = w * bank[M + lane], w * bank[M + LANES + lane]
        m_12 = w * bank[M + 2 * LANES + lane]
        bent = m_1 * bank[B + lane] + m_2 * bank[B + LANES + lane]
        bent += 2.0 * m_12 * bank[B + 2 * LANES + lane]
        for i in range(3):
            at = X + i * LANES + lane
            pull = m_1 * bank[at] + m_2 * bank[at + ROW] + 2.0 * m_12 * bank[at + 2 * ROW]
            bank[C + i * LANES + lane] = inverse * (pull - bent * bank[N + i * LANES + lane])
        x, y, z = bank[C + lane], bank[C + LANES + lane], bank[C + 2 * LANES + lane]
        f = F + lane
        ax, bx = bank[f], bank[f + LANES]
        ay, by = bank[f + ROW], bank[f + ROW + LANES]
        az, bz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES]
        n_1, n_2 = w * bank[S + lane], w * bank[S + LANES + lane]
        n_12 = w * bank[S + 2 * LANES + lane]
        p = P + lane
        bank[p] = n_1 * ax + n_12 * bx - (by * z - bz * y)
        bank[p + ROW] = n_1 * ay + n_12 * by - (bz * x - bx * z)
        bank[p + 2 * ROW] = n_1 * az + n_12 * bz - (bx * y - by * x)
        bank[p + LANES] = n_2 * bx + n_12 * ax - (y * az - z * ay)
        bank[p + ROW + LANES] = n_2 * by + n_12 * ay - (z * ax - x * az)
        bank[p + 2 * ROW + LANES] = n_2 * bz + n_12 * az - (x * ay - y * ax)
        bank[M + lane] = m_1
        bank[M + LANES + lane] = m_2
        bank[M + 2 * LANES + lane] = 2.0 * m_12
        bank[ALL_STORED * LANES + lane] += w * bank[ENERGY * LANES + lane]
        bank[ALL_LOST * LANES + lane] += w * bank[HYSTERESIS * LANES + lane]


@inner(linked=False)
def shell_forces(bank, basis, first, count, force):
    """Add the forces of a Gauss point on `count` control points to `force`."""
    for k in range(count):
        at, row = k * ROW, first + k * WIDTH * LANES
        for lane in range(LANES):
            g = row + lane
            g_1, g_2 = basis[g], basis[g + LANES]
            h = bank[M + lane] * basis[g + 2 * LANES]
            h += bank[M + LANES + lane] * basis[g + 3 * LANES]
            h += bank[M + 2 * LANES + lane] * basis[g + 4 * LANES]
            for i in range(3):
                p = P + i * ROW + lane
                pull = g_1 * bank[p] + g_2 * bank[p + LANES]
                force[at + i * LANES + lane] += h * bank[N + i * LANES + lane] - pull
