"""∂S/∂E of membranes, in lanes: the exact tangent, or an upper bound in all states.

Six rows: C₁₁₁₁, C₂₂₂₂, C₁₁₂₂, C₁₂₁₂, C₁₁₁₂ and C₂₂₁₂. With the geometric part of the current stress
the stiffness is not below the true one in any direction. A tension field along one line has the
tangent E t there and at most 2 μ t about it, not more than plane stress; threads of a fabric are
bounded by the steepest line of their curves.
"""

from __future__ import annotations

import math

from contiga.jit import inner
from contiga.matter.kernels.lanes_nb import LANES, TANGENT
from contiga.matter.kernels.membrane_nb import strain
from contiga.matter.kernels.membrane_neo_hooke_nb import square_of_area, thickness_stretch

C = TANGENT * LANES


@inner(linked=False)
def constant_tangent(bank, numbers):
    """Write four numbers, the same in all states, without coupling of shear and normal strains."""
    for lane in range(LANES):
        for row in range(4):
            bank[C + row * LANES + lane] = numbers[row]
        bank[C + 4 * LANES + lane] = 0.0
        bank[C + 5 * LANES + lane] = 0.0


@inner(linked=False)
def neo_hooke_tangent(bank, numbers):
    """Write ∂S/∂E of S = μ I + k C⁻¹, k = λ (j − 1) j − μ: u C⁻¹⊗C⁻¹ − 2 k (C⁻¹⊗C⁻¹ in pairs).

    u = a ∂k/∂a = λ (2 j − 1) a j′, with a j′ from (μ + λ a²) j² = (λ j + μ) a².
    """
    mu, lam = numbers[0], numbers[1]
    for lane in range(LANES):
        e_a, e_b, e_ab = strain(bank, lane)
        a, b, ab = 2.0 * e_a + 1.0, 2.0 * e_b + 1.0, 2.0 * e_ab
        square, has_area = square_of_area(a, b, ab)
        area = math.sqrt(square)
        j = area * thickness_stretch(square, area, mu, lam)
        k = lam * (j - 1.0) * j - mu
        change = 2.0 * square * (mu + lam * j * (1.0 - j))
        u = lam * (2.0 * j - 1.0) * change / (2.0 * (mu + lam * square) * j - lam * square)
        p, q, r = b / square, a / square, -ab / square
        u, k = (u if has_area else 0.0), (k if has_area else 0.0)
        bank[C + lane] = (u - 2.0 * k) * p * p
        bank[C + LANES + lane] = (u - 2.0 * k) * q * q
        bank[C + 2 * LANES + lane] = u * p * q - 2.0 * k * r * r
        bank[C + 3 * LANES + lane] = u * r * r - k * (p * q + r * r)
        bank[C + 4 * LANES + lane] = (u - 2.0 * k) * p * r
        bank[C + 5 * LANES + lane] = (u - 2.0 * k) * q * r


@inner()
def membrane_tangent(bank, tangent, numbers):
    """Write the constant tangent of a material if it has one, else the Neo-Hookean tangent."""
    if len(tangent) > 0:
        constant_tangent(bank, tangent)
    else:
        neo_hooke_tangent(bank, numbers)
