"""Mass added to nodes: lumped masses, and mass scaling, so that steps may be longer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterState
from contiga.records import FloatArray

SMALL_STRAIN = 1e-5
"""Strain at which the stiffness near rest is computed."""
MARGIN = 1.02
"""Factor on ω² for stiffening until its next computation."""


class AddedMass(NamedTuple):
    """Mass that scaling added to the nodes of a part."""

    part: str
    mass: float
    """Mass of its elements."""
    added: float
    """Mass beyond that, by scaling."""

    @property
    def share(self) -> float:
        """Added mass as a fraction of its own."""
        return self.added / self.mass


def lumped_masses(masses: ArrayLike, n: int) -> FloatArray:
    """Return masses (n,) of nodes, checked.

    Raises
    ------
    InputError
        Another number of masses, or one that is negative or not finite.
    """
    lumped = np.asarray(real(masses, "lumped"), dtype=np.float64)
    if lumped.shape != (n,) or not (np.isfinite(lumped) & (lumped >= 0.0)).all():
        raise InputError(
            "must be masses of the nodes, 0 or more",
            where="lumped",
            found=f"shape {lumped.shape}, from {lumped.min(initial=np.inf):g}",
            allowed=f"({n},)",
        )
    return lumped


def added_to(parts: Sequence[Part], masses: FloatArray, added: FloatArray) -> tuple[AddedMass, ...]:
    """Return the mass that scaling added to each part, its share of `added` (m,) at nodes.

    Parts share the added mass of a common node in proportion to their masses there, (parts, m).
    """
    ratio = added / masses.sum(axis=0)
    return tuple(
        AddedMass(part.name, float(mass.sum()), float((mass * ratio).sum()))
        for part, mass in zip(parts, masses, strict=True)
    )


def sums_near_rest(matter: Matter) -> FloatArray:
    """Return row sums (m,) of the stiffness, the larger of small compression and small tension."""
    start = matter.start()
    compressed = MatterState((1.0 - SMALL_STRAIN) * start.points, start.memory)
    stretched = MatterState((1.0 + SMALL_STRAIN) * start.points, start.memory)
    return np.maximum(matter.stiffness(compressed), matter.stiffness(stretched))


def scaled(matter: Matter, step: float) -> FloatArray:
    """Return masses (m,) with which the critical step at rest is `step` or longer.

    By Gershgorin's theorem no vibration is faster than ω² = max Σ_j |K_ij| / m_i, and 2/ω is the
    critical step: the mass of a node is at least Σ_j |K_ij| step²/4, times `MARGIN`. No mass
    becomes smaller.

    Raises
    ------
    InputError
        A mass would not be finite.
    """
    with np.errstate(over="ignore"):
        mass = np.maximum(matter.mass, MARGIN * sums_near_rest(matter) * np.square(0.5 * step))
    if not np.isfinite(mass).all():
        raise InputError("asks for masses beyond all numbers", where="mass_scaling", found=step)
    return mass
