"""Ideal gases, p v = R T, with constant or temperature-dependent heat capacity, and their mixtures.

Internal energies and enthalpies count from 0 K, with a constant heat capacity below the lowest
temperature of a table. Only their differences matter, which do not depend on this choice.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import check_types, positive, real
from contiga.curves.tables import table_of
from contiga.errors import InputError

SHARE_TOL = 1e-6
"""Tolerance of the sum of the shares of a mixture."""
N_SAMPLES = 257
"""Number of temperatures at which a polynomial is checked."""


@dataclass(frozen=True)
class IdealGas:
    """A gas of constant heat capacities.

    Parameters
    ----------
    gamma : c_p / c_v, above 1
    constant : R of this gas, energy by mass and kelvin: 287.05 J/(kg K) of air
    """

    gamma: float
    constant: float

    def __post_init__(self) -> None:
        if not positive(self.gamma, "gamma") > 1.0:
            raise InputError("must be above 1", where="gamma", found=self.gamma, allowed="> 1")
        positive(self.constant, "constant")

    @property
    def c_v(self) -> float:
        """Heat capacity at constant volume, energy by mass and kelvin."""
        return self.constant / (self.gamma - 1.0)

    @property
    def c_p(self) -> float:
        """Heat capacity at constant pressure."""
        return self.gamma * self.c_v

    def heat_capacity(self, temperature: float) -> float:
        """Return c_p, the same at all temperatures."""
        return self.c_p

    def enthalpy(self, temperature: float) -> float:
        """Return ∫ c_p dT from 0 K, energy by mass."""
        return self.c_p * temperature

    def entropy(self, start: float, end: float) -> float:
        """Return ∫ c_p/T dT between two temperatures, energy by mass and kelvin."""
        return self.c_p * math.log(end / start)


@dataclass(frozen=True, init=False)
class ThermallyPerfectGas:
    """A gas whose heat capacity depends on its temperature alone.

    Parameters
    ----------
    constant : R of this gas, energy by mass and kelvin
    c_p : rows T, c_p, linear between them; or coefficients a₀, a₁, … of c_p = Σ a_i T^i
    between : lowest and highest temperature of the polynomial; a table has its own. Beyond them c_p
        is constant

    Raises
    ------
    InputError
        A heat capacity that is not above R at a row of the table, or at one of `N_SAMPLES`
        temperatures of a polynomial; a polynomial without its temperatures, a table with them.

    Examples
    --------
    >>> nitrogen = ThermallyPerfectGas(296.8, [[300.0, 1040.0], [1000.0, 1167.0], [2000.0, 1284.0]])
    >>> round(nitrogen.heat_capacity(650.0), 1)
    1103.5
    """

    constant: float
    temperatures: tuple[float, ...]
    """(k,) breakpoints, kelvin."""
    pieces: tuple[tuple[float, ...], ...]
    """Coefficients below the first breakpoint, between each two, and above the last."""

    def __init__(
        self, constant: float, c_p: ArrayLike, *, between: tuple[float, float] | None = None
    ) -> None:
        put = object.__setattr__
        put(self, "constant", positive(constant, "constant"))
        values = np.asarray(real(c_p, "c_p"), dtype=np.float64)
        if values.ndim == 1 and len(values):
            ends: tuple[float, ...] = ()
            if between is not None:
                ends = tuple(float(t) for t in np.ravel(real(between, "between")))
            if len(ends) != 2 or not 0.0 < ends[0] < ends[1] < math.inf:
                raise InputError(
                    "a polynomial holds between two temperatures",
                    where="between",
                    found=between,
                    allowed="(lowest, highest), kelvin",
                )
            inner = [tuple(values.tolist())]
        else:
            table = table_of(values, ("T", "c_p"))
            if between is not None:
                raise InputError("a table has its own temperatures", where="between", found=between)
            ends = tuple(table[:, 0].tolist())
            slopes = (np.diff(table[:, 1]) / np.diff(table[:, 0])).tolist()
            inner = [(c - s * t, s) for (t, c), s in zip(table.tolist(), slopes, strict=False)]
            if not inner:
                inner, ends = [(float(table[0, 1]),)], (ends[0], ends[0])
        first, last = _polynomial(inner[0], ends[0]), _polynomial(inner[-1], ends[-1])
        put(self, "temperatures", ends)
        put(self, "pieces", ((first,), *inner, (last,)))
        if not ends[0] > 0.0:
            raise InputError("must be above 0 K", where="c_p: temperature", found=ends[0])
        samples = ends if values.ndim == 2 else np.linspace(ends[0], ends[1], N_SAMPLES).tolist()
        for t in samples:
            if not math.inf > self.heat_capacity(t) > self.constant:
                raise InputError(
                    "must be above the gas constant",
                    where=f"c_p at {t:.6g} K",
                    found=self.heat_capacity(t),
                    allowed=f"> {self.constant:g}: c_v = c_p − R is above zero",
                )

    def heat_capacity(self, temperature: float) -> float:
        """Return c_p at a temperature, energy by mass and kelvin; constant beyond both ends."""
        piece = self.pieces[bisect_right(self.temperatures, temperature)]
        return _polynomial(piece, temperature)

    def enthalpy(self, temperature: float) -> float:
        """Return ∫ c_p dT from 0 K, energy by mass."""
        total, low = 0.0, 0.0
        for piece, high in zip(self.pieces, (*self.temperatures, math.inf), strict=True):
            end = min(temperature, high)
            total += _primitive(piece, end) - _primitive(piece, low)
            if temperature <= high:
                break
            low = high
        return total

    def entropy(self, start: float, end: float) -> float:
        """Return ∫ c_p/T dT between two temperatures, energy by mass and kelvin.

        It is negative if `end` is below `start`.
        """
        if end < start:
            return -self.entropy(end, start)
        total, low = 0.0, start
        for piece, high in zip(self.pieces, (*self.temperatures, math.inf), strict=True):
            if high <= low:
                continue
            top = min(end, high)
            powers = [c / k for k, c in enumerate(piece) if k > 0]
            total += piece[0] * math.log(top / low)
            total += top * _polynomial(powers, top) - low * _polynomial(powers, low)
            if end <= high:
                break
            low = high
        return total


Gas = IdealGas | ThermallyPerfectGas


@dataclass(frozen=True, init=False)
class Mixture:
    """A mixture of gases by mass fractions.

    Parameters
    ----------
    parts : (gas, share) pairs; the shares sum to one within `SHARE_TOL`, and are scaled to do so
        exactly

    Raises
    ------
    InputError
        No gases, the same gas twice, shares that are not positive or do not sum to one.
    """

    parts: tuple[tuple[Gas, float], ...]

    def __init__(self, parts: Sequence[tuple[Gas, float]]) -> None:
        gases = tuple(gas for gas, _ in parts)
        check_types(
            Gas, gases, "mixture", "must be a gas", "contiga.gas.IdealGas, ThermallyPerfectGas"
        )
        shares = [positive(share, f"mixture[{k}]: share") for k, (_, share) in enumerate(parts)]
        total = sum(shares)
        if not abs(total - 1.0) <= SHARE_TOL:
            raise InputError(
                "the shares of a mixture sum up to one",
                where="mixture",
                found=total,
                allowed="1, by mass",
            )
        if len(set(gases)) < len(gases):
            raise InputError("has the same gas twice", where="mixture", found=gases)
        pairs = zip(gases, shares, strict=True)
        object.__setattr__(self, "parts", tuple((gas, share / total) for gas, share in pairs))

    @property
    def constant(self) -> float:
        """R of the mixture."""
        return sum(share * gas.constant for gas, share in self.parts)


GASES = "contiga.gas.IdealGas, ThermallyPerfectGas or Mixture"


def parts_of(gas: Gas | Mixture) -> tuple[tuple[Gas, float], ...]:
    """Return the components of a gas or a mixture, with their mass fractions."""
    return gas.parts if isinstance(gas, Mixture) else ((gas, 1.0),)


def _polynomial(coefficients: Sequence[float], x: float) -> float:
    value = 0.0
    for c in reversed(coefficients):
        value = value * x + c
    return value


def _primitive(coefficients: Sequence[float], x: float) -> float:
    """Return the integral of a polynomial from 0."""
    return x * _polynomial([c / (k + 1) for k, c in enumerate(coefficients)], x)
