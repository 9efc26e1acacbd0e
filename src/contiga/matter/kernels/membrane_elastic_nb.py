"""Plane stress of membranes, in lanes: linear in Green's strain, with and without compression.

With c = E t/(1 − ν²): S₁₁ = c (E₁₁ + ν E₂₂), S₁₂ = c (1 − ν) E₁₂, W = E:S/2. One that carries
no compression has the relaxed energy of its principal strains E₁ ≥ E₂ (tension field; Pipkin, IMA
J. Appl. Math. 36, 1986): zero if E₁ ≤ 0, E t E₁²/2 if E₂ < −ν E₁, else that of plane stress.
"""

from __future__ import annotations

import math

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import ENERGY, LANES
from contiga.matter.kernels.membrane_nb import put_stress, strain

W = ENERGY * LANES


@inner(linked=False)
def membrane_elastic(bank, numbers):
    """Write S and W from E; numbers are E t and ν."""
    nu = numbers[1]
    c = numbers[0] / (1.0 - nu * nu)
    for lane in range(LANES):
        a, b, ab = strain(bank, lane)
        s_a, s_b, s_ab = c * (a + nu * b), c * (b + nu * a), c * (1.0 - nu) * ab
        bank[W + lane] = 0.5 * (a * s_a + b * s_b) + ab * s_ab
        put_stress(bank, lane, s_a, s_b, s_ab)


@inner(linked=False)
def membrane_slack(bank, numbers):
    """Write S and W of a tension field, from E; numbers are E t and ν."""
    e_t, nu = numbers[0], numbers[1]
    c = e_t / (1.0 - nu * nu)
    for lane in range(LANES):
        a, b, ab = strain(bank, lane)
        half, mean = 0.5 * (a - b), 0.5 * (a + b)
        radius = math.sqrt(half * half + ab * ab)
        first, second = mean + radius, mean - radius
        is_slack, is_uniaxial = first <= 0.0, second < -nu * first
        s_1 = e_t * first if is_uniaxial else c * (first + nu * second)
        s_2 = 0.0 if is_uniaxial else c * (second + nu * first)
        s_1, s_2 = (0.0 if is_slack else s_1), (0.0 if is_slack else s_2)
        # S is its mean plus a deviator in the directions of E's deviator.
        ratio = 0.5 * (s_1 - s_2) / (radius if radius > 0.0 else 1.0)
        mean_s = 0.5 * (s_1 + s_2)
        bank[W + lane] = 0.5 * (s_1 * first + s_2 * second)
        put_stress(bank, lane, mean_s + ratio * half, mean_s - ratio * half, ratio * ab)
