"""A step of gas in chambers: squeezed, blown in, let through openings.

`now` are `Contents`, changed in place, whose rows are the c chambers, the surroundings of each of
them (a unit of mass, in as much room as it takes there), and two to work in. `tables` are
`FlowTables`.
"""

from __future__ import annotations

import math

from contiga.dynamics.kernels.gases_nb import (
    capacity_of,
    constant_of,
    energy_of,
    enthalpy_of,
    entropy_of,
    mass_of,
)
from contiga.jit import inner, kernel

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


@inner(error_model="numpy")
def _value(tables, k, at):
    """Return a value of table k of some `Joined`: linear between rows; those of the ends stay."""
    x, y, first, stop = tables.x, tables.y, tables.rows[k], tables.rows[k + 1]
    if at <= x[first]:
        return y[first]
    for j in range(first + 1, stop):
        if at < x[j]:
            return y[j - 1] + (y[j] - y[j - 1]) * ((at - x[j - 1]) / (x[j] - x[j - 1]))
    return y[stop - 1]


@inner(error_model="numpy")
def _pressure(gases, now, row):
    return constant_of(gases, now.masses[row]) * now.temperature[row] / now.volume[row]


@inner(error_model="numpy")
def _add(gases, now, row, sign, heat):
    """Add the masses `now.moved` with their enthalpy to a row, or take both out where `sign` is −1;
    Newton's method finds its temperature."""
    masses = now.masses[row]
    for g in range(masses.shape[0]):
        masses[g] += sign * now.moved[g]
    now.energy[row] += sign * heat
    t = now.temperature[row]
    for _ in range(ITERATIONS):
        change = (now.energy[row] - energy_of(gases, masses, t)) / capacity_of(gases, masses, t)
        t = max(t + change, 0.1 * t)
        if abs(change) <= FOUND * t:
            break
    now.temperature[row] = t


@inner(error_model="numpy")
def _squeeze(gases, now, row, volume):
    """Bring the same gas into another volume: its entropy stays."""
    if volume == now.volume[row]:
        return
    masses, start = now.masses[row], now.temperature[row]
    constant = constant_of(gases, masses)
    swelling = constant * math.log(now.volume[row] / volume)
    t = start * math.exp(swelling / capacity_of(gases, masses, start))
    for _ in range(ITERATIONS):
        capacity = capacity_of(gases, masses, t)
        gained = entropy_of(gases, masses, start, t) - constant * math.log(t / start) - swelling
        t *= math.exp(-gained / capacity)
        if abs(gained) <= FOUND * capacity:
            break
    now.energy[row] += energy_of(gases, masses, t) - energy_of(gases, masses, start)
    now.temperature[row], now.volume[row] = t, volume


@inner(error_model="numpy")
def flux(before, behind, temperature, gamma, constant):
    """Return the mass by area and time through an opening from one pressure to a lower one."""
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    ratio = max(behind / before, critical)
    swing = ratio ** (2.0 / gamma) - ratio ** ((gamma + 1.0) / gamma)
    root = 2.0 * gamma / ((gamma - 1.0) * constant * temperature) * max(swing, 0.0)
    return before * math.sqrt(root)


@inner(error_model="numpy")
def _flow(tables, now, o, here, there, time):
    """Return the flow through opening o from one row to another: mass by time, below zero where it
    comes in; the excess pressure; and the row whose gas flows. Marks a vent that opens."""
    gases, openings = tables.gases, tables.openings
    inside, behind = _pressure(gases, now, here), _pressure(gases, now, there)
    excess = inside - behind
    source, high, low = (here, inside, behind) if excess >= 0.0 else (there, behind, inside)
    since = time - now.opened[o]
    area = 0.0
    if not openings.waits[o] or since >= 0.0:
        if excess >= openings.opens_at[o]:
            now.is_open[o] = 1.0
        if now.is_open[o] > 0.0 and since >= openings.opens_after[o]:
            at = since if openings.over_time[o] else excess
            area = now.exposed[o] * _value(openings.areas, o, at)
    if area == 0.0 or abs(excess) <= EVEN * high:
        return 0.0, excess, source
    masses, temperature = now.masses[source], now.temperature[source]
    constant = constant_of(gases, masses)
    gamma = 1.0 + constant / capacity_of(gases, masses, temperature)
    rate = area * flux(high, low, temperature, gamma, constant / mass_of(masses))
    return (rate if excess >= 0.0 else -rate), excess, source


@inner(error_model="numpy")
def _evening(gases, now, row, source):
    """Return how much the pressure of a chamber changes by mass of another row's gas."""
    flowing, temperature = now.masses[source], now.temperature[source]
    mass, masses, t = mass_of(flowing), now.masses[row], now.temperature[row]
    brought = enthalpy_of(gases, flowing, temperature) - energy_of(gases, flowing, t)
    warmed = brought / capacity_of(gases, masses, t)
    swollen = constant_of(gases, flowing) * t + constant_of(gases, masses) * warmed
    return swollen / mass / now.volume[row]


@inner(error_model="numpy")
def _move(gases, now, sides, mass, source):
    """Move a mass of the gas of row `source` from the first of `sides` to the second; returns its
    enthalpy. The surroundings, where the second is −1, stay as they are."""
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
    """Write a row into another."""
    for g in range(now.masses.shape[1]):
        now.masses[to, g] = now.masses[row, g]
    now.energy[to], now.volume[to] = now.energy[row], now.volume[row]
    now.temperature[to] = now.temperature[row]


@inner(error_model="numpy")
def _let_through(tables, now, o, time, dt):
    """Let flow through opening o what does in a part of a step; returns the enthalpy that went.

    With nothing else flowing the pressures even out in a finite time, and never pass each other.
    Near that the flow is as the root of their difference, which then goes as the square of the time
    that is left. Farther from it a part of the step is taken by its middle.
    """
    gases, chambers = tables.gases, now.came.shape[0]
    here, there = tables.openings.here[o], tables.openings.there[o]
    half_here, half_there = 2 * chambers, 2 * chambers + 1
    inner_vent = there < chambers
    sides = (here, there if inner_vent else -1)
    halves = (half_here, half_there if inner_vent else -1)
    went, left = 0.0, dt
    while left > 0.0:
        rate, excess, source = _flow(tables, now, o, here, there, time)
        if rate == 0.0:
            break
        falling = _evening(gases, now, here, source)
        least = mass_of(now.masses[here])
        if inner_vent:
            falling += _evening(gases, now, there, source)
            least = min(least, mass_of(now.masses[there]))
        falling *= abs(rate)
        even = abs(excess) / falling if falling > 0.0 else math.inf
        if abs(excess) <= NEAR * _pressure(gases, now, here):
            span = 0.5 * left / even  # of the time in which they even out
            mass = rate * (even if span >= 1.0 else 0.5 * left * (2.0 - span))
            went += _move(gases, now, sides, mass, source)
            break
        part = min(left, SHARE * least / abs(rate), 0.25 * even)
        _copy(now, here, half_here)
        _copy(now, there, half_there)
        _move(gases, now, halves, 0.5 * part * rate, source)
        rate, excess, source = _flow(tables, now, o, half_here, half_there, time)
        went += _move(gases, now, sides, part * rate, source)
        left = left - part if part < left else 0.0
    return went


@inner(error_model="numpy")
def _open(tables, now, o, time, dt):
    """Let flow through opening o, and note what went to the surroundings and came from there."""
    went, here = _let_through(tables, now, o, time, dt), tables.openings.here[o]
    if tables.openings.there[o] >= now.came.shape[0]:
        now.left[here] += max(went, 0.0)
        now.came[here] += max(-went, 0.0)


@inner(error_model="numpy")
def _blow_in(tables, now, i, time, dt):
    """Blow in what inflator i gives in a step about a time."""
    gases, inflators = tables.gases, tables.inflators
    at, rates = time - now.fired[i], inflators.rates
    first, last = rates.rows[i], rates.rows[i + 1] - 1
    if first < last and not rates.x[first] <= at <= rates.x[last]:
        return  # a table ends; one number goes on for ever
    if inflators.waits[i] and at < 0.0:
        return
    mass = dt * _value(rates, i, at)
    if mass == 0.0:
        return
    temperature = _value(inflators.temperatures, i, at)
    for g in range(now.moved.shape[0]):
        now.moved[g] = mass * inflators.shares[i, g]
    heat = enthalpy_of(gases, now.moved, temperature)
    _add(gases, now, inflators.chamber[i], 1.0, heat)
    now.came[inflators.chamber[i]] += heat


@kernel(error_model="numpy")
def flow(tables, now, volumes, time, dt):
    """Advance the contents of chambers by a step of length `dt` that ends at `time`, with these
    volumes (c,) at its end: halves of a step forth and back, about what is blown in."""
    gases, chambers, openings = tables.gases, volumes.shape[0], now.is_open.shape[0]
    for c in range(chambers):
        _squeeze(gases, now, c, 0.5 * (now.volume[c] + volumes[c]))
    for o in range(openings):
        _open(tables, now, o, time - 0.75 * dt, 0.5 * dt)
    for i in range(now.fired.shape[0]):
        _blow_in(tables, now, i, time - 0.5 * dt, dt)
    for o in range(openings - 1, -1, -1):
        _open(tables, now, o, time - 0.25 * dt, 0.5 * dt)
    for c in range(chambers):
        _squeeze(gases, now, c, volumes[c])
        now.pressure[c] = _pressure(gases, now, c)
