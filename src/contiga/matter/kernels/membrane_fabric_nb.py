"""Woven fabric, in lanes: S₁₁ of the warp, S₂₂ of the weft and S₁₂ of the shear, a curve each.

W = w₁(E₁₁) + w₂(E₂₂) + g(2 E₁₂): threads carry what their own strain says, and little or nothing
when they are pressed. Warp and weft may unload by another curve than they load (`hysteresis_nb`).
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.curve_nb import curve_at
from contiga.matter.kernels.hysteresis_nb import hysteretic
from contiga.matter.kernels.lanes_nb import ENERGY, HYSTERESIS, LANES
from contiga.matter.kernels.membrane_nb import put_stress, strain

W, LOST = ENERGY * LANES, HYSTERESIS * LANES
# Coefficients: thickness; of warp and weft the modulus when pressed, and how many points the curves
# have; those of the shear's; then K and both curves of the warp, those of the weft, the shear's.
THICKNESS, PRESSED, POINTS, SHEAR_POINTS, TABLE = 0, 1, 3, 5, 6
REACHED = 4
MEMORY = 7
"""Strain and stress of the warp, then of the weft; from REACHED on the largest strains of warp and
weft, and the largest angle of the shear."""


@inner(linked=False)
def membrane_fabric(bank, numbers, old, new):
    """S, energies and the new memory from E and the old memory."""
    t, n, m = numbers[THICKNESS], int(numbers[POINTS]), int(numbers[POINTS + 1])
    weft = TABLE + 1 + 6 * n
    shear, k = weft + 1 + 6 * m, int(numbers[SHEAR_POINTS])
    for lane in range(LANES):
        a, b, ab = strain(bank, lane)
        before = old[lane], old[LANES + lane]
        s_a, stored, lost = hysteretic(numbers, TABLE, n, a, before)
        before = old[2 * LANES + lane], old[3 * LANES + lane]
        s_b, more, away = hysteretic(numbers, weft, m, b, before)
        new[lane] = a
        new[LANES + lane] = s_a
        new[2 * LANES + lane] = b
        new[3 * LANES + lane] = s_b
        at, angle = REACHED * LANES + lane, 2.0 * abs(ab)
        new[at] = max(old[at], a)
        new[at + LANES] = max(old[at + LANES], b)
        new[at + 2 * LANES] = max(old[at + 2 * LANES], angle)
        for_a, for_b = numbers[PRESSED] * min(a, 0.0), numbers[PRESSED + 1] * min(b, 0.0)
        s_ab, sheared = curve_at(numbers, shear, k, angle)
        s_ab = s_ab if ab >= 0.0 else -s_ab
        stored += more + sheared + 0.5 * (for_a * min(a, 0.0) + for_b * min(b, 0.0))
        bank[W + lane] = t * stored
        bank[LOST + lane] = t * (lost + away)
        put_stress(bank, lane, t * (s_a + for_a), t * (s_b + for_b), t * s_ab)
