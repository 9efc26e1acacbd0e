"""Gases, openings and inflators of chambers as kernels take them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.gases import Gas, IdealGas, Mixture, parts_of
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


class Series(NamedTuple):
    """Values over something, linear between rows; those of the ends stay beyond them."""

    x: FloatArray
    y: FloatArray


@pass_by_pointer
class Joined(NamedTuple):
    """Tables one after the other, each a `Series`."""

    rows: IntArray
    """(n + 1,) where each begins."""
    x: FloatArray
    y: FloatArray


@pass_by_pointer
class GasTable(NamedTuple):
    """k gases, each with its c_p as polynomials one after the other."""

    constant: FloatArray
    """(k,) R, energy by mass and kelvin."""
    first: IntArray
    """(k,) the first polynomial of each."""
    highest: FloatArray
    """(p,) temperature up to which a polynomial holds, infinite of the last one of a gas."""
    coefficients: FloatArray
    """(p, d) a₀, a₁, … of c_p = Σ a_i T^i."""


@pass_by_pointer
class OpeningTable(NamedTuple):
    """o vents, and fabric that leaks."""

    here: IntArray
    """(o,) number of the chamber."""
    there: IntArray
    """(o,) row of `Contents` that it leads to: another chamber, or its surroundings."""
    over_time: NDArray[np.bool_]
    """(o,) whether the area is a table over time; else over the excess pressure."""
    waits: NDArray[np.bool_]
    """(o,) whether it is shut until a trigger fires."""
    opens_at: FloatArray
    """(o,) excess pressure from which on it is open, and stays so."""
    opens_after: FloatArray
    """(o,) time from which on it is open."""
    areas: Joined
    """C A over time or excess pressure; of fabric by its area."""


@pass_by_pointer
class InflatorTable(NamedTuple):
    """i inflators."""

    chamber: IntArray
    """(i,)."""
    waits: NDArray[np.bool_]
    """(i,) whether a trigger fires it."""
    shares: FloatArray
    """(i, k) of the gases in what comes, by mass."""
    rates: Joined
    """Mass by time over time."""
    temperatures: Joined
    """Kelvin over time."""


@pass_by_pointer
class FlowTables(NamedTuple):
    """All that says how gas flows."""

    gases: GasTable
    openings: OpeningTable
    inflators: InflatorTable


@pass_by_pointer
class Contents(NamedTuple):
    """Contents of c chambers in the course of a step, of their surroundings and two rows to work
    in: r = 2 c + 2 rows. Kernels change them in place."""

    masses: FloatArray
    """(r, k) of each gas."""
    energy: FloatArray
    """(r,) internal."""
    volume: FloatArray
    """(r,)."""
    temperature: FloatArray
    """(r,) that these masses have with this energy, kelvin."""
    pressure: FloatArray
    """(c,) at the end of the step."""
    came: FloatArray
    """(c,) enthalpy since the start."""
    left: FloatArray
    """(c,) and that went out."""
    is_open: FloatArray
    """(o,) 1 of openings that have opened."""
    exposed: FloatArray
    """(o,) share of a vent that no body covers; of fabric the area."""
    opened: FloatArray
    """(o,) times from which those of openings count, infinite before a trigger's are known."""
    fired: FloatArray
    """(i,) the same of inflators."""
    moved: FloatArray
    """(k,) masses that flow, to work in."""


def joined(tables: Sequence[Series]) -> Joined:
    """Join tables to one."""
    rows = np.cumsum([0, *(len(table.x) for table in tables)]).astype(np.int32)
    none = np.zeros(0)
    return Joined(
        rows,
        np.concatenate([none, *(table.x for table in tables)]),
        np.concatenate([none, *(table.y for table in tables)]),
    )


def gas_table(gases: Sequence[Gas]) -> GasTable:
    """Return what kernels know of gases."""
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
    """(k,) shares of `gases` in one of them, or in a mixture."""
    parts: Mapping[Gas, float] = dict(parts_of(gas))
    return [parts.get(one, 0.0) for one in gases]
