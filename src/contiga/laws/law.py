"""The protocol of laws of normal force, and their common checks and outputs."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from contiga.errors import InputError
from contiga.records import FloatArray, LawInput, LawOutput, LawTangent


class Law(Protocol):
    """A law of normal force as a contact uses it."""

    @property
    def needs_mass(self) -> bool:
        """True if the slave must have nodal masses."""

    @property
    def needs_thickness(self) -> bool:
        """True if the slave must have nodal thicknesses."""

    @property
    def n_memory(self) -> int:
        """Number of values by point that the law keeps from one step to the next."""

    def respond(self, inp: LawInput) -> LawOutput:
        """Return forces, stiffnesses, stored energies and memory of the points in contact."""


def no_memory(
    force: FloatArray,
    stiffness: FloatArray,
    stored: FloatArray,
    elastic: FloatArray | None = None,
    tangent: LawTangent | None = None,
) -> LawOutput:
    """Return the output of a law without memory that loses energy to the rate alone.

    `elastic` is the part of the force that is not due to the rate; all of it if None.
    """
    none = np.zeros(force.shape)
    damping = none if elastic is None else force - elastic
    memory = np.zeros((len(force), 0))
    return LawOutput(force, stiffness, stored, memory, none, damping, tangent=tangent)


def remembered(inp: LawInput, columns: int) -> FloatArray:
    """Return the memory (n_c, columns) of the points, not a copy; zeros if it is empty.

    Raises
    ------
    InputError
        The memory has another number of columns.
    """
    shape = (len(inp.penetration), columns)
    if inp.memory.size == 0:
        return np.zeros(shape)
    if inp.memory.shape != shape:
        raise InputError(
            "the memory is of another law",
            where="memory",
            found=inp.memory.shape,
            allowed=str(shape),
        )
    return inp.memory


def critical_damping(ratio: float, stiffness: FloatArray, mass: FloatArray | None) -> FloatArray:
    """Return c = 2 ζ √(k m) (n,), force × time / length; ζ = 1 is critical damping.

    A negative stiffness counts as zero.

    Parameters
    ----------
    ratio : ζ, share of the critical damping
    stiffness, mass : (n,) k and m of each point

    Raises
    ------
    InputError
        There are no masses.
    """
    if mass is None:
        raise InputError(
            "a share of critical damping needs nodal masses and the slave has none",
            where="damping_ratio",
            remedy="Give the slave a mass, or the law an absolute damping",
        )
    return np.asarray(2.0 * ratio * np.sqrt(np.maximum(stiffness, 0.0) * mass))
