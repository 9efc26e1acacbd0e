"""Gas of uniform pressure in chambers: inflators, vents between chambers and to the surroundings.

A chamber holds ideal gases of constant heat capacities, mixed, at one pressure and temperature:

    dU = Σ ṁ_in c_p T_in dt − ṁ_out c_p T dt − p dV,    p V = Σ m_k R_k T,    U = Σ m_k c_v,k T

(Wang & Nefske, SAE 880654). Through an opening of area A goes ṁ = C A p √(2γ/((γ−1) R T)
(π^{2/γ} − π^{(γ+1)/γ})) with π the ratio of the pressures after and before it, and no less than
that at which the flow is as fast as sound, (2/(γ+1))^{γ/(γ−1)}.

A step is half of the change of volume, adiabatic and exact, all that flows, at fixed volumes, and
the other half: of order two, and exact where nothing flows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import all_of, positive, real
from contiga.dynamics.tables import as_table
from contiga.errors import InputError
from contiga.records import FloatArray

AMBIENT = "ambient"
SHARE = 0.02
"""Of what is in a chamber, that flows in one part of a step at most."""
MOST_PARTS = 1000
"""Parts of a step."""
EVEN = 1e-12
"""Part by which pressures differ where nothing flows any more."""


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
        if not self.gamma > 1.0:
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

    Raises
    ------
    InputError
        A rate below zero, a temperature that is not above zero.
    """

    mass_rate: Series
    temperature: Series
    gas: IdealGas | None

    def __init__(
        self, mass_rate: ArrayLike, temperature: ArrayLike, gas: IdealGas | None = None
    ) -> None:
        put = object.__setattr__
        put(self, "mass_rate", _series("mass_rate", mass_rate, least=0.0))
        put(self, "temperature", _series("temperature", temperature, least=1e-300))
        put(self, "gas", gas)

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
        put(self, "opens_at", float(opens_at))
        put(self, "opens_after", float(opens_after))

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
        positive(surroundings.pressure, "surroundings: pressure")
        positive(surroundings.temperature, "surroundings: temperature")
        all_of(Inflator, tuple(inflators), "inflators", "must be inflators", "contiga.Inflator")
        all_of(Vent, tuple(vents), "vents", "must be vents", "contiga.Vent")
        if not 0.0 <= leak < math.inf:
            raise InputError("must be 0 or more", where="leak", found=leak)
        put = object.__setattr__
        put(self, "slave", slave)
        put(self, "surroundings", surroundings)
        put(self, "inflators", tuple(inflators))
        put(self, "vents", tuple(vents))
        put(self, "leak", float(leak))
        put(self, "name", name or "gas")

    @property
    def kinks(self) -> FloatArray:
        """Times at which what flows bends or jumps."""
        times = [series.x for one in self.inflators for series in (one.mass_rate, one.temperature)]
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


class Flow(NamedTuple):
    """What flows in and out of chambers, by time."""

    masses: FloatArray
    """(c, k)."""
    energies: FloatArray
    """(c,) net."""
    came: FloatArray
    """(c,) enthalpy from inflators and the surroundings."""
    left: FloatArray
    """(c,) enthalpy to the surroundings."""


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
        self._index = index
        self._c_v = np.array([gas.c_v for gas in self.gases])
        self._constant = np.array([gas.constant for gas in self.gases])

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
    ) -> list[GasState]:
        """What is in chambers after a step of length `dt` that ends at `time`.

        Parameters
        ----------
        volumes, areas : (c,) of the chambers at its end, and of their facets, through which leaks
        """
        ends = volumes.tolist()
        middle = [0.5 * (state.volume + v) for state, v in zip(states, ends, strict=True)]
        # Vents open in copies: a step may be refused, and asked for again.
        own = [state._replace(is_open=state.is_open.copy()) for state in states]
        now = [self._squeezed(state, v) for state, v in zip(own, middle, strict=True)]
        left, parts = dt, 0
        while left > 0.0:
            flow = self._flow(now, areas, time - left)
            part = min(left, self._longest(now, flow))
            parts += 1
            if parts >= MOST_PARTS:
                part = left
            # The midpoint rule.
            half = self._after(now, flow, 0.5 * part)
            now = self._after(now, self._flow(half, areas, time - left + 0.5 * part), part)
            left = left - part if part < left else 0.0
        after = []
        for chamber, state, volume in zip(self.chambers, now, ends, strict=True):
            end = self._squeezed(state, volume)
            whole = end.energy + chamber.surroundings.pressure * volume
            after.append(end._replace(stored=whole - end.at_start))
        return after

    def gamma(self, masses: FloatArray) -> float:
        """c_p / c_v of a mixture."""
        return 1.0 + float(masses @ self._constant) / float(masses @ self._c_v)

    def _squeezed(self, state: GasState, volume: float) -> GasState:
        """The same gas in another volume: U V^{γ−1} stays."""
        gamma = self.gamma(state.masses)
        energy = state.energy * (state.volume / volume) ** (gamma - 1.0)
        return self._with(state._replace(volume=volume), state.masses, energy)

    def _with(self, state: GasState, masses: FloatArray, energy: float) -> GasState:
        """A state with pressure and temperature of what is in it."""
        temperature = energy / float(masses @ self._c_v)
        pressure = float(masses @ self._constant) * temperature / state.volume
        return state._replace(
            masses=masses, energy=energy, pressure=pressure, temperature=temperature
        )

    def _flow(self, states: Sequence[GasState], areas: FloatArray, time: float) -> Flow:
        """What flows at a time; `is_open` of states is brought up to date."""
        count = len(states)
        flow = Flow(
            np.zeros((count, len(self.gases))), np.zeros(count), np.zeros(count), np.zeros(count)
        )
        for c, (chamber, state) in enumerate(zip(self.chambers, states, strict=True)):
            around = chamber.surroundings
            for inflator in chamber.inflators:
                rate, gas = inflator.rate(time), inflator.gas or around.gas
                enthalpy = rate * gas.c_p * inflator.temperature.at(time)
                flow.masses[c, self.gases.index(gas)] += rate
                flow.energies[c] += enthalpy
                flow.came[c] += enthalpy
            for k, vent in enumerate(chamber.vents):
                other = None if vent.to == AMBIENT else self._index[vent.to]
                behind = around.pressure if other is None else states[other].pressure
                excess = state.pressure - behind
                if excess >= vent.opens_at:
                    state.is_open[k] = 1.0
                area = vent.effective(excess, time, state.is_open[k] > 0.0)
                self._add(flow, states, (c, other), area)
            if chamber.leak > 0.0:
                self._add(flow, states, (c, None), chamber.leak * float(areas[c]))
        return flow

    def _add(
        self, flow: Flow, states: Sequence[GasState], ends: tuple[int, int | None], area: float
    ) -> None:
        """Add what flows through an effective area from the first chamber to the second, or back;
        None are the surroundings."""
        here, there = ends
        around = self.chambers[here].surroundings
        outside = np.zeros(len(self.gases))
        outside[self.gases.index(around.gas)] = 1.0
        sides = [(states[here].pressure, states[here].temperature, states[here].masses)]
        if there is None:
            sides.append((around.pressure, around.temperature, outside))
        else:
            sides.append((states[there].pressure, states[there].temperature, states[there].masses))
        source, sink = (0, 1) if sides[0][0] >= sides[1][0] else (1, 0)
        pressure, temperature, masses = sides[source]
        if area == 0.0 or pressure - sides[sink][0] <= EVEN * pressure:
            return
        shares = masses / masses.sum()
        constant, c_v = float(shares @ self._constant), float(shares @ self._c_v)
        rate = area * flux(pressure, sides[sink][0], temperature, 1.0 + constant / c_v, constant)
        enthalpy = rate * (c_v + constant) * temperature
        from_here = source == 0
        for end, sign in ((here, -1.0 if from_here else 1.0), (there, 1.0 if from_here else -1.0)):
            if end is not None:
                flow.masses[end] += sign * rate * shares
                flow.energies[end] += sign * enthalpy
        if there is None:
            (flow.left if from_here else flow.came)[here] += enthalpy

    def _longest(self, states: Sequence[GasState], flow: Flow) -> float:
        """How long a part of a step may be: no more than a share flows, and no pressures that
        openings even out pass each other."""
        longest, rising = math.inf, []
        for c, state in enumerate(states):
            rate = float(np.abs(flow.masses[c]).sum()) / float(state.masses.sum())
            rate = max(rate, abs(float(flow.energies[c])) / state.energy)
            longest = min(longest, SHARE / rate if rate > 0.0 else math.inf)
            gamma = self.gamma(state.masses)
            rising.append((gamma - 1.0) * float(flow.energies[c]) / state.volume)
        for c, (chamber, state) in enumerate(zip(self.chambers, states, strict=True)):
            others = [
                None if vent.to == AMBIENT else self._index[vent.to] for vent in chamber.vents
            ]
            for other in {*others, *([None] if chamber.leak else [])}:
                behind = chamber.surroundings.pressure if other is None else states[other].pressure
                excess = state.pressure - behind
                change = rising[c] - (0.0 if other is None else rising[other])
                if excess * change < 0.0 and abs(excess) > EVEN * state.pressure:
                    longest = min(longest, 0.5 * abs(excess / change))
        return longest

    def _after(self, states: Sequence[GasState], flow: Flow, dt: float) -> list[GasState]:
        after = []
        for c, state in enumerate(states):
            moved = state._replace(
                came=state.came + dt * float(flow.came[c]),
                left=state.left + dt * float(flow.left[c]),
                is_open=state.is_open.copy(),
            )
            masses = np.maximum(state.masses + dt * flow.masses[c], 0.0)
            after.append(self._with(moved, masses, state.energy + dt * float(flow.energies[c])))
        return after


def flux(before: float, behind: float, temperature: float, gamma: float, constant: float) -> float:
    """Mass by area and time through an opening from one pressure to a lower one."""
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    ratio = max(behind / before, critical)
    swing = ratio ** (2.0 / gamma) - ratio ** ((gamma + 1.0) / gamma)
    root = 2.0 * gamma / ((gamma - 1.0) * constant * temperature) * max(swing, 0.0)
    return before * math.sqrt(root)


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
        raise InputError(
            "must not be below zero", where=name, found=table[:, 1].min(), allowed=allowed
        )
    return Series(table[:, 0], table[:, 1])
