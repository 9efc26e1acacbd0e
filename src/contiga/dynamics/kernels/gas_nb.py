"""One step of the gas in chambers: compression, inflow from inflators, flow through openings.

`now` are `Contents`, changed in place. Their rows are the c chambers, the surroundings of each of
them (a unit of mass at the volume that it takes there), and two rows to work in. `tables` are
`FlowTables`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contiga.curves.kernels.curve_nb import curve_at
from contiga.dynamics.kernels.gases_nb import (
    capacity_of,
    constant_of,
    energy_of,
    enthalpy_of,
    entropy_of,
    mass_of,
)
from contiga.jit import inner, kernel

MAX_SHARE = 0.02
"""Largest share of a chamber's mass that flows in one substep."""
SMALL_DIFFERENCE = 1e-3
"""Relative pressure difference below which the flow is proportional to its square root."""
EQUAL = 1e-14
"""Relative pressure difference below which nothing flows."""
TEMPERATURE_TOL = 1e-9
"""Relative correction of a temperature at which Newton's method ends: the error is its square."""
MAX_ITERATIONS = 50


class Flow(NamedTuple):
    """Flow through an opening."""

    rate: float
    """Mass by time, negative where gas comes in."""
    excess: float
    """Pressure inside minus pressure outside."""
    source: int
    """Row whose gas flows."""


@inner(error_model="numpy")
def _pressure(gases, now, row):
    """Return the pressure p = Σ m R T / V of a row."""
    return constant_of(gases, now.masses[row]) * now.temperature[row] / now.volume[row]


@inner(error_model="numpy")
def _add(gases, now, row, sign, heat):
    """Add the masses `now.moved` and their enthalpy `heat` to a row; remove both if `sign` is −1.

    Its new temperature is found by Newton's method, to `TEMPERATURE_TOL` or `MAX_ITERATIONS`; no
    iteration lowers it below a tenth.
    """
    masses = now.masses[row]
    for g in range(masses.shape[0]):
        masses[g] += sign * now.moved[g]
    now.energy[row] += sign * heat
    t = now.temperature[row]
    for _ in range(MAX_ITERATIONS):
        change = (now.energy[row] - energy_of(gases, masses, t)) / capacity_of(gases, masses, t)
        t = max(t + change, 0.1 * t)
        if abs(change) <= TEMPERATURE_TOL * t:
            break
    now.temperature[row] = t


@inner(error_model="numpy")
def _squeeze(gases, now, row, volume):
    """Change the volume of a row at constant entropy, and its energy and temperature with it.

    The temperature is found by Newton's method in its logarithm.
    """
    if volume == now.volume[row]:
        return
    masses, start = now.masses[row], now.temperature[row]
    constant = constant_of(gases, masses)
    rise = constant * math.log(now.volume[row] / volume)  # ∫ c_v/T dT of the compression
    t = start * math.exp(rise / capacity_of(gases, masses, start))
    for _ in range(MAX_ITERATIONS):
        capacity = capacity_of(gases, masses, t)
        residual = entropy_of(gases, masses, start, t) - constant * math.log(t / start) - rise
        t *= math.exp(-residual / capacity)
        if abs(residual) <= TEMPERATURE_TOL * capacity:
            break
    now.energy[row] += energy_of(gases, masses, t) - energy_of(gases, masses, start)
    now.temperature[row], now.volume[row] = t, volume


@inner(error_model="numpy")
def flux(upstream, downstream, temperature, gamma, constant):
    """Return the mass flux, mass / (area time), through an opening between two pressures, ≥ 0.

    `temperature` (kelvin), `gamma` and gas `constant` (energy by mass and kelvin) are those
    upstream, where the pressure is higher. The flow is choked below the critical pressure ratio.
    """
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    ratio = max(downstream / upstream, critical)
    factor = ratio ** (2.0 / gamma) - ratio ** ((gamma + 1.0) / gamma)
    square = 2.0 * gamma / ((gamma - 1.0) * constant * temperature) * max(factor, 0.0)
    return upstream * math.sqrt(square)


@inner(error_model="numpy")
def _flow(tables, now, o, chamber, neighbour, time):
    """Return the `Flow` through opening o between two rows; `now.is_open[o]` is 1 once it opens.

    The rate is positive from `chamber` to `neighbour`. It is 0 before the opening's trigger, its
    pressure or its time, and where the pressures differ by no more than `EQUAL` of the higher one.
    """
    gases, openings = tables.gases, tables.openings
    inside, outside = _pressure(gases, now, chamber), _pressure(gases, now, neighbour)
    excess = inside - outside
    source, high, low = (
        (chamber, inside, outside) if excess >= 0.0 else (neighbour, outside, inside)
    )
    since = time - now.opened[o]
    area = 0.0
    if not openings.waits[o] or since >= 0.0:
        if excess >= openings.opens_at[o]:
            now.is_open[o] = 1.0
        if now.is_open[o] > 0.0 and since >= openings.opens_after[o]:
            at = since if openings.over_time[o] else excess
            area = now.exposed[o] * curve_at(openings.areas, o, at).value
    if area == 0.0 or abs(excess) <= EQUAL * high:
        return Flow(0.0, excess, source)
    masses, temperature = now.masses[source], now.temperature[source]
    constant = constant_of(gases, masses)
    gamma = 1.0 + constant / capacity_of(gases, masses, temperature)
    rate = area * flux(high, low, temperature, gamma, constant / mass_of(masses))
    return Flow(rate if excess >= 0.0 else -rate, excess, source)


@inner(error_model="numpy")
def _pressure_by_mass(gases, now, row, source):
    """Return the derivative of a row's pressure by the mass added from the gas of `source`.

    The volume is constant; the mass brings its enthalpy.
    """
    flowing, temperature = now.masses[source], now.temperature[source]
    mass, masses, t = mass_of(flowing), now.masses[row], now.temperature[row]
    heat = enthalpy_of(gases, flowing, temperature) - energy_of(gases, flowing, t)
    warming = heat / capacity_of(gases, masses, t)
    growth = constant_of(gases, flowing) * t + constant_of(gases, masses) * warming
    return growth / mass / now.volume[row]


@inner(error_model="numpy")
def _move(gases, now, sides, mass, source):
    """Move a mass of the gas of row `source` from the first row of `sides` to the second.

    It goes the other way if it is negative. A second row of −1 stands for the surroundings, which
    do not change. Returns the enthalpy that has left the first row; overwrites `now.moved`.
    """
    flowing = now.masses[source]
    part = mass / mass_of(flowing)
    for g in range(flowing.shape[0]):
        now.moved[g] = part * flowing[g]
    heat = enthalpy_of(gases, now.moved, now.temperature[source])
    _add(gases, now, sides[0], -1.0, heat)
    if sides[1] >= 0:
        _add(gases, now, sides[1], 1.0, heat)
    return heat


@inner(error_model="numpy")
def _copy(now, row, to):
    """Copy a row of the contents to another."""
    for g in range(now.masses.shape[1]):
        now.masses[to, g] = now.masses[row, g]
    now.energy[to], now.volume[to] = now.energy[row], now.volume[row]
    now.temperature[to] = now.temperature[row]


@inner(error_model="numpy")
def _flow_through(tables, now, o, time, dt):
    """Advance the flow through opening o by a time `dt`; returns the enthalpy that flowed out.

    It is negative if gas came in. The last two rows of `now` are overwritten. Without other flows
    the pressures equalise in a finite time and never cross. Close to that the flow is proportional
    to the square root of their difference, which falls as the square of the remaining time. Farther
    away the midpoint method takes substeps.
    """
    gases, chambers = tables.gases, now.came.shape[0]
    chamber, neighbour = tables.openings.chamber[o], tables.openings.neighbour[o]
    half_chamber, half_neighbour = 2 * chambers, 2 * chambers + 1
    is_internal = neighbour < chambers
    sides = (chamber, neighbour if is_internal else -1)
    half_sides = (half_chamber, half_neighbour if is_internal else -1)
    enthalpy, remaining = 0.0, dt
    while remaining > 0.0:
        rate, excess, source = _flow(tables, now, o, chamber, neighbour, time)
        if rate == 0.0:
            break
        fall = _pressure_by_mass(gases, now, chamber, source)
        least_mass = mass_of(now.masses[chamber])
        if is_internal:
            fall += _pressure_by_mass(gases, now, neighbour, source)
            least_mass = min(least_mass, mass_of(now.masses[neighbour]))
        fall *= abs(rate)
        linear_time = abs(excess) / fall if fall > 0.0 else math.inf
        if abs(excess) <= SMALL_DIFFERENCE * _pressure(gases, now, chamber):
            # By the square root law the pressures equalise after twice the linear time.
            share = 0.5 * remaining / linear_time
            mass = rate * (linear_time if share >= 1.0 else 0.5 * remaining * (2.0 - share))
            enthalpy += _move(gases, now, sides, mass, source)
            break
        substep = min(remaining, MAX_SHARE * least_mass / abs(rate), 0.25 * linear_time)
        _copy(now, chamber, half_chamber)
        _copy(now, neighbour, half_neighbour)
        _move(gases, now, half_sides, 0.5 * substep * rate, source)
        rate, excess, source = _flow(tables, now, o, half_chamber, half_neighbour, time)
        enthalpy += _move(gases, now, sides, substep * rate, source)
        remaining = remaining - substep if substep < remaining else 0.0
    return enthalpy


@inner(error_model="numpy")
def _vent(tables, now, o, time, dt):
    """Advance the flow through opening o by a time `dt`, and its chamber's account of enthalpy.

    Enthalpy that flows to another chamber is in no account.
    """
    enthalpy, chamber = _flow_through(tables, now, o, time, dt), tables.openings.chamber[o]
    if tables.openings.neighbour[o] >= now.came.shape[0]:
        now.left[chamber] += max(enthalpy, 0.0)
        now.came[chamber] += max(-enthalpy, 0.0)


@inner(error_model="numpy")
def _blow_in(tables, now, i, time, dt):
    """Add the gas of inflator i in a step `dt`, by its rate and temperature in the middle, `time`.

    Its enthalpy is added to `now.came`, too; `now.moved` is overwritten. Nothing flows before its
    trigger, and outside the rows of its rate.
    """
    gases, inflators = tables.gases, tables.inflators
    at, rates = time - now.fired[i], inflators.rates
    first, last = rates.first[i], rates.first[i + 1] - 1
    if first < last and not rates.x[first] <= at <= rates.x[last]:
        return  # nothing flows beyond the ends of a table; a single number holds at all times
    if inflators.waits[i] and at < 0.0:
        return
    mass = dt * curve_at(rates, i, at).value
    if mass == 0.0:
        return
    temperature = curve_at(inflators.temperatures, i, at).value
    for g in range(now.moved.shape[0]):
        now.moved[g] = mass * inflators.shares[i, g]
    heat = enthalpy_of(gases, now.moved, temperature)
    _add(gases, now, inflators.chamber[i], 1.0, heat)
    now.came[inflators.chamber[i]] += heat


@kernel(error_model="numpy")
def flow(tables, now, volumes, time, dt):
    """Advance the contents of the chambers by a step `dt` that ends at `time`.

    `now` is changed in place, and gets the pressures at the end; `volumes` (c,) are those at the
    end. The parts of the step are symmetric about the inflow from inflators (Strang splitting).
    """
    gases, chambers, openings = tables.gases, volumes.shape[0], now.is_open.shape[0]
    for c in range(chambers):
        _squeeze(gases, now, c, 0.5 * (now.volume[c] + volumes[c]))
    for o in range(openings):
        _vent(tables, now, o, time - 0.75 * dt, 0.5 * dt)
    for i in range(now.fired.shape[0]):
        _blow_in(tables, now, i, time - 0.5 * dt, dt)
    for o in range(openings - 1, -1, -1):
        _vent(tables, now, o, time - 0.25 * dt, 0.5 * dt)
    for c in range(chambers):
        _squeeze(gases, now, c, volumes[c])
        now.pressure[c] = _pressure(gases, now, c)
