"""Neo-Hookean membrane, in lanes: the solid's energy, minimal over the stretch s of the thickness.

With a the ratio of areas, W = μ/2 (tr C + s² − 3) − μ ln(a s) + λ/2 (a s − 1)² is minimal for
(μ + λ a²) s² − λ a s − μ = 0, which has one positive root; S = ∂W/∂E at that s. A triangle without
area, whose W is unbounded, has no stress.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner
from contiga.matter.kernels.lanes_nb import ENERGY, LANES
from contiga.matter.kernels.membrane_nb import put_stress, strain
from contiga.matter.kernels.solid_neo_hooke_nb import log_series

W = ENERGY * LANES
FLAT = 1e-14
"""Squared area over the product of squared edges below which the area is rounding."""


@inlined()
def thickness_stretch(square, area, mu, lam):
    """Return the stretch s of the thickness for `area`, a ratio of areas, and its `square`."""
    c = mu + lam * square
    return 0.5 * (lam * area + math.sqrt(lam * lam * square + 4.0 * mu * c)) / c


@inlined()
def square_of_area(a, b, ab):
    """Return the squared area of the metric a, b, ab and True; 1 and False if it has no area."""
    square = a * b - ab * ab
    has_area = square > FLAT * a * b
    return (square if has_area else 1.0), has_area


@inner(linked=False)
def membrane_neo_hooke(bank, numbers):
    """Write S and W from E, zero without area; numbers are μ t and λ t."""
    mu, lam = numbers[0], numbers[1]
    for lane in range(LANES):
        e_a, e_b, e_ab = strain(bank, lane)
        a, b, ab = 2.0 * e_a + 1.0, 2.0 * e_b + 1.0, 2.0 * e_ab
        square, has_area = square_of_area(a, b, ab)
        area = math.sqrt(square)
        s = thickness_stretch(square, area, mu, lam)
        j = area * s
        # ∂W/∂a = λ (a s − 1) s − μ/a, and ∂a/∂E = a C⁻¹
        k = (lam * (j - 1.0) * j - mu) / square
        is_far = j > 2.0 or j < 0.5
        root = math.sqrt(math.sqrt(math.sqrt(j))) if is_far else j
        log = log_series((root - 1.0) / (root + 1.0)) * (8.0 if is_far else 1.0)
        energy = 0.5 * mu * (2.0 * (e_a + e_b) + s * s - 1.0) - mu * log
        energy += 0.5 * lam * (j - 1.0) * (j - 1.0)
        bank[W + lane] = energy if has_area else 0.0
        m, k = (mu if has_area else 0.0), (k if has_area else 0.0)
        put_stress(bank, lane, m + k * b, m + k * a, -k * ab)
