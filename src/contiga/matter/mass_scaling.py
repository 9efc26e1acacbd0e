"""Mass that nodes get beside their own, so that steps may be longer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterState
from contiga.records import FloatArray

LITTLE = 1e-5
"""Strain of next to nothing."""
MARGIN = 1.02
"""On ω², for what stiffens in between."""


class AddedMass(NamedTuple):
    """What mass scaling gave the nodes of a part."""

    part: str
    mass: float
    """Of its elements."""
    added: float

    @property
    def share(self) -> float:
        """Of its own mass."""
        return self.added / self.mass


def added_to(parts: Sequence[Part], masses: FloatArray, added: FloatArray) -> tuple[AddedMass, ...]:
    """What each part was given, of masses `added` (m,) to the nodes, where parts have `masses`
    (parts, m).

    At a node that parts share, by their masses there.
    """
    more = added / masses.sum(axis=0)
    return tuple(
        AddedMass(part.name, float(own.sum()), float((own * more).sum()))
        for part, own in zip(parts, masses, strict=True)
    )


def sums_near_rest(matter: Matter) -> FloatArray:
    """(m,) row sums of the stiffness of what is pressed together or pulled by next to nothing."""
    start = matter.start()
    near = [(1.0 - LITTLE) * start.points, (1.0 + LITTLE) * start.points]
    sums = [matter.stiffness(MatterState(points, start.memory)) for points in near]
    return np.maximum(*sums)


def scaled(matter: Matter, step: float) -> FloatArray:
    """(m,) masses with which no step up to `step` is longer than the critical one at rest.

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
