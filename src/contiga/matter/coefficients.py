"""Coefficients of materials for kernels, and checks of their numbers."""

from __future__ import annotations

from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from contiga.arrays.layout import real
from contiga.curves.curve_records import NO_CURVES, Curves
from contiga.errors import InputError
from contiga.records import FloatArray

SOLIDS = ("tet4", "hex8")
NONE = np.zeros(0)


class Reach(NamedTuple):
    """A table of a material, and the column of the memory with its largest strain."""

    what: str
    """Name of its strain for messages."""
    end: float
    """Strain of its last row."""
    column: int
    """Column of the memory of an element."""

    @classmethod
    def of(cls, what: str, table: FloatArray, column: int) -> tuple[Reach, ...]:
        """Return the reach of a table (n, 2), or nothing for a straight line, which has no end."""
        return () if len(table) == 2 else (cls(what, float(table[-1, 0]), column),)


class Coefficients(NamedTuple):
    """Coefficients of a material for kernels."""

    material: int
    """Number of the material in the kernels `elements_stress_nb`."""
    numbers: FloatArray
    """(c,) coefficients, in the order of the material's kernel."""
    modulus: float
    """Young's modulus at rest, for hourglass stiffness."""
    wave_modulus: float
    """Modulus of pressure waves at rest, λ + 2 μ."""
    tangent: FloatArray = NONE
    """(4,) for membranes: C₁₁₁₁, C₂₂₂₂, C₁₁₂₂, C₁₂₁₂ of an upper bound of ∂S/∂E in all states, for
    the critical step; (0,) if the tangent of the state is used."""
    bending: FloatArray = NONE
    """(4,) for shells: the same components at small strains, for bending; (0,) for a material that
    is integrated layer by layer through the thickness."""
    memory: int = 0
    """Number of history variables of an element."""
    averaged: float = 0.0
    """λ of the change of volume that is averaged at nodes; 0 without averages."""
    reaches: tuple[Reach, ...] = ()
    """Its tables, with the strains at their ends."""
    curves: Curves = NO_CURVES
    """Its tables for kernels."""


class Material(Protocol):
    """A material of elements."""

    kinds: ClassVar[tuple[str, ...]]
    """Kinds of elements that it is for."""

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """Return the coefficients for elements of a kind.

        `across` is the thickness of a membrane, the section of a bar, or 1 for a solid.
        """


def poisson_ratio(value: object, name: str) -> float:
    """Return `value` as a Poisson's ratio; raise `InputError` unless above −1 and below ½."""
    allowed = "a number above -1 and below 0.5"
    try:
        number = float(real(value))
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not -1.0 < number < 0.5:
        raise InputError(
            "Poisson's ratio of what can be pressed together is below a half",
            where=name,
            found=value,
            allowed=allowed,
            remedy="For rubber take 0.49 to 0.499, and volume='nodes' for tetrahedra",
        )
    return number


def lame(young: float, poisson: float) -> tuple[float, float]:
    """Return Lamé's parameters μ and λ."""
    mu = 0.5 * young / (1.0 + poisson)
    return mu, 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
