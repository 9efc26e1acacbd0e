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
from contiga.dynamics.gas_tables import (
    Contents,
    FlowTables,
    InflatorTable,
    OpeningTable,
    Series,
    gas_table,
    joined,
    shares_of,
)
from contiga.dynamics.gases import GASES, Gas, Mixture, parts_of
from contiga.dynamics.kernels import gas_nb
from contiga.dynamics.places import place_of
from contiga.dynamics.tables import as_table
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray

AMBIENT = "ambient"


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
        put(self, "mass_rate", _series("mass_rate", mass_rate, over="t"))
        put(self, "temperature", _series("temperature", temperature, over="t", above=True))
        if gas is not None:
            all_of(Gas | Mixture, (gas,), "gas", "must be a gas", GASES)
        put(self, "gas", gas)
        put(self, "trigger", trigger)

    @property
    def kinks(self) -> FloatArray:
        """Times at which what comes bends or jumps; since it is fired where a trigger does it."""
        return np.concatenate([self.mass_rate.x, self.temperature.x])


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
    trigger : name of the sensor whose trigger lets it open, from when its times count; until then
        it is shut. If omitted they are those of the run
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
    trigger: str | None
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
        trigger: str | None = None,
        on: Mapping[str, Any] | None = None,
    ) -> None:
        if over not in ("pressure", "time"):
            raise InputError("is not known", where="over", found=over, allowed="pressure, time")
        put = object.__setattr__
        put(self, "area", _series("area", area, over="t" if over == "time" else "p"))
        put(self, "coefficient", positive(coefficient, "coefficient"))
        put(self, "over", over)
        put(self, "to", to)
        put(self, "opens_at", _threshold("opens_at", opens_at))
        put(self, "opens_after", _threshold("opens_after", opens_after))
        put(self, "trigger", trigger)
        if on is not None and place_of(on, (), "on") is None:
            raise InputError("says nowhere", where="on", found=on, allowed="a place, or none")
        put(self, "on", None if on is None else dict(on))

    @property
    def kinks(self) -> FloatArray:
        """Times at which its area bends or jumps; since it may open where a trigger does that."""
        times = [self.opens_after] if math.isfinite(self.opens_after) else []
        return np.array([*times, *(self.area.x if self.over == "time" else ())], np.float64)


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
        A pressure or temperature that is not above zero, a leak below it, parts of another kind, a
        name that means the surroundings.
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
        if name == AMBIENT:
            raise InputError(
                "is what vents call the surroundings", where="name", found=name, allowed="another"
            )
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
        put(self, "leak", _series("leak", leak, over="p"))
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
    def waiting(self) -> dict[str, Inflator | Vent]:
        """Inflators and vents that wait for a trigger, by their places."""
        places: dict[str, Inflator | Vent] = {}
        places |= {f"inflators[{k}]": one for k, one in enumerate(self.inflators)}
        places |= {f"vents[{k}]": one for k, one in enumerate(self.vents)}
        return {place: one for place, one in places.items() if one.trigger is not None}

    @property
    def kinks(self) -> FloatArray:
        """Times at which what flows bends or jumps."""
        every: list[Inflator | Vent] = [*self.inflators, *self.vents]
        return np.concatenate([np.zeros(0), *(one.kinks for one in every if one.trigger is None)])

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


class Around(NamedTuple):
    """A unit of mass of the gas around each of c chambers."""

    masses: list[FloatArray]
    """(k,) of each gas of all chambers, for each of them."""
    volumes: list[float]
    """(c,)."""
    temperatures: list[float]
    """(c,) kelvin."""


class Chambers:
    """Chambers that gas may flow between.

    Parameters
    ----------
    chambers : of names of their own

    Raises
    ------
    InputError
        A vent to a chamber that is not there, or to its own; vents of two chambers to each other.
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
                there = index.get(vent.to)
                back = () if there is None else self.chambers[there].vents
                if any(other.to == chamber.name for other in back):
                    raise InputError(
                        f"gas {vent.to!r} has a vent to this chamber, too: gas flows both ways "
                        "through one, and the areas of both would count",
                        where=f"gas {chamber.name!r}: vents[{k}]: to",
                        found=vent.to,
                        remedy="Keep one of them",
                    )
        self.gases = tuple(dict.fromkeys(gases))
        self._openings: list[Opening] = []
        for c, chamber in enumerate(self.chambers):
            for k, vent in enumerate(chamber.vents):
                self._openings.append(Opening(c, index.get(vent.to), k))
            if chamber.leaks:
                self._openings.append(Opening(c, None, None))
        self._fired_by = [one.trigger for chamber in self.chambers for one in chamber.inflators]
        self._opened_by = [
            None if k is None else self.chambers[here].vents[k].trigger
            for here, _, k in self._openings
        ]
        self._tables = FlowTables(
            gas_table(self.gases), self._opening_table(), self._inflator_table()
        )
        around = [chamber.surroundings for chamber in self.chambers]
        self._around = Around(
            [np.array(shares_of(self.gases, one.gas)) for one in around],
            [one.gas.constant * one.temperature / one.pressure for one in around],
            [one.temperature for one in around],
        )

    def start(self, volumes: FloatArray) -> list[GasState]:
        """Return what is in volumes (c,) at the start: gas as around them."""
        states = []
        for chamber, volume in zip(self.chambers, volumes.tolist(), strict=True):
            pressure, temperature, gas = chamber.surroundings
            mass = pressure * volume / (gas.constant * temperature)
            masses = mass * np.array(shares_of(self.gases, gas))
            energy = self._energy(masses, temperature)
            states.append(
                GasState(
                    masses,
                    energy,
                    volume,
                    pressure,
                    temperature,
                    chamber.open_at_start,
                    came=0.0,
                    left=0.0,
                    stored=0.0,
                    at_start=energy + pressure * volume,
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
        """Return what is in chambers after a step of length `dt` that ends at `time`.

        Parameters
        ----------
        volumes : (c,) of the chambers at its end
        exposed : (c,) what is open of their fabric and vents then
        fired : times at which triggers fire, by their sensors; those that are missing have not
        """
        now = self._contents(states, exposed, fired or {})
        volumes = np.ascontiguousarray(volumes, np.float64)
        straight(gas_nb.flow)(self._tables, now, volumes, float(time), float(dt))
        vents: list[list[float]] = [[] for _ in self.chambers]
        for opening, is_open in zip(self._openings, now.is_open.tolist(), strict=True):
            if opening.vent is not None:
                vents[opening.here].append(is_open)
        after = []
        for c, (chamber, state) in enumerate(zip(self.chambers, states, strict=True)):
            energy, volume = float(now.energy[c]), float(volumes[c])
            whole = energy + chamber.surroundings.pressure * volume
            after.append(
                GasState(
                    now.masses[c].copy(),
                    energy,
                    volume,
                    float(now.pressure[c]),
                    float(now.temperature[c]),
                    np.array(vents[c], np.float64),
                    float(now.came[c]),
                    float(now.left[c]),
                    whole - float(state.at_start),
                    state.at_start,
                )
            )
        return after

    def gamma(self, state: GasState) -> float:
        """Return c_p / c_v of the gas in a chamber."""
        capacity = constant = 0.0
        for mass, gas in zip(state.masses.tolist(), self.gases, strict=True):
            capacity += mass * gas.heat_capacity(float(state.temperature))
            constant += mass * gas.constant
        return capacity / (capacity - constant)

    def _energy(self, masses: FloatArray, temperature: float) -> float:
        """Return the internal energy of masses (k,) at a temperature."""
        pairs = zip(masses.tolist(), self.gases, strict=True)
        return sum(
            mass * (gas.enthalpy(temperature) - gas.constant * temperature) for mass, gas in pairs
        )

    def _contents(
        self, states: Sequence[GasState], exposed: Sequence[Exposed], fired: Mapping[str, float]
    ) -> Contents:
        """Return the contents of chambers as a step begins, in arrays of their own: a step may be
        refused, and asked for again."""
        c = len(states)
        masses = np.empty((2 * c + 2, len(self.gases)))
        energy, volume, temperature = np.empty((3, 2 * c + 2))
        masses[: 2 * c] = [*(state.masses for state in states), *self._around.masses]
        energy[:c] = [state.energy for state in states]
        volume[: 2 * c] = [*(state.volume for state in states), *self._around.volumes]
        temperature[: 2 * c] = [
            *(state.temperature for state in states),
            *self._around.temperatures,
        ]
        is_open, free = np.ones(len(self._openings)), np.empty(len(self._openings))
        for o, (here, _, k) in enumerate(self._openings):
            free[o] = exposed[here].area if k is None else exposed[here].vents[k]
            if k is not None:
                is_open[o] = states[here].is_open[k]
        return Contents(
            masses,
            energy,
            volume,
            temperature,
            np.empty(c),
            np.array([state.came for state in states], np.float64),
            np.array([state.left for state in states], np.float64),
            is_open,
            free,
            _begin(self._opened_by, fired),
            _begin(self._fired_by, fired),
            np.empty(len(self.gases)),
        )

    def _opening_table(self) -> OpeningTable:
        """Return what kernels know of vents and fabric."""
        areas: list[Series] = []
        over_time, opens_at, opens_after = [], [], []
        for here, _, k in self._openings:
            chamber = self.chambers[here]
            if k is None:
                areas.append(chamber.leak)
                over_time.append(False)
                opens_at.append(-math.inf)
                opens_after.append(-math.inf)
            else:
                vent = chamber.vents[k]
                areas.append(Series(vent.area.x, vent.coefficient * vent.area.y))
                over_time.append(vent.over == "time")
                opens_at.append(vent.opens_at)
                opens_after.append(vent.opens_after)
        count = len(self.chambers)
        there = [count + one.here if one.there is None else one.there for one in self._openings]
        return OpeningTable(
            np.array([one.here for one in self._openings], np.int32),
            np.array(there, np.int32),
            np.array(over_time, np.bool_),
            np.array([one is not None for one in self._opened_by], np.bool_),
            np.array(opens_at, np.float64),
            np.array(opens_after, np.float64),
            joined(areas),
        )

    def _inflator_table(self) -> InflatorTable:
        """Return what kernels know of inflators."""
        every = [
            (c, one, one.gas or chamber.surroundings.gas)
            for c, chamber in enumerate(self.chambers)
            for one in chamber.inflators
        ]
        shares = [shares_of(self.gases, gas) for _, _, gas in every]
        return InflatorTable(
            np.array([c for c, _, _ in every], np.int32),
            np.array([one is not None for one in self._fired_by], np.bool_),
            np.array(shares, np.float64).reshape(len(every), len(self.gases)),
            joined([one.mass_rate for _, one, _ in every]),
            joined([one.temperature for _, one, _ in every]),
        )


def _begin(triggers: Sequence[str | None], fired: Mapping[str, float]) -> FloatArray:
    """Return when times begin to count that wait for triggers, or for none."""
    return np.array([fired.get(one, math.inf) if one else 0.0 for one in triggers], np.float64)


def _threshold(name: str, given: float) -> float:
    """A pressure or a time from which on a vent is open."""
    try:
        value = float(real(given, name))
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=given) from error
    if math.isnan(value):
        raise InputError("must be a number", where=name, found=given)
    return value


def _series(name: str, given: ArrayLike, over: str, above: bool = False) -> Series:
    """Return a number, or rows over "t" or "p", of which none is below zero, or all are above it.

    Raises
    ------
    InputError
        Neither a number nor rows, or less.
    """
    try:
        rows = np.asarray(real(given, name), dtype=np.float64)
        table = np.array([[0.0, float(rows)]]) if rows.ndim == 0 else as_table(rows, (over, name))
    except (TypeError, ValueError) as error:
        what = error.what if isinstance(error, InputError) else "must be a number, or rows"
        found = error.found if isinstance(error, InputError) else given
        allowed = f"a number, or rows [{over}, {name}] with {over} strictly increasing"
        raise InputError(what, where=name, found=found, allowed=allowed) from error
    least = float(table[:, 1].min())
    if not (least > 0.0 if above else least >= 0.0) or not np.isfinite(table).all():
        what = "must be above zero" if above else "must not be below zero"
        raise InputError(what, where=name, found=least, allowed="finite numbers")
    return Series(table[:, 0], table[:, 1])
