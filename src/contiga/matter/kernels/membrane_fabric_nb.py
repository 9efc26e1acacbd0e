"""Woven fabric, in lanes: S₁₁ of the warp, S₂₂ of the weft and S₁₂ of the shear, a curve each.

W = w₁(E₁₁) + w₂(E₂₂) + g(2 E₁₂): the stress of a thread depends on its own strain, and is small or
zero in compression. Warp and weft may have hysteresis (`hysteresis_nb`). Curves: loading and
unloading of the warp, loading and unloading of the weft, and the shear.
"""

from __future__ import annotations

from contiga.curves.kernels.curve_nb import curve_at
from contiga.curves.kernels.hysteresis_nb import hysteretic
from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import ENERGY, HYSTERESIS, LANES
from contiga.matter.kernels.membrane_nb import put_stress, strain

W, LOST = ENERGY * LANES, HYSTERESIS * LANES
# Coefficients: thickness; for warp and weft each the modulus in compression, and the slope of
# hysteresis.
THICKNESS, COMPRESSION, SLOPE = 0, 1, 3
WARP, WEFT, SHEAR = 0, 1, 4
"""Pairs of curves, and the curve of the shear."""
REACHED = 4
MEMORY = 7
"""Strain and stress of the warp, then of the weft; from REACHED on the largest strains of warp and
weft, and the largest angle of the shear."""


@inner(linked=False)
def membrane_fabric(bank, numbers, curves, old, new):
    """Write stress S, stored energy, loss and `new` memory of fabric, from strain E and `old`."""
    t = numbers[THICKNESS]
    for lane in range(LANES):
        a, b, ab = strain(bank, lane)
        warp = hysteretic(curves, WARP, numbers[SLOPE], old[lane], old[LANES + lane], a)
        b_old, s_b_old = old[2 * LANES + lane], old[3 * LANES + lane]
        weft = hysteretic(curves, WEFT, numbers[SLOPE + 1], b_old, s_b_old, b)
        new[lane] = a
        new[LANES + lane] = warp.force
        new[2 * LANES + lane] = b
        new[3 * LANES + lane] = weft.force
        at, angle = REACHED * LANES + lane, 2.0 * abs(ab)
        new[at] = max(old[at], a)
        new[at + LANES] = max(old[at + LANES], b)
        new[at + 2 * LANES] = max(old[at + 2 * LANES], angle)
        c_a, c_b = numbers[COMPRESSION] * min(a, 0.0), numbers[COMPRESSION + 1] * min(b, 0.0)
        shear = curve_at(curves, SHEAR, angle)
        s_ab = shear.value if ab >= 0.0 else -shear.value
        compressive = 0.5 * (c_a * min(a, 0.0) + c_b * min(b, 0.0))
        bank[W + lane] = t * (warp.stored + (weft.stored + shear.integral + compressive))
        bank[LOST + lane] = t * (warp.lost + weft.lost)
        put_stress(bank, lane, t * (warp.force + c_a), t * (weft.force + c_b), t * s_ab)
