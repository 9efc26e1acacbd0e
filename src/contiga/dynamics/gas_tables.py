"""Tables of gases, openings and inflators for kernels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.curves.curve_records import Curves
from contiga.dynamics.gases import Gas, IdealGas, Mixture, parts_of
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class GasTable(NamedTuple):
    """k gases, with p polynomials of c_p over consecutive ranges of temperature."""

    constant: FloatArray
    """(k,) gas constant R, energy by mass and kelvin."""
    first: IntArray
    """(k,) first polynomial of each gas."""
    highest: FloatArray
    """(p,) highest temperature of each polynomial, kelvin; infinite for the last one of a gas."""
    coefficients: FloatArray
    """(p, d) coefficients a₀, a₁, … of c_p = Σ a_i T^i, energy by mass and kelvin."""


@pass_by_pointer
class OpeningTable(NamedTuple):
    """o openings: vents, and the leaking fabric of each chamber."""

    chamber: IntArray
    """(o,) number of the chamber."""
    neighbour: IntArray
    """(o,) row of `Contents` on the other side: another chamber, or the surroundings."""
    over_time: NDArray[np.bool_]
    """(o,) whether the area is a function of time; else of the excess pressure."""
    waits: NDArray[np.bool_]
    """(o,) whether it is shut until a trigger fires."""
    opens_at: FloatArray
    """(o,) excess pressure at which it opens for good."""
    opens_after: FloatArray
    """(o,) time before which it is shut."""
    areas: Curves
    """Effective area C A over time or excess pressure; for fabric per area of fabric."""


@pass_by_pointer
class InflatorTable(NamedTuple):
    """The tables of i inflators."""

    chamber: IntArray
    """(i,) number of the chamber that each one fills."""
    waits: NDArray[np.bool_]
    """(i,) whether a trigger fires it."""
    shares: FloatArray
    """(i, k) mass fractions of the gases."""
    rates: Curves
    """Mass flow, mass by time, over time."""
    temperatures: Curves
    """Temperature, kelvin, over time."""


@pass_by_pointer
class FlowTables(NamedTuple):
    """Gases, openings and inflators of all chambers."""

    gases: GasTable
    openings: OpeningTable
    inflators: InflatorTable


@pass_by_pointer
class Contents(NamedTuple):
    """Contents during a step, changed in place by kernels.

    The r = 2 c + 2 rows are c chambers, the surroundings of each, and two rows to work in.
    """

    masses: FloatArray
    """(r, k) mass of each gas."""
    energy: FloatArray
    """(r,) internal energy."""
    volume: FloatArray
    """(r,) volume, length³."""
    temperature: FloatArray
    """(r,) temperature by masses and energy, kelvin."""
    pressure: FloatArray
    """(c,) absolute pressure at the end of the step."""
    came: FloatArray
    """(c,) enthalpy that came in since the start."""
    left: FloatArray
    """(c,) enthalpy that went out since the start."""
    is_open: FloatArray
    """(o,) 1 for openings that have opened, else 0."""
    exposed: FloatArray
    """(o,) share of a vent that no body covers; for fabric its uncovered area."""
    opened: FloatArray
    """(o,) time at which the clock of each opening starts; infinite until its trigger fires."""
    fired: FloatArray
    """(i,) time at which the clock of each inflator starts; infinite until its trigger fires."""
    moved: FloatArray
    """(k,) masses that flow: a work array."""


def gas_table(gases: Sequence[Gas]) -> GasTable:
    """Return the table of gases for kernels; shorter polynomials are filled up with zeros."""
    first: list[int] = []
    highest: list[float] = []
    pieces: list[tuple[float, ...]] = []
    for gas in gases:
        first.append(len(highest))
        if isinstance(gas, IdealGas):
            pieces.append((gas.c_p,))
            highest.append(math.inf)
        else:
            pieces += gas.pieces
            highest += [*gas.temperatures, math.inf]
    coefficients = np.zeros((len(pieces), max(map(len, pieces), default=1)))
    for row, piece in zip(coefficients, pieces, strict=True):
        row[: len(piece)] = piece
    constants = np.array([gas.constant for gas in gases])
    return GasTable(constants, np.array(first, np.int32), np.array(highest), coefficients)


def shares_of(gases: Sequence[Gas], gas: Gas | Mixture) -> list[float]:
    """Return the mass fractions (k,) of `gases` in a gas or a mixture, 0 for those not in it."""
    fractions: Mapping[Gas, float] = dict(parts_of(gas))
    return [fractions.get(component, 0.0) for component in gases]
