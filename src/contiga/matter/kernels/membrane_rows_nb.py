"""Row sums of the stiffness of triangles, in lanes: K_ab = A (F D_ab Fᵀ + s_ab I).

D_ab = G_a·C·G_b with C = ∂S/∂E is the material part, s_ab = G_a·S·G_b the geometric part. Corners
1 and 2 have three pairs; the gradient of the first corner is minus the sum of theirs.
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import CORNER_ROWS, GRADIENT, LANES, SECOND, TANGENT

F, S, C = GRADIENT * LANES, SECOND * LANES, TANGENT * LANES
X, ROW, NINE = CORNER_ROWS * LANES, 3 * LANES, 9 * LANES
PAIRS = 3 * NINE
"""K of the pairs (1, 1), (1, 2) and (2, 2)."""


@inner(linked=False)
def pair_stiffness(bank, gradients, pair, out):
    """Write K/A (9, LANES) of pair 0, 1 or 2 into `out`: corners (1, 1), (1, 2) or (2, 2)."""
    row_1, row_2 = 2 * LANES * (pair // 2), 2 * LANES * ((pair + 1) // 2)
    for lane in range(LANES):
        # The four numbers of D, and s.
        a, b = gradients[row_1 + lane], gradients[row_1 + LANES + lane]
        c, d = gradients[row_2 + lane], gradients[row_2 + LANES + lane]
        ac, ad, bc, bd = a * c, a * d, b * c, b * d
        at = C + lane
        c_1, c_2, c_both = bank[at], bank[at + LANES], bank[at + 2 * LANES]
        shear, with_1, with_2 = bank[at + 3 * LANES], bank[at + 4 * LANES], bank[at + 5 * LANES]
        s = ac * bank[S + lane] + bd * bank[S + LANES + lane]
        s += (ad + bc) * bank[S + 2 * LANES + lane]
        d_11 = ac * c_1 + (ad + bc) * with_1 + bd * shear
        d_12 = ac * with_1 + ad * c_both + bc * shear + bd * with_2
        d_21 = ac * with_1 + ad * shear + bc * c_both + bd * with_2
        d_22 = ac * shear + (ad + bc) * with_2 + bd * c_2
        for i in range(3):
            at = F + i * ROW + lane
            x = bank[at] * d_11 + bank[at + LANES] * d_21
            y = bank[at] * d_12 + bank[at + LANES] * d_22
            for j in range(3):
                g = F + j * ROW + lane
                k = x * bank[g] + y * bank[g + LANES]
                out[(3 * i + j) * LANES + lane] = k + s if i == j else k


@inner(linked=False)
def triangle_sums(bank, pairs, areas):
    """Write Σ|K| of each row of all corners in place of the corners in the bank.

    `pairs` are the three of `pair_stiffness`, one after the other.
    """
    for lane in range(LANES):
        area = areas[lane]
        for i in range(3):
            first, second, third = 0.0, 0.0, 0.0
            for j in range(3):
                k, t = (3 * i + j) * LANES + lane, (3 * j + i) * LANES + lane
                k_22, k_23, k_32 = pairs[k], pairs[NINE + k], pairs[NINE + t]
                k_33 = pairs[2 * NINE + k]
                first += abs(k_22 + k_32) + abs(k_23 + k_33) + abs(k_22 + k_23 + k_32 + k_33)
                second += abs(k_22 + k_23) + abs(k_22) + abs(k_23)
                third += abs(k_32 + k_33) + abs(k_32) + abs(k_33)
            at = X + i * LANES + lane
            bank[at] = area * first
            bank[at + ROW] = area * second
            bank[at + 2 * ROW] = area * third
