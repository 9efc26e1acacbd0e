"""Gas of uniform pressure in chambers: inflators, vents between chambers and to the surroundings.

A chamber holds ideal gases, mixed, at one pressure and temperature:

    dU = Σ ṁ_in h(T_in) dt − ṁ_out h(T) dt − p dV,    p V = Σ m_k R_k T,    U = Σ m_k u_k(T),

with h = ∫ c_p dT and u = h − R T of each gas (Wang & Nefske, SAE 880654). U and the masses are the
state; the temperature follows from them. The mass flow through an opening of area A is

    ṁ = C A p √(2γ/((γ−1) R T) (π^{2/γ} − π^{(γ+1)/γ})),

with π the ratio of the pressures downstream and upstream, bounded below by the critical ratio
(2/(γ+1))^{γ/(γ−1)} of choked flow.

A step is split (Strang 1968): half of the change of volume, adiabatic and exact; half of the flow
through each opening, one after the other; all of the inflow from inflators; the openings in reverse
order; and the other half of the change of volume. It is of second order, exact where nothing flows,
and stable for any opening: the flow through one equalises the pressures and never overshoots.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import check_types, positive, real
from contiga.curves.curve_records import Curves, joined, piecewise
from contiga.curves.tables import is_number, table_of
from contiga.dynamics.gas_tables import (
    Contents,
    FlowTables,
    InflatorTable,
    OpeningTable,
    gas_table,
    shares_of,
)
from contiga.dynamics.gases import GASES, Gas, Mixture, parts_of
from contiga.dynamics.kernels import gas_nb
from contiga.dynamics.places import place_of
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray

AMBIENT = "ambient"


@dataclass(frozen=True, init=False, eq=False)
class Inflator:
    """A gas generator of a chamber.

    Parameters
    ----------
    mass_rate : mass / time: a number, or rows (t, ṁ) with no flow before the first and after the
        last
    temperature : kelvin: a number, or rows (t, T), constant beyond both ends
    gas : a gas or a `Mixture`; that of the surroundings if omitted
    trigger : name of the sensor whose trigger fires it, at which its times start; if omitted they
        are times of the run

    Raises
    ------
    InputError
        A negative rate, a temperature that is not positive, tables whose times do not rise.
    """

    mass_rate: Curves
    temperature: Curves
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
        put(self, "mass_rate", _curve("mass_rate", mass_rate, over="t"))
        put(self, "temperature", _curve("temperature", temperature, over="t", above_zero=True))
        if gas is not None:
            check_types(Gas | Mixture, (gas,), "gas", "must be a gas", GASES)
        put(self, "gas", gas)
        put(self, "trigger", trigger)

    @property
    def kinks(self) -> FloatArray:
        """Times (k,) at which the inflow has kinks or jumps; since firing if it has a trigger.

        They are the rows of both tables in turn, unsorted; a number counts as a row at time 0.
        """
        return np.concatenate([self.mass_rate.x, self.temperature.x])


@dataclass(frozen=True, init=False, eq=False)
class Vent:
    """An opening of a chamber.

    Parameters
    ----------
    area : length²: a number, or rows over the excess pressure p − p_downstream or, with `over` =
        "time", over time; constant beyond both ends
    coefficient : discharge coefficient C, > 0
    over : "pressure" or "time"
    to : name of the chamber that it leads to; the surroundings if omitted
    opens_at : excess pressure at which it opens for good
    opens_after : time before which it is shut
    trigger : name of the sensor whose trigger lets it open, at which its times start; if omitted
        they are times of the run
    on : the facets that it is in, a place as in `Deforming(fixed=…)`: facets with all corners
        there. The share of them that bodies cover is closed; if omitted nothing covers the vent

    Raises
    ------
    InputError
        A negative area, an unknown word, a table that is no place.
    """

    area: Curves
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
            raise InputError("is unknown", where="over", found=over, allowed="pressure, time")
        put = object.__setattr__
        put(self, "area", _curve("area", area, over="t" if over == "time" else "p"))
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
        """Times (k,) at which its area has kinks or jumps; since firing if it has a trigger."""
        times = [self.opens_after] if math.isfinite(self.opens_after) else []
        return np.array([*times, *(self.area.x if self.over == "time" else ())], np.float64)


class Surroundings(NamedTuple):
    """State of the gas outside a chamber, which is also that inside at the start."""

    pressure: float
    """Absolute pressure, force over area."""
    temperature: float
    """Kelvin."""
    gas: Gas | Mixture


@dataclass(frozen=True, init=False, eq=False)
class Chamber:
    """A closed space in facets of a slave, filled with gas.

    Parameters
    ----------
    slave : name of the slave; its facets close the space, and their normals point outwards
    surroundings : pressure, temperature and gas outside, and inside at the start
    inflators, vents : inflow and openings
    leak : effective leak area C A of the fabric per area that no body covers: a number, or rows
        over the excess pressure
    name : name in the results; "gas" if empty

    Raises
    ------
    InputError
        A pressure or temperature that is not positive, a negative leak, parts of another kind, the
        name "ambient", which stands for the surroundings.
    """

    slave: str
    surroundings: Surroundings
    inflators: tuple[Inflator, ...]
    vents: tuple[Vent, ...]
    leak: Curves
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
                "stands for the surroundings", where="name", found=name, allowed="another name"
            )
        check_types(
            Surroundings, (surroundings,), "surroundings", "must be", "contiga.gas.Surroundings"
        )
        positive(surroundings.pressure, "surroundings: pressure")
        positive(surroundings.temperature, "surroundings: temperature")
        check_types(Gas | Mixture, (surroundings.gas,), "surroundings: gas", "must be a gas", GASES)
        check_types(
            Inflator, tuple(inflators), "inflators", "must be inflators", "contiga.gas.Inflator"
        )
        check_types(Vent, tuple(vents), "vents", "must be vents", "contiga.gas.Vent")
        put = object.__setattr__
        put(self, "slave", slave)
        put(self, "surroundings", surroundings)
        put(self, "inflators", tuple(inflators))
        put(self, "vents", tuple(vents))
        put(self, "leak", _curve("leak", leak, over="p"))
        put(self, "name", name or "gas")

    @property
    def open_at_start(self) -> FloatArray:
        """1 for each of the vents (v,) that needs no pressure to open, else 0."""
        return np.array([vent.opens_at == -math.inf for vent in self.vents], np.float64)

    @property
    def leaks(self) -> bool:
        """True if its fabric leaks at some pressure."""
        return bool(self.leak.y.any())

    @property
    def waiting(self) -> dict[str, Inflator | Vent]:
        """Inflators and vents that wait for a trigger, by their place: "inflators[0]" and so on."""
        devices: dict[str, Inflator | Vent] = {}
        devices |= {f"inflators[{k}]": inflator for k, inflator in enumerate(self.inflators)}
        devices |= {f"vents[{k}]": vent for k, vent in enumerate(self.vents)}
        return {place: device for place, device in devices.items() if device.trigger is not None}

    @property
    def kinks(self) -> FloatArray:
        """Times (k,) at which inflators or vents without a trigger have kinks or jumps."""
        devices: list[Inflator | Vent] = [*self.inflators, *self.vents]
        kinks = (device.kinks for device in devices if device.trigger is None)
        return np.concatenate([np.zeros(0), *kinks])

    def resting(self) -> Chamber:
        """Return a copy through which no gas flows: inflow, vent areas and leak are zero.

        Inflators and vents stay, in the same order.
        """
        still = copy(self)
        nothing = piecewise(np.zeros(1), np.zeros(1), 0.0, 0.0)
        for key, openings, flow in (
            ("inflators", self.inflators, "mass_rate"),
            ("vents", self.vents, "area"),
        ):
            closed = tuple(map(copy, openings))
            for opening in closed:
                object.__setattr__(opening, flow, nothing)
            object.__setattr__(still, key, closed)
        object.__setattr__(still, "leak", nothing)
        return still

    def called(self, name: str) -> Chamber:
        """Return a copy with another name."""
        renamed = copy(self)
        object.__setattr__(renamed, "name", name)
        return renamed


class GasState(NamedTuple):
    """State of a chamber at one time."""

    masses: FloatArray
    """(k,) mass of each gas of all chambers."""
    energy: float
    """Internal energy U."""
    volume: float
    """Volume, length³."""
    pressure: float
    """Absolute pressure."""
    temperature: float
    """Kelvin."""
    is_open: FloatArray
    """(v,) 1 for vents that have opened, else 0."""
    came: float
    """Enthalpy that came in since the start."""
    left: float
    """Enthalpy that went out since the start."""
    stored: float
    """Change of U + p_a V since the start: energy of the gas, and work against the surroundings."""
    at_start: float
    """U + p_a V at the start."""


class Exposed(NamedTuple):
    """Fabric and vents of a chamber that no body covers."""

    area: float
    """Uncovered area of its facets, length²."""
    vents: FloatArray
    """(v,) uncovered share of each vent."""


class Opening(NamedTuple):
    """A vent of a chamber, or its leaking fabric."""

    chamber: int
    """Number of the chamber."""
    neighbour: int | None
    """Number of the chamber that it leads to; None for the surroundings."""
    vent: int | None
    """Number of the vent; None for fabric."""


class Around(NamedTuple):
    """A unit of mass of the gas around each of c chambers."""

    masses: list[FloatArray]
    """(k,) mass of each gas, for each chamber."""
    volumes: list[float]
    """(c,) volume of this mass, length³."""
    temperatures: list[float]
    """(c,) kelvin."""


class Chambers:
    """The chambers of a simulation, with the gas flow between them.

    Parameters
    ----------
    chambers : chambers with different names

    Raises
    ------
    InputError
        A vent to an unknown chamber or to its own; two chambers with vents to each other.
    """

    def __init__(self, chambers: Sequence[Chamber]) -> None:
        self.chambers = tuple(chambers)
        index = {chamber.name: k for k, chamber in enumerate(self.chambers)}
        gases: list[Gas] = []
        for chamber in self.chambers:
            mixtures = [chamber.surroundings.gas]
            mixtures += [inflator.gas for inflator in chamber.inflators if inflator.gas is not None]
            gases += [gas for mixture in mixtures for gas, _ in parts_of(mixture)]
            for k, vent in enumerate(chamber.vents):
                if vent.to != AMBIENT and (vent.to not in index or vent.to == chamber.name):
                    raise InputError(
                        "leads to no other chamber",
                        where=f"gas {chamber.name!r}: vents[{k}]: to",
                        found=vent.to,
                        allowed=", ".join([AMBIENT, *(n for n in index if n != chamber.name)]),
                    )
                neighbour = index.get(vent.to)
                vents = () if neighbour is None else self.chambers[neighbour].vents
                if any(opposite.to == chamber.name for opposite in vents):
                    raise InputError(
                        f"gas {vent.to!r} has a vent to this chamber as well: gas flows both ways "
                        "through each vent, so both areas would add up",
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
        self._fired_by = [
            inflator.trigger for chamber in self.chambers for inflator in chamber.inflators
        ]
        self._opened_by = [
            None if vent is None else self.chambers[c].vents[vent].trigger
            for c, _, vent in self._openings
        ]
        self._tables = FlowTables(
            gas_table(self.gases), self._opening_table(), self._inflator_table()
        )
        every = [chamber.surroundings for chamber in self.chambers]
        self._around = Around(
            [np.array(shares_of(self.gases, outside.gas)) for outside in every],
            [outside.gas.constant * outside.temperature / outside.pressure for outside in every],
            [outside.temperature for outside in every],
        )

    def start(self, volumes: FloatArray) -> list[GasState]:
        """Return the states of chambers with volumes (c,) at the start: gas as around them.

        Vents that need no pressure are marked as open.
        """
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
        """Return the states of the chambers after a step of length `dt` that ends at `time`.

        `states` are not changed, so that a step can be repeated.

        Parameters
        ----------
        states : (c,) states before the step
        volumes : (c,) volumes at its end, length³
        exposed : (c,) uncovered fabric and vents at its end
        fired : times at which triggers fired, by their sensors
        time : end of the step
        dt : length of the step
        """
        now = self._contents(states, exposed, fired or {})
        volumes = np.ascontiguousarray(volumes, np.float64)
        straight(gas_nb.flow)(self._tables, now, volumes, float(time), float(dt))
        opened_vents: list[list[float]] = [[] for _ in self.chambers]
        for opening, is_open in zip(self._openings, now.is_open.tolist(), strict=True):
            if opening.vent is not None:
                opened_vents[opening.chamber].append(is_open)
        after = []
        for c, (chamber, state) in enumerate(zip(self.chambers, states, strict=True)):
            energy, volume = float(now.energy[c]), float(volumes[c])
            total = energy + chamber.surroundings.pressure * volume
            after.append(
                GasState(
                    now.masses[c].copy(),
                    energy,
                    volume,
                    float(now.pressure[c]),
                    float(now.temperature[c]),
                    np.array(opened_vents[c], np.float64),
                    float(now.came[c]),
                    float(now.left[c]),
                    total - float(state.at_start),
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
        """Return the internal energy Σ m (h − R T) of masses (k,) at a temperature."""
        pairs = zip(masses.tolist(), self.gases, strict=True)
        return sum(
            mass * (gas.enthalpy(temperature) - gas.constant * temperature) for mass, gas in pairs
        )

    def _contents(
        self, states: Sequence[GasState], exposed: Sequence[Exposed], fired: Mapping[str, float]
    ) -> Contents:
        """Return the contents of the chambers at the beginning of a step.

        The arrays are new: a step may be rejected and repeated. Energies of surroundings, volumes
        and temperatures of the rows to work in, and pressures are not initialised.
        """
        n = len(states)
        masses = np.empty((2 * n + 2, len(self.gases)))
        energy, volume, temperature = np.empty((3, 2 * n + 2))
        masses[: 2 * n] = [*(state.masses for state in states), *self._around.masses]
        energy[:n] = [state.energy for state in states]
        volume[: 2 * n] = [*(state.volume for state in states), *self._around.volumes]
        temperature[: 2 * n] = [
            *(state.temperature for state in states),
            *self._around.temperatures,
        ]
        is_open, uncovered = np.ones(len(self._openings)), np.empty(len(self._openings))
        for o, (c, _, vent) in enumerate(self._openings):
            uncovered[o] = exposed[c].area if vent is None else exposed[c].vents[vent]
            if vent is not None:
                is_open[o] = states[c].is_open[vent]
        return Contents(
            masses,
            energy,
            volume,
            temperature,
            np.empty(n),
            np.array([state.came for state in states], np.float64),
            np.array([state.left for state in states], np.float64),
            is_open,
            uncovered,
            _clock_starts(self._opened_by, fired),
            _clock_starts(self._fired_by, fired),
            np.empty(len(self.gases)),
        )

    def _opening_table(self) -> OpeningTable:
        """Return the table of vents and fabric for kernels, in the order of `_openings`.

        Areas of vents have the discharge coefficient in them. An opening to the surroundings leads
        to the row of its own chamber's surroundings.
        """
        areas: list[Curves] = []
        over_time, opens_at, opens_after = [], [], []
        for c, _, number in self._openings:
            chamber = self.chambers[c]
            if number is None:
                areas.append(chamber.leak)
                over_time.append(False)
                opens_at.append(-math.inf)
                opens_after.append(-math.inf)
            else:
                vent = chamber.vents[number]
                area = vent.coefficient * vent.area.y
                areas.append(piecewise(vent.area.x, area, 0.0, 0.0))
                over_time.append(vent.over == "time")
                opens_at.append(vent.opens_at)
                opens_after.append(vent.opens_after)
        count = len(self.chambers)
        neighbours = [
            count + opening.chamber if opening.neighbour is None else opening.neighbour
            for opening in self._openings
        ]
        return OpeningTable(
            np.array([opening.chamber for opening in self._openings], np.int32),
            np.array(neighbours, np.int32),
            np.array(over_time, np.bool_),
            np.array([trigger is not None for trigger in self._opened_by], np.bool_),
            np.array(opens_at, np.float64),
            np.array(opens_after, np.float64),
            joined(*areas),
        )

    def _inflator_table(self) -> InflatorTable:
        """Return the table of inflators for kernels, chamber by chamber.

        An inflator without a gas blows in that of its chamber's surroundings.
        """
        every = [
            (c, inflator, inflator.gas or chamber.surroundings.gas)
            for c, chamber in enumerate(self.chambers)
            for inflator in chamber.inflators
        ]
        shares = [shares_of(self.gases, gas) for _, _, gas in every]
        return InflatorTable(
            np.array([c for c, _, _ in every], np.int32),
            np.array([trigger is not None for trigger in self._fired_by], np.bool_),
            np.array(shares, np.float64).reshape(len(every), len(self.gases)),
            joined(*(inflator.mass_rate for _, inflator, _ in every)),
            joined(*(inflator.temperature for _, inflator, _ in every)),
        )


def _clock_starts(triggers: Sequence[str | None], fired: Mapping[str, float]) -> FloatArray:
    """Return the times (n,) at which clocks start.

    They start with their triggers, at 0 without one; infinite until a trigger fires.
    """
    starts = [fired.get(trigger, math.inf) if trigger else 0.0 for trigger in triggers]
    return np.array(starts, np.float64)


def _threshold(name: str, value: float) -> float:
    """Return the pressure or time at which a vent opens, which may be infinite.

    An `InputError` is raised if it is no number, or NaN.
    """
    try:
        number = float(real(value, name))
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=value) from error
    if math.isnan(number):
        raise InputError("must be a number", where=name, found=value)
    return number


def _curve(name: str, values: ArrayLike, over: str, above_zero: bool = False) -> Curves:
    """Return the curve of a number, or of rows over "t" or "p", constant beyond both ends.

    Raises
    ------
    InputError
        Neither a number nor rows, a negative value, or zero though it must be `above_zero`.
    """
    allowed = f"a number, or rows [{over}, {name}] with {over} strictly increasing"
    rows = [[0.0, values]] if is_number(values) else values
    table = table_of(rows, (over, name), where=name, allowed=allowed)
    least = float(table[:, 1].min())
    if not (least > 0.0 if above_zero else least >= 0.0):
        problem = "must be above zero" if above_zero else "must not be below zero"
        raise InputError(problem, where=name, found=least, allowed="finite numbers")
    return piecewise(table[:, 0], table[:, 1], 0.0, 0.0)
