"""Heat capacity, enthalpy and entropy of gases by piecewise polynomials, and sums over a mixture.

`gases` is a `GasTable`, temperatures are in kelvin. `gases.py` has the same functions of one gas
for Python, in the same form.
"""

from __future__ import annotations

import math

from contiga.jit import inner


@inner(error_model="numpy")
def _heat_of_piece(coefficients, low, high):
    """Return ∫ c_p dT of a polynomial between two temperatures."""
    at_low = at_high = 0.0
    for k in range(coefficients.shape[0] - 1, -1, -1):
        at_low = (at_low + coefficients[k] / (k + 1)) * low
        at_high = (at_high + coefficients[k] / (k + 1)) * high
    return at_high - at_low


@inner(error_model="numpy")
def _entropy_of_piece(coefficients, low, high):
    """Return ∫ c_p/T dT of a polynomial between two temperatures."""
    at_low = at_high = 0.0
    for k in range(coefficients.shape[0] - 1, 0, -1):
        at_low = (at_low + coefficients[k] / k) * low
        at_high = (at_high + coefficients[k] / k) * high
    return coefficients[0] * math.log(high / low) + at_high - at_low


@inner(error_model="numpy")
def heat_capacity(gases, g, temperature):
    """Return c_p of gas g at a temperature, energy by mass and kelvin."""
    p = gases.first[g]
    while temperature >= gases.highest[p]:
        p += 1
    coefficients = gases.coefficients[p]
    value = 0.0
    for k in range(coefficients.shape[0] - 1, -1, -1):
        value = value * temperature + coefficients[k]
    return value


@inner(error_model="numpy")
def enthalpy(gases, g, temperature):
    """Return ∫ c_p dT of gas g from 0 K, energy by mass."""
    p, low, total = gases.first[g], 0.0, 0.0
    while temperature > gases.highest[p]:
        total += _heat_of_piece(gases.coefficients[p], low, gases.highest[p])
        low = gases.highest[p]
        p += 1
    return total + _heat_of_piece(gases.coefficients[p], low, temperature)


@inner(error_model="numpy")
def entropy(gases, g, start, end):
    """Return ∫ c_p/T dT of gas g from `start` to `end`, energy by mass and kelvin.

    It is negative if `end` is below `start`.
    """
    low, high = min(start, end), max(start, end)
    p, total = gases.first[g], 0.0
    while low >= gases.highest[p]:
        p += 1
    while high > gases.highest[p]:
        total += _entropy_of_piece(gases.coefficients[p], low, gases.highest[p])
        low = gases.highest[p]
        p += 1
    total += _entropy_of_piece(gases.coefficients[p], low, high)
    return total if end >= start else -total


@inner(error_model="numpy")
def mass_of(masses):
    """Return the sum of masses (k,)."""
    total = 0.0
    for g in range(masses.shape[0]):
        total += masses[g]
    return total


@inner(error_model="numpy")
def constant_of(gases, masses):
    """Return Σ m R of masses (k,), energy by kelvin."""
    total = 0.0
    for g in range(masses.shape[0]):
        total += masses[g] * gases.constant[g]
    return total


@inner(error_model="numpy")
def enthalpy_of(gases, masses, temperature):
    """Return Σ m h of masses (k,) at a temperature."""
    total = 0.0
    for g in range(masses.shape[0]):
        if masses[g] != 0.0:
            total += masses[g] * enthalpy(gases, g, temperature)
    return total


@inner(error_model="numpy")
def energy_of(gases, masses, temperature):
    """Return the internal energy Σ m (h − R T) of masses (k,) at a temperature."""
    heat = enthalpy_of(gases, masses, temperature)
    return heat - constant_of(gases, masses) * temperature


@inner(error_model="numpy")
def capacity_of(gases, masses, temperature):
    """Return Σ m c_v of masses (k,) at a temperature, energy by kelvin."""
    total = 0.0
    for g in range(masses.shape[0]):
        if masses[g] != 0.0:
            total += masses[g] * (heat_capacity(gases, g, temperature) - gases.constant[g])
    return total


@inner(error_model="numpy")
def entropy_of(gases, masses, start, end):
    """Return Σ m ∫ c_p/T dT of masses (k,) between two temperatures, in energy per kelvin."""
    total = 0.0
    for g in range(masses.shape[0]):
        if masses[g] != 0.0:
            total += masses[g] * entropy(gases, g, start, end)
    return total
