"""Saint-Venant-Kirchhoff solid, in lanes: S = λ tr(E) I + 2 μ E, W = E:S/2, P = F S."""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import ENERGY, GRADIENT, LANES, STRESS

F, P, W = GRADIENT * LANES, STRESS * LANES, ENERGY * LANES
ROW = 3 * LANES


@inner(linked=False)
def solid_elastic(bank, numbers):
    """Write P and W from F; numbers are μ and λ."""
    mu, lam = numbers[0], numbers[1]
    for lane in range(LANES):
        f = F + lane
        xx, xy, xz = bank[f], bank[f + LANES], bank[f + 2 * LANES]
        yx, yy, yz = bank[f + ROW], bank[f + ROW + LANES], bank[f + ROW + 2 * LANES]
        zx, zy, zz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES], bank[f + 2 * ROW + 2 * LANES]
        a = 0.5 * (xx * xx + yx * yx + zx * zx - 1.0)
        b = 0.5 * (xy * xy + yy * yy + zy * zy - 1.0)
        c = 0.5 * (xz * xz + yz * yz + zz * zz - 1.0)
        ab = 0.5 * (xx * xy + yx * yy + zx * zy)
        bc = 0.5 * (xy * xz + yy * yz + zy * zz)
        ca = 0.5 * (xz * xx + yz * yx + zz * zx)
        k = lam * (a + b + c)
        s_a, s_b, s_c = k + 2.0 * mu * a, k + 2.0 * mu * b, k + 2.0 * mu * c
        s_ab, s_bc, s_ca = 2.0 * mu * ab, 2.0 * mu * bc, 2.0 * mu * ca
        shear = ab * s_ab + bc * s_bc + ca * s_ca
        bank[W + lane] = 0.5 * (a * s_a + b * s_b + c * s_c) + shear
        p = P + lane
        bank[p] = xx * s_a + xy * s_ab + xz * s_ca
        bank[p + LANES] = xx * s_ab + xy * s_b + xz * s_bc
        bank[p + 2 * LANES] = xx * s_ca + xy * s_bc + xz * s_c
        p += ROW
        bank[p] = yx * s_a + yy * s_ab + yz * s_ca
        bank[p + LANES] = yx * s_ab + yy * s_b + yz * s_bc
        bank[p + 2 * LANES] = yx * s_ca + yy * s_bc + yz * s_c
        p += ROW
        bank[p] = zx * s_a + zy * s_ab + zz * s_ca
        bank[p + LANES] = zx * s_ab + zy * s_b + zz * s_bc
        bank[p + 2 * LANES] = zx * s_ca + zy * s_bc + zz * s_c
