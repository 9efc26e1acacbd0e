"""Mass scaling: mass added to nodes so that steps may be longer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterState
from contiga.records import FloatArray

SMALL_STRAIN = 1e-5
"""Strain at which matter near rest is measured."""
MARGIN = 1.02
"""Factor on ω² for matter that stiffens between."""


class AddedMass(NamedTuple):
    """Mass that scaling added to the nodes of a part."""

    part: str
    mass: float
    """Mass of its elements."""
    added: float

    @property
    def share(self) -> float:
        """Added mass as a fraction of its own."""
        return self.added / self.mass


def added_to(parts: Sequence[Part], masses: FloatArray, added: FloatArray) -> tuple[AddedMass, ...]:
    """Return the mass that scaling added to each part, its share of `added` (m,) at nodes.

    Parts that share a node share its added mass by their masses there.
    """
    more = added / masses.sum(axis=0)
    return tuple(
        AddedMass(part.name, float(own.sum()), float((own * more).sum()))
        for part, own in zip(parts, masses, strict=True)
    )


def sums_near_rest(matter: Matter) -> FloatArray:
    """Return row sums (m,) of the stiffness, the larger of small compression and small tension."""
    start = matter.start()
    near = [(1.0 - SMALL_STRAIN) * start.points, (1.0 + SMALL_STRAIN) * start.points]
    sums = [matter.stiffness(MatterState(points, start.memory)) for points in near]
    return np.maximum(*sums)


def scaled(matter: Matter, step: float) -> FloatArray:
    """Return masses (m,) with which no step up to `step` is longer than the critical one at rest.

    By Gershgorin's theorem no vibration is faster than ω² = max Σ_j |K_ij| / m_i, and 2/ω is the
    critical step: a node has at least Σ_j |K_ij| step²/4.

    Raises
    ------
    InputError
        A mass would not be finite.
    """
    with np.errstate(over="ignore"):
        heavy = np.maximum(matter.mass, MARGIN * sums_near_rest(matter) * np.square(0.5 * step))
    if not np.isfinite(heavy).all():
        raise InputError("asks for masses beyond all numbers", where="mass_scaling", found=step)
    return heavy
