"""Gas of uniform pressure in chambers: inflators, vents between chambers and to the surroundings.

A chamber holds ideal gases, mixed, at one pressure and temperature:

    dU = Σ ṁ_in h(T_in) dt − ṁ_out h(T) dt − p dV,    p V = Σ m_k R_k T,    U = Σ m_k u_k(T),

with h = ∫ c_p dT and u = h − R T of each gas (Wang & Nefske, SAE 880654). U and the masses are what
is kept; the temperature is found from them. Through an opening of area A goes

    ṁ = C A p √(2γ/((γ−1) R T) (π^{2/γ} − π^{(γ+1)/γ})),

with π the ratio of the pressures after and before it, and no less than that at which the flow is as
fast as sound, (2/(γ+1))^{γ/(γ−1)}.

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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import all_of, positive, real
from contiga.dynamics.gases import GASES, Gas, Mixture, parts_of
from contiga.dynamics.places import place_of
from contiga.dynamics.tables import as_table
from contiga.errors import InputError
from contiga.records import FloatArray

AMBIENT = "ambient"
SHARE = 0.02
"""Of what is in a chamber, that flows in one part of a step at most."""
NEAR = 1e-3
"""Part of a pressure by which two differ where the flow is as the root of the difference."""
EVEN = 1e-14
"""Part by which pressures differ where nothing flows any more."""
FOUND = 1e-9
"""Part of a temperature by which Newton's last correction of it differs from nothing: what is left
after that is its square."""
ITERATIONS = 50


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
    gas : what comes, a gas or a `Mixture`; that of the surroundings if omitted
    trigger : name of the sensor whose trigger fires it, from when its times count; if omitted they
        are those of the run

    Raises
    ------
    InputError
        A rate below zero, a temperature that is not above zero.
    """

    mass_rate: Series
    temperature: Series
    gas: Gas | Mixture | None
    trigger: str | None

    def __init__(
        self,
        mass_rate: ArrayLike,
        temperature: ArrayLike,
        gas: Gas | Mixture | None = None,
        *,
        trigger: str | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "mass_rate", _series("mass_rate", mass_rate, least=0.0))
        put(self, "temperature", _series("temperature", temperature, least=1e-300))
        if gas is not None:
            all_of(Gas | Mixture, (gas,), "gas", "must be a gas", GASES)
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
    on : the facets that it is in: a table of one place as `Deforming(fixed=…)` has them; facets all
        of whose corners are there. As much of it is closed as bodies cover of these; without it
        nothing ever covers it

    Raises
    ------
    InputError
        A number below zero, another word, a table that is no place.
    """

    area: Series
    coefficient: float
    over: str
    to: str
    opens_at: float
    opens_after: float
    on: Mapping[str, Any] | None

    def __init__(
        self,
        area: ArrayLike,
        *,
        coefficient: float = 1.0,
        over: str = "pressure",
        to: str = AMBIENT,
        opens_at: float = -math.inf,
        opens_after: float = -math.inf,
        on: Mapping[str, Any] | None = None,
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
        if on is not None and place_of(on, (), "on") is None:
            raise InputError("says nowhere", where="on", found=on, allowed="a place, or none")
        put(self, "on", None if on is None else dict(on))

    def effective(self, excess: float, time: float, is_open: bool) -> float:
        """C A at an excess pressure and a time."""
        if not is_open or time < self.opens_after:
            return 0.0
        return self.coefficient * self.area.at(excess if self.over == "pressure" else time)


class Surroundings(NamedTuple):
    """What is around all chambers."""

    pressure: float
    temperature: float
    gas: Gas | Mixture


@dataclass(frozen=True, init=False, eq=False)
class Chamber:
    """A closed space in facets of a slave, filled with gas.

    Parameters
    ----------
    slave : its name; its facets close a space, and their normals point out of it
    surroundings : `Surroundings`: pressure, temperature and gas outside, and of the chamber at the
        start
    inflators, vents : what gas comes and goes by
    leak : C A of fabric over its area: what leaks through a unit of area that no body covers; a
        number, or rows over the excess pressure
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
    leak: Series
    name: str

    def __init__(
        self,
        slave: str,
        surroundings: Surroundings,
        *,
        inflators: Sequence[Inflator] = (),
        vents: Sequence[Vent] = (),
        leak: ArrayLike = 0.0,
        name: str = "",
    ) -> None:
        all_of(Surroundings, (surroundings,), "surroundings", "must be", "contiga.gas.Surroundings")
        positive(surroundings.pressure, "surroundings: pressure")
        positive(surroundings.temperature, "surroundings: temperature")
        all_of(Gas | Mixture, (surroundings.gas,), "surroundings: gas", "must be a gas", GASES)
        all_of(Inflator, tuple(inflators), "inflators", "must be inflators", "contiga.gas.Inflator")
        all_of(Vent, tuple(vents), "vents", "must be vents", "contiga.gas.Vent")
        put = object.__setattr__
        put(self, "slave", slave)
        put(self, "surroundings", surroundings)
        put(self, "inflators", tuple(inflators))
        put(self, "vents", tuple(vents))
        put(self, "leak", _series("leak", leak, least=0.0))
        put(self, "name", name or "gas")

    @property
    def open_at_start(self) -> FloatArray:
        """(v,) 1 of vents that no pressure opens."""
        return np.array([vent.opens_at == -math.inf for vent in self.vents], np.float64)

    @property
    def leaks(self) -> bool:
        """Whether its fabric does, at any pressure."""
        return bool(self.leak.y.any())

    @property
    def kinks(self) -> FloatArray:
        """Times at which what flows bends or jumps."""
        times = [one.kinks for one in self.inflators if one.trigger is None]
        times += [vent.area.x for vent in self.vents if vent.over == "time"]
        times += [np.array([v.opens_after]) for v in self.vents if np.isfinite(v.opens_after)]
        return np.concatenate([np.zeros(0), *times])

    def resting(self) -> Chamber:
        """The same gas with nothing that comes or goes."""
        still = copy(self)
        nothing = Series(np.zeros(1), np.zeros(1))
        for key, openings, flow in (
            ("inflators", self.inflators, "mass_rate"),
            ("vents", self.vents, "area"),
        ):
            closed = tuple(map(copy, openings))
            for one in closed:
                object.__setattr__(one, flow, nothing)
            object.__setattr__(still, key, closed)
        object.__setattr__(still, "leak", nothing)
        return still

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


class Exposed(NamedTuple):
    """Fabric and vents of a chamber that no body covers."""

    area: float
    """Area of its facets that leak, length²."""
    vents: FloatArray
    """(v,) shares of its vents."""


class Opening(NamedTuple):
    """A vent of a chamber, or all of its fabric that leaks."""

    here: int
    """Number of the chamber."""
    there: int | None
    """Number of the chamber that it leads to; None for the surroundings."""
    vent: int | None
    """Number of the vent; None of fabric."""


@dataclass(slots=True)
class _Content:
    """Contents of a chamber in the course of a step; changed in place."""

    masses: list[float]
    """(k,) of each gas of all chambers."""
    energy: float
    volume: float
    temperature: float
    """Temperature that these masses have with this energy, kelvin."""
    came: float
    """Enthalpy since the start, with the next."""
    left: float
    is_open: FloatArray
    """(v,)."""


class _Side(NamedTuple):
    """Gas on one side of an opening."""

    pressure: float
    temperature: float
    shares: list[float]
    """(k,) of its mass; their sum is one."""


class _Flow(NamedTuple):
    """Flow through an opening."""

    rate: float
    """Mass by time that goes out of its chamber, below zero where it comes in."""
    excess: float
    """The pressure of its chamber over that behind it."""
    source: _Side
    """The gas that flows: that of the higher pressure."""


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
        gases: list[Gas] = []
        for chamber in self.chambers:
            mixtures = [chamber.surroundings.gas]
            mixtures += [one.gas for one in chamber.inflators if one.gas is not None]
            gases += [gas for mixture in mixtures for gas, _ in parts_of(mixture)]
            for k, vent in enumerate(chamber.vents):
                if vent.to != AMBIENT and (vent.to not in index or vent.to == chamber.name):
                    raise InputError(
                        "leads to no other chamber",
                        where=f"gas {chamber.name!r}: vents[{k}]: to",
                        found=vent.to,
                        allowed=", ".join([AMBIENT, *(n for n in index if n != chamber.name)]),
                    )
        self.gases = tuple(dict.fromkeys(gases))
        self._openings: list[Opening] = []
        for c, chamber in enumerate(self.chambers):
            for k, vent in enumerate(chamber.vents):
                self._openings.append(Opening(c, index.get(vent.to), k))
            if chamber.leaks:
                self._openings.append(Opening(c, None, None))

    def start(self, volumes: FloatArray) -> list[GasState]:
        """What is in volumes (c,) at the start: gas as around them."""
        states = []
        for c, (chamber, volume) in enumerate(zip(self.chambers, volumes.tolist(), strict=True)):
            pressure, temperature, shares = self._outside(c)
            mass = pressure * volume / (self._constant(shares) * temperature)
            masses = [mass * share for share in shares]
            energy, _ = self._caloric(masses, temperature)
            whole = energy + pressure * volume
            states.append(
                GasState(
                    np.array(masses),
                    energy,
                    volume,
                    pressure,
                    temperature,
                    chamber.open_at_start,
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
        exposed: Sequence[Exposed],
        time: float,
        dt: float,
        fired: Mapping[str, float] | None = None,
    ) -> list[GasState]:
        """What is in chambers after a step of length `dt` that ends at `time`.

        Parameters
        ----------
        volumes : (c,) of the chambers at its end
        exposed : (c,) what is open of their fabric and vents then
        fired : times at which triggers fire, by their sensors; those that are missing have not
        """
        now = [
            _Content(
                state.masses.tolist(),
                float(state.energy),
                float(state.volume),
                float(state.temperature),
                float(state.came),
                float(state.left),
                # A copy: a step may be refused, and asked for again.
                state.is_open.copy(),
            )
            for state in states
        ]
        ends = volumes.tolist()
        for content, end in zip(now, ends, strict=True):
            self._squeeze(content, 0.5 * (content.volume + end))
        for opening in self._openings:
            self._let_through(now, opening, exposed, time - 0.75 * dt, 0.5 * dt)
        for content, chamber in zip(now, self.chambers, strict=True):
            for inflator in chamber.inflators:
                middle = time - 0.5 * dt
                if inflator.trigger is not None:
                    middle -= (fired or {}).get(inflator.trigger, math.inf)
                    if middle < 0.0:
                        continue
                mass = dt * inflator.rate(middle)
                if mass == 0.0:
                    continue
                shares = self._shares(inflator.gas or chamber.surroundings.gas)
                heat = mass * self._enthalpy(shares, inflator.temperature.at(middle))
                self._add(content, mass, shares, heat)
                content.came += heat
        for opening in reversed(self._openings):
            self._let_through(now, opening, exposed, time - 0.25 * dt, 0.5 * dt)
        after = []
        for content, end, chamber, state in zip(now, ends, self.chambers, states, strict=True):
            self._squeeze(content, end)
            inside = self._inside(content)
            whole = content.energy + chamber.surroundings.pressure * end
            after.append(
                GasState(
                    np.array(content.masses),
                    content.energy,
                    end,
                    inside.pressure,
                    inside.temperature,
                    content.is_open,
                    content.came,
                    content.left,
                    whole - float(state.at_start),
                    state.at_start,
                )
            )
        return after

    def gamma(self, state: GasState) -> float:
        """c_p / c_v of the gas in a chamber."""
        masses = state.masses.tolist()
        _, c_v = self._caloric(masses, float(state.temperature))
        return 1.0 + self._constant(masses) / c_v

    def _caloric(self, masses: Sequence[float], temperature: float) -> tuple[float, float]:
        """U of masses or shares at a temperature, and its slope."""
        energy = slope = 0.0
        for mass, gas in zip(masses, self.gases, strict=True):
            if mass != 0.0:
                energy += mass * (gas.enthalpy(temperature) - gas.constant * temperature)
                slope += mass * (gas.heat_capacity(temperature) - gas.constant)
        return energy, slope

    def _enthalpy(self, shares: Sequence[float], temperature: float) -> float:
        """Return the enthalpy by mass of a mixture."""
        pairs = zip(shares, self.gases, strict=True)
        return sum(share * gas.enthalpy(temperature) for share, gas in pairs if share != 0.0)

    def _constant(self, masses: Sequence[float]) -> float:
        """Σ m R."""
        return sum(mass * gas.constant for mass, gas in zip(masses, self.gases, strict=True))

    def _shares(self, gas: Gas | Mixture) -> list[float]:
        """(k,) of each gas of all chambers in one, or in a mixture."""
        parts = dict(parts_of(gas))
        return [parts.get(one, 0.0) for one in self.gases]

    def _add(
        self, content: _Content, mass: float, shares: Sequence[float], enthalpy: float
    ) -> None:
        """Put a mass into a chamber, or take it out where it is below zero."""
        content.masses = [m + mass * x for m, x in zip(content.masses, shares, strict=True)]
        content.energy += enthalpy
        t = content.temperature
        for _ in range(ITERATIONS):
            energy, slope = self._caloric(content.masses, t)
            change = (content.energy - energy) / slope
            t = max(t + change, 0.1 * t)
            if abs(change) <= FOUND * t:
                break
        content.temperature = t

    def _squeeze(self, content: _Content, volume: float) -> None:
        """Bring the same gas into another volume: its entropy stays."""
        if volume == content.volume:
            return
        start, constant = content.temperature, self._constant(content.masses)
        swelling = constant * math.log(content.volume / volume)
        before, slope = self._caloric(content.masses, start)
        t = start * math.exp(swelling / slope)
        for _ in range(ITERATIONS):
            _, slope = self._caloric(content.masses, t)
            gained = -constant * math.log(t / start) - swelling
            for mass, gas in zip(content.masses, self.gases, strict=True):
                gained += mass * gas.entropy(start, t)
            t *= math.exp(-gained / slope)
            if abs(gained) <= FOUND * slope:
                break
        after, _ = self._caloric(content.masses, t)
        content.energy += after - before
        content.temperature, content.volume = t, volume

    def _inside(self, content: _Content) -> _Side:
        """The gas of a chamber."""
        whole = sum(content.masses)
        pressure = self._constant(content.masses) * content.temperature / content.volume
        return _Side(pressure, content.temperature, [mass / whole for mass in content.masses])

    def _outside(self, c: int) -> _Side:
        """The gas around a chamber."""
        pressure, temperature, gas = self.chambers[c].surroundings
        return _Side(pressure, temperature, self._shares(gas))

    def _let_through(
        self,
        now: list[_Content],
        opening: Opening,
        exposed: Sequence[Exposed],
        time: float,
        dt: float,
    ) -> None:
        """Let flow through one opening what does in a part of a step.

        With nothing else flowing the pressures even out in a finite time, and never pass each
        other. Near that the flow is as the root of their difference, which then goes as the square
        of the time that is left.
        """
        here, there = opening.here, opening.there
        left = dt
        while left > 0.0:
            rate, excess, source = self._flow(now, opening, exposed, time)
            if rate == 0.0:
                return
            falling = abs(rate) * self._evening(now, opening, source)
            even = abs(excess) / falling if falling > 0.0 else math.inf
            if abs(excess) <= NEAR * self._inside(now[here]).pressure:
                span = 0.5 * left / even  # of the time in which they even out
                mass = rate * (even if span >= 1.0 else 0.5 * left * (2.0 - span))
                self._move(now, opening, mass, source)
                return
            sides = [here] if there is None else [here, there]
            least = min(sum(now[c].masses) for c in sides)
            part = min(left, SHARE * least / abs(rate), 0.25 * even)
            half = list(now)
            for c in sides:
                half[c] = copy(now[c])
            self._move(half, opening, 0.5 * part * rate, source)
            middle = self._flow(half, opening, exposed, time)
            self._move(now, opening, part * middle.rate, middle.source)
            left = left - part if part < left else 0.0

    def _evening(self, now: list[_Content], opening: Opening, source: _Side) -> float:
        """Return how much the difference of the pressures falls by mass that flows."""
        enthalpy, constant = (
            self._enthalpy(source.shares, source.temperature),
            self._constant(source.shares),
        )
        whole = 0.0
        for c in (opening.here, opening.there):
            if c is not None:
                content = now[c]
                t = content.temperature
                _, slope = self._caloric(content.masses, t)
                energy, _ = self._caloric(source.shares, t)
                warmed = (enthalpy - energy) / slope
                swollen = constant * t + self._constant(content.masses) * warmed
                whole += swollen / content.volume
        return whole

    def _flow(
        self, now: list[_Content], opening: Opening, exposed: Sequence[Exposed], time: float
    ) -> _Flow:
        """Return the flow through an opening; mark a vent that opens."""
        here, k, there = opening.here, opening.vent, opening.there
        inside = self._inside(now[here])
        behind = self._outside(here) if there is None else self._inside(now[there])
        chamber, excess = self.chambers[here], inside.pressure - behind.pressure
        if k is None:
            area = chamber.leak.at(excess) * exposed[here].area
        else:
            vent, is_open = chamber.vents[k], now[here].is_open
            if excess >= vent.opens_at:
                is_open[k] = 1.0
            area = vent.effective(excess, time, is_open[k] > 0.0) * float(exposed[here].vents[k])
        source, after = (inside, behind) if excess >= 0.0 else (behind, inside)
        if area == 0.0 or abs(excess) <= EVEN * source.pressure:
            return _Flow(0.0, excess, source)
        constant = self._constant(source.shares)
        _, c_v = self._caloric(source.shares, source.temperature)
        gamma = 1.0 + constant / c_v
        rate = area * flux(source.pressure, after.pressure, source.temperature, gamma, constant)
        return _Flow(math.copysign(rate, excess), excess, source)

    def _move(self, now: list[_Content], opening: Opening, mass: float, source: _Side) -> None:
        """Take a mass of a gas out of the chamber of an opening, or into it, with its enthalpy."""
        here, there = now[opening.here], opening.there
        enthalpy = mass * self._enthalpy(source.shares, source.temperature)
        self._add(here, -mass, source.shares, -enthalpy)
        if there is not None:
            self._add(now[there], mass, source.shares, enthalpy)
        elif mass > 0.0:
            here.left += enthalpy
        else:
            here.came -= enthalpy


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
    try:
        rows = np.asarray(real(given, name), dtype=np.float64)
        table = np.array([[0.0, float(rows)]]) if rows.ndim == 0 else as_table(rows, ("x", name))
    except (TypeError, ValueError) as error:
        what = error.what if isinstance(error, InputError) else "must be a number, or rows"
        found = error.found if isinstance(error, InputError) else given
        allowed = f"a number, or rows [x, {name}] with x strictly increasing"
        raise InputError(what, where=name, found=found, allowed=allowed) from error
    if not (np.isfinite(table[:, 1]) & (table[:, 1] >= least)).all():
        allowed = "numbers from 0 on" if least == 0.0 else "numbers above 0"
        what = "must not be below zero" if least == 0.0 else "must be above zero"
        raise InputError(what, where=name, found=table[:, 1].min(), allowed=allowed)
    return Series(table[:, 0], table[:, 1])
