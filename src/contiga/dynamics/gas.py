"""Gas of uniform pressure in chambers: inflators, vents between chambers and to the surroundings.

A chamber holds ideal gases of constant heat capacities, mixed, at one pressure and temperature:

    dU = Σ ṁ_in c_p T_in dt − ṁ_out c_p T dt − p dV,    p V = Σ m_k R_k T,    U = Σ m_k c_v,k T

(Wang & Nefske, SAE 880654). Through an opening of area A goes ṁ = C A p √(2γ/((γ−1) R T)
(π^{2/γ} − π^{(γ+1)/γ})) with π the ratio of the pressures after and before it, and no less than
that at which the flow is as fast as sound, (2/(γ+1))^{γ/(γ−1)}.

A step is split (Strang 1968): half of the change of volume, adiabatic and exact; half of what flows
through each opening, one after the other; all that inflators give; the openings in reverse, and the
other half of the volume. It is of order two, exact where nothing flows, and stable for any opening:
what flows through one evens out the pressures and does not pass that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import all_of, positive, real
from contiga.dynamics.tables import as_table
from contiga.errors import InputError
from contiga.laws.law import not_negative
from contiga.records import FloatArray

AMBIENT = "ambient"
SHARE = 0.02
"""Of what is in a chamber, that flows in one part of a step at most."""
NEAR = 1e-3
"""Part of a pressure by which two differ where the flow is as the root of the difference."""
EVEN = 1e-14
"""Part by which pressures differ where nothing flows any more."""
PROBE = 1e-6
"""Share of a part's flow that the change of the pressures is measured by."""


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


class Series(NamedTuple):
    """Values over something, linear between rows; those of the ends stay beyond them."""

    x: FloatArray
    y: FloatArray

    def at(self, x: float) -> float:
        """The value there."""
        return float(np.interp(x, self.x, self.y))


@dataclass(frozen=True, init=False, eq=False)
class Inflator:
    """What blows gas into a chamber.

    Parameters
    ----------
    mass_rate : mass / time, a number, or rows t, ṁ with nothing before the first and after the last
    temperature : kelvin, a number or rows t, T, which stay at both ends
    gas : what comes; that of the surroundings if omitted
    trigger : name of the sensor whose trigger fires it, from when its times count; if omitted they
        are those of the run

    Raises
    ------
    InputError
        A rate below zero, a temperature that is not above zero.
    """

    mass_rate: Series
    temperature: Series
    gas: IdealGas | None
    trigger: str | None

    def __init__(
        self,
        mass_rate: ArrayLike,
        temperature: ArrayLike,
        gas: IdealGas | None = None,
        *,
        trigger: str | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "mass_rate", _series("mass_rate", mass_rate, least=0.0))
        put(self, "temperature", _series("temperature", temperature, least=1e-300))
        if gas is not None:
            all_of(IdealGas, (gas,), "gas", "must be a gas", "contiga.gas.IdealGas")
        put(self, "gas", gas)
        put(self, "trigger", trigger)

    @property
    def kinks(self) -> FloatArray:
        """Times at which what comes bends or jumps; since it is fired where a trigger does it."""
        return np.concatenate([self.mass_rate.x, self.temperature.x])

    def rate(self, time: float) -> float:
        """ṁ at a time."""
        times = self.mass_rate.x
        if len(times) > 1 and not times[0] <= time <= times[-1]:
            return 0.0
        return self.mass_rate.at(time)


@dataclass(frozen=True, init=False, eq=False)
class Vent:
    """An opening of a chamber.

    Parameters
    ----------
    area : a number, or rows over the excess pressure p − p_after or, with `over` = "time", over
        time; these stay at both ends
    coefficient : of discharge, C, above zero
    over : "pressure" or "time"
    to : name of another chamber; the surroundings if omitted
    opens_at : excess pressure from which on it is open, and stays so
    opens_after : time from which on it is open

    Raises
    ------
    InputError
        A number below zero, another word.
    """

    area: Series
    coefficient: float
    over: str
    to: str
    opens_at: float
    opens_after: float

    def __init__(
        self,
        area: ArrayLike,
        *,
        coefficient: float = 1.0,
        over: str = "pressure",
        to: str = AMBIENT,
        opens_at: float = -math.inf,
        opens_after: float = -math.inf,
    ) -> None:
        if over not in ("pressure", "time"):
            raise InputError("is not known", where="over", found=over, allowed="pressure, time")
        put = object.__setattr__
        put(self, "area", _series("area", area, least=0.0))
        put(self, "coefficient", positive(coefficient, "coefficient"))
        put(self, "over", over)
        put(self, "to", to)
        put(self, "opens_at", _threshold("opens_at", opens_at))
        put(self, "opens_after", _threshold("opens_after", opens_after))

    def effective(self, excess: float, time: float, is_open: bool) -> float:
        """C A at an excess pressure and a time."""
        if not is_open or time < self.opens_after:
            return 0.0
        return self.coefficient * self.area.at(excess if self.over == "pressure" else time)


class Surroundings(NamedTuple):
    """What is around all chambers."""

    pressure: float
    temperature: float
    gas: IdealGas


@dataclass(frozen=True, init=False, eq=False)
class Chamber:
    """A closed space in facets of a slave, filled with gas.

    Parameters
    ----------
    slave : its name; its facets close a space, and their normals point out of it
    surroundings : `Surroundings`: pressure, temperature and gas outside, and of the chamber at the
        start
    inflators, vents : what gas comes and goes by
    leak : C A of fabric over its area: what leaks through a unit of area that is under pressure
    name : how results call it; "gas" if empty

    Raises
    ------
    InputError
        A pressure or temperature that is not above zero, a leak below it, parts of another kind.
    """

    slave: str
    surroundings: Surroundings
    inflators: tuple[Inflator, ...]
    vents: tuple[Vent, ...]
    leak: float
    name: str

    def __init__(
        self,
        slave: str,
        surroundings: Surroundings,
        *,
        inflators: Sequence[Inflator] = (),
        vents: Sequence[Vent] = (),
        leak: float = 0.0,
        name: str = "",
    ) -> None:
        around, gas = (surroundings,), "contiga.gas.IdealGas"
        all_of(Surroundings, around, "surroundings", "must be", "contiga.gas.Surroundings")
        positive(surroundings.pressure, "surroundings: pressure")
        positive(surroundings.temperature, "surroundings: temperature")
        all_of(IdealGas, (surroundings.gas,), "surroundings: gas", "must be a gas", gas)
        all_of(Inflator, tuple(inflators), "inflators", "must be inflators", "contiga.gas.Inflator")
        all_of(Vent, tuple(vents), "vents", "must be vents", "contiga.gas.Vent")
        leak = not_negative(leak, "leak")
        put = object.__setattr__
        put(self, "slave", slave)
        put(self, "surroundings", surroundings)
        put(self, "inflators", tuple(inflators))
        put(self, "vents", tuple(vents))
        put(self, "leak", leak)
        put(self, "name", name or "gas")

    @property
    def kinks(self) -> FloatArray:
        """Times at which what flows bends or jumps."""
        times = [one.kinks for one in self.inflators if one.trigger is None]
        times += [vent.area.x for vent in self.vents if vent.over == "time"]
        times += [np.array([v.opens_after]) for v in self.vents if np.isfinite(v.opens_after)]
        return np.concatenate([np.zeros(0), *times])

    def called(self, name: str) -> Chamber:
        """A copy of another name."""
        other = copy(self)
        object.__setattr__(other, "name", name)
        return other


class GasState(NamedTuple):
    """What is in a chamber at one time."""

    masses: FloatArray
    """(k,) of each gas of all chambers."""
    energy: float
    """U."""
    volume: float
    pressure: float
    temperature: float
    is_open: FloatArray
    """(v,) 1 of vents that have opened."""
    came: float
    """Enthalpy that came in since the start."""
    left: float
    """And that went out."""
    stored: float
    """U + p_a V since the start: the energy of the gas, and what the surroundings did on it."""
    at_start: float
    """U + p_a V then."""


class Opening(NamedTuple):
    """A vent of a chamber, or all of its fabric that leaks."""

    here: int
    """Number of the chamber."""
    there: int | None
    """Of the chamber that it leads to; None for the surroundings."""
    vent: int | None
    """Number of the vent; None of fabric."""


class _Contents(NamedTuple):
    """What is in c chambers in the course of a step; changed in place."""

    masses: FloatArray
    """(c, k)."""
    energy: FloatArray
    """(c,)."""
    volume: FloatArray
    """(c,)."""
    came: FloatArray
    """(c,), with the next, enthalpies since the start."""
    left: FloatArray
    is_open: tuple[FloatArray, ...]
    """(v,) of each chamber."""


class _Side(NamedTuple):
    """Gas on one side of an opening."""

    pressure: float
    temperature: float
    shares: FloatArray
    """(k,) of its mass; their sum is one."""


class Chambers:
    """Chambers that gas may flow between.

    Parameters
    ----------
    chambers : of names of their own

    Raises
    ------
    InputError
        A vent to a chamber that is not there, or to its own.
    """

    def __init__(self, chambers: Sequence[Chamber]) -> None:
        self.chambers = tuple(chambers)
        index = {chamber.name: k for k, chamber in enumerate(self.chambers)}
        gases: list[IdealGas] = []
        for chamber in self.chambers:
            gases.append(chamber.surroundings.gas)
            gases += [one.gas for one in chamber.inflators if one.gas is not None]
            for k, vent in enumerate(chamber.vents):
                if vent.to != AMBIENT and (vent.to not in index or vent.to == chamber.name):
                    raise InputError(
                        "leads to no other chamber",
                        where=f"gas {chamber.name!r}: vents[{k}]: to",
                        found=vent.to,
                        allowed=", ".join([AMBIENT, *(n for n in index if n != chamber.name)]),
                    )
        self.gases = tuple(dict.fromkeys(gases))
        self._c_v = np.array([gas.c_v for gas in self.gases])
        self._constant = np.array([gas.constant for gas in self.gases])
        self._openings: list[Opening] = []
        for c, chamber in enumerate(self.chambers):
            for k, vent in enumerate(chamber.vents):
                self._openings.append(Opening(c, index.get(vent.to), k))
            if chamber.leak > 0.0:
                self._openings.append(Opening(c, None, None))

    def start(self, volumes: FloatArray) -> list[GasState]:
        """What is in volumes (c,) at the start: gas as around them."""
        states = []
        for chamber, volume in zip(self.chambers, volumes.tolist(), strict=True):
            around = chamber.surroundings
            mass = around.pressure * volume / (around.gas.constant * around.temperature)
            masses = np.zeros(len(self.gases))
            masses[self.gases.index(around.gas)] = mass
            vents = np.array([vent.opens_at == -math.inf for vent in chamber.vents], np.float64)
            energy = mass * around.gas.c_v * around.temperature
            whole = energy + around.pressure * volume
            states.append(
                GasState(
                    masses,
                    energy,
                    volume,
                    around.pressure,
                    around.temperature,
                    vents,
                    came=0.0,
                    left=0.0,
                    stored=0.0,
                    at_start=whole,
                )
            )
        return states

    def step(
        self,
        states: Sequence[GasState],
        volumes: FloatArray,
        areas: FloatArray,
        time: float,
        dt: float,
        fired: Mapping[str, float] | None = None,
    ) -> list[GasState]:
        """What is in chambers after a step of length `dt` that ends at `time`.

        Parameters
        ----------
        fired : times at which triggers fire, by their sensors; those that are missing have not
        volumes, areas : (c,) of the chambers at its end, and of their facets, through which leaks
        """
        now = _Contents(
            np.array([state.masses for state in states]),
            np.array([state.energy for state in states]),
            np.array([state.volume for state in states]),
            np.array([state.came for state in states]),
            np.array([state.left for state in states]),
            # Copies: a step may be refused, and asked for again.
            tuple(state.is_open.copy() for state in states),
        )
        self._squeeze(now, 0.5 * (now.volume + volumes))
        for opening in self._openings:
            self._let_through(now, opening, areas, time - 0.75 * dt, 0.5 * dt)
        for c, chamber in enumerate(self.chambers):
            for inflator in chamber.inflators:
                gas, middle = inflator.gas or chamber.surroundings.gas, time - 0.5 * dt
                if inflator.trigger is not None:
                    middle -= (fired or {}).get(inflator.trigger, math.inf)
                    if middle < 0.0:
                        continue
                mass = dt * inflator.rate(middle)
                enthalpy = mass * gas.c_p * inflator.temperature.at(middle)
                now.masses[c, self.gases.index(gas)] += mass
                now.energy[c] += enthalpy
                now.came[c] += enthalpy
        for opening in reversed(self._openings):
            self._let_through(now, opening, areas, time - 0.25 * dt, 0.5 * dt)
        self._squeeze(now, volumes)
        after = []
        for c, (chamber, state) in enumerate(zip(self.chambers, states, strict=True)):
            inside, energy, volume = self._inside(now, c), float(now.energy[c]), float(volumes[c])
            whole = energy + chamber.surroundings.pressure * volume
            after.append(
                GasState(
                    now.masses[c],
                    energy,
                    volume,
                    inside.pressure,
                    inside.temperature,
                    now.is_open[c],
                    float(now.came[c]),
                    float(now.left[c]),
                    whole - state.at_start,
                    state.at_start,
                )
            )
        return after

    def gamma(self, masses: FloatArray) -> float:
        """c_p / c_v of a mixture."""
        return 1.0 + float(masses @ self._constant) / float(masses @ self._c_v)

    def _squeeze(self, now: _Contents, volumes: FloatArray) -> None:
        """Bring the same gas into other volumes: U V^{γ−1} stays."""
        for c, volume in enumerate(volumes.tolist()):
            gamma = self.gamma(now.masses[c])
            now.energy[c] *= (now.volume[c] / volume) ** (gamma - 1.0)
        now.volume[:] = volumes

    def _inside(self, now: _Contents, c: int) -> _Side:
        """The gas of a chamber."""
        masses = now.masses[c]
        temperature = float(now.energy[c]) / float(masses @ self._c_v)
        pressure = float(masses @ self._constant) * temperature / float(now.volume[c])
        return _Side(pressure, temperature, masses / masses.sum())

    def _outside(self, c: int) -> _Side:
        """The gas around a chamber."""
        around = self.chambers[c].surroundings
        shares = np.zeros(len(self.gases))
        shares[self.gases.index(around.gas)] = 1.0
        return _Side(around.pressure, around.temperature, shares)

    def _let_through(
        self, now: _Contents, opening: Opening, areas: FloatArray, time: float, dt: float
    ) -> None:
        """Let flow through one opening what does in a part of a step.

        With nothing else flowing the pressures even out in a finite time, and never pass each
        other. Near that the flow is as the root of their difference, which then goes as the square
        of the time that is left.
        """
        left = dt
        while left > 0.0:
            rate = self._rate(now, opening, areas, time)
            if rate == 0.0:
                return
            c, other = opening.here, opening.there
            excess = self._excess(now, opening)
            trial = self._moved(now, opening, rate * PROBE * left)
            change = (self._excess(trial, opening) - excess) / (PROBE * left)
            even = abs(excess / change) if change != 0.0 else math.inf
            if abs(excess) <= NEAR * self._inside(now, c).pressure:
                share = 1.0 - min(0.5 * left / even, 1.0)  # of the root of the excess that is left
                mass = rate * even * (1.0 - share * share)
                self._move(now, opening, mass, self._source(now, opening, mass))
                return
            least = (
                now.masses[c].sum()
                if other is None
                else min(now.masses[c].sum(), now.masses[other].sum())
            )
            part = min(left, SHARE * float(least) / abs(rate), 0.25 * even)
            half = self._moved(now, opening, 0.5 * part * rate)
            mass = part * self._rate(half, opening, areas, time)
            self._move(now, opening, mass, self._source(half, opening, mass))
            left = left - part if part < left else 0.0

    def _excess(self, now: _Contents, opening: Opening) -> float:
        """The pressure of the chamber of an opening over that behind it."""
        here, there = opening.here, opening.there
        behind = self._outside(here) if there is None else self._inside(now, there)
        return self._inside(now, here).pressure - behind.pressure

    def _rate(self, now: _Contents, opening: Opening, areas: FloatArray, time: float) -> float:
        """Mass by time that goes out of the chamber of an opening, below zero where it comes in; a
        vent that opens is marked."""
        chamber, excess = self.chambers[opening.here], self._excess(now, opening)
        if opening.vent is None:
            area = chamber.leak * float(areas[opening.here])
        else:
            vent, is_open = chamber.vents[opening.vent], now.is_open[opening.here]
            if excess >= vent.opens_at:
                is_open[opening.vent] = 1.0
            area = vent.effective(excess, time, is_open[opening.vent] > 0.0)
        source = self._source(now, opening, excess)
        if area == 0.0 or abs(excess) <= EVEN * source.pressure:
            return 0.0
        constant, c_v = float(source.shares @ self._constant), float(source.shares @ self._c_v)
        behind, gamma = source.pressure - abs(excess), 1.0 + constant / c_v
        rate = area * flux(source.pressure, behind, source.temperature, gamma, constant)
        return math.copysign(rate, excess)

    def _source(self, now: _Contents, opening: Opening, outward: float) -> _Side:
        """The gas that flows: that of the chamber, if it flows outward."""
        if outward >= 0.0:
            return self._inside(now, opening.here)
        there = opening.there
        return self._outside(opening.here) if there is None else self._inside(now, there)

    def _move(self, now: _Contents, opening: Opening, mass: float, source: _Side) -> None:
        """Take a mass of a gas out of the chamber of an opening, or into it, with its enthalpy."""
        here, there = opening.here, opening.there
        heat = float(source.shares @ self._c_v) + float(source.shares @ self._constant)
        moved, enthalpy = mass * source.shares, mass * heat * source.temperature
        now.masses[here] -= moved
        now.energy[here] -= enthalpy
        if there is not None:
            now.masses[there] += moved
            now.energy[there] += enthalpy
        elif mass > 0.0:
            now.left[here] += enthalpy
        else:
            now.came[here] -= enthalpy

    def _moved(self, now: _Contents, opening: Opening, mass: float) -> _Contents:
        """A copy, after `_move`."""
        after = _Contents(
            now.masses.copy(),
            now.energy.copy(),
            now.volume,
            now.came.copy(),
            now.left.copy(),
            now.is_open,
        )
        self._move(after, opening, mass, self._source(now, opening, mass))
        return after


def flux(before: float, behind: float, temperature: float, gamma: float, constant: float) -> float:
    """Mass by area and time through an opening from one pressure to a lower one."""
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    ratio = max(behind / before, critical)
    swing = ratio ** (2.0 / gamma) - ratio ** ((gamma + 1.0) / gamma)
    root = 2.0 * gamma / ((gamma - 1.0) * constant * temperature) * max(swing, 0.0)
    return before * math.sqrt(root)


def _threshold(name: str, given: float) -> float:
    """A pressure or a time from which on a vent is open."""
    try:
        value = float(real(given, name))
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=given) from error
    if math.isnan(value):
        raise InputError("must be a number", where=name, found=given)
    return value


def _series(name: str, given: ArrayLike, least: float) -> Series:
    """A number, or rows x, y; none of them below `least`.

    Raises
    ------
    InputError
        Neither of these, or less.
    """
    rows = np.asarray(real(given, name), dtype=np.float64)
    table = np.array([[0.0, float(rows)]]) if rows.ndim == 0 else as_table(rows, ("x", name))
    if not (np.isfinite(table[:, 1]) & (table[:, 1] >= least)).all():
        allowed = "numbers from 0 on" if least == 0.0 else "numbers above 0"
        what = "must not be below zero" if least == 0.0 else "must be above zero"
        raise InputError(what, where=name, found=table[:, 1].min(), allowed=allowed)
    return Series(table[:, 0], table[:, 1])
