"""What a contact asks of a law of normal force, and what all such laws check and answer alike."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from contiga.errors import InputError
from contiga.records import FloatArray, LawInput, LawOutput, LawTangent


class Law(Protocol):
    """What a contact asks of a law."""

    @property
    def needs_mass(self) -> bool:
        """Whether the slave must have nodal masses."""

    @property
    def needs_thickness(self) -> bool:
        """Whether the slave must have nodal thicknesses."""

    @property
    def n_memory(self) -> int:
        """Numbers a point that the law keeps from one step to the next."""

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces, stiffnesses, stored energies and memory of the points in contact."""


def no_memory(
    force: FloatArray,
    stiffness: FloatArray,
    stored: FloatArray,
    elastic: FloatArray | None = None,
    tangent: LawTangent | None = None,
) -> LawOutput:
    """The answer of a law that remembers nothing and loses energy to the rate alone.

    `elastic` is the part of the force that is not due to the rate; all of it if None.
    """
    none = np.zeros(force.shape)
    damping = none if elastic is None else force - elastic
    memory = np.zeros((len(force), 0))
    return LawOutput(force, stiffness, stored, memory, none, damping, tangent=tangent)


def remembered(inp: LawInput, columns: int) -> FloatArray:
    """What the law left of each point (n_c, columns); zeros where the input has no memory.

    Raises
    ------
    InputError
        The memory is of another law.
    """
    wanted = (len(inp.penetration), columns)
    if inp.memory.size == 0:
        return np.zeros(wanted)
    if inp.memory.shape != wanted:
        raise InputError(
            "the memory is of another law",
            where="memory",
            found=inp.memory.shape,
            allowed=str(wanted),
        )
    return inp.memory


def critical_damping(ratio: float, stiffness: FloatArray, mass: FloatArray | None) -> FloatArray:
    """c = 2 ζ √(k m), force × time a length: ζ = 1 stops a mass on a spring without swinging.

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
