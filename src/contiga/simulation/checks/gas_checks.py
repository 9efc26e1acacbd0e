"""Find temperatures and gas constants that are probably in another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator

from contiga.dynamics.gases import Gas, Mixture, parts_of
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

MIN_TEMPERATURE = 150.0
"""Kelvin, below the temperature of any bag; a value in degrees Celsius is lower."""
SOUND_SPEED_RANGE = (100.0, 2000.0)
"""Range of the speed of sound at room temperature, m/s: from refrigerants to above hydrogen."""
ROOM_TEMPERATURE = 293.15
"""Room temperature, kelvin."""


def check_gas(scene: Scene) -> Iterator[Finding]:
    """Report temperatures and gases of chambers that are probably in another unit.

    Temperatures below `MIN_TEMPERATURE` are reported, and, if the case has units, gases with a
    speed of sound outside `SOUND_SPEED_RANGE`.
    """
    for name, chamber in scene.model.gas.items():
        gases: dict[str, Gas | Mixture] = {"the gas around it": chamber.surroundings.gas}
        temperatures = {"the temperature around it": chamber.surroundings.temperature}
        for k, inflator in enumerate(chamber.inflators):
            temperatures[f"the temperature of inflator[{k}]"] = float(inflator.temperature.y.min())
            if inflator.gas is not None:
                gases[f"the gas of inflator[{k}]"] = inflator.gas
        where = f"gas {name}"
        for subject, temperature in temperatures.items():
            if temperature < MIN_TEMPERATURE:
                yield Finding(
                    "gas", where, f"{subject} is {temperature:.4g} K", "Give temperatures in kelvin"
                )
        if not scene.fmt.known:
            continue
        for subject, gas in gases.items():
            speed = sound_speed(gas) * scene.fmt.si(1, 0, -1)
            if not SOUND_SPEED_RANGE[0] <= speed <= SOUND_SPEED_RANGE[1]:
                square = f"{scene.fmt.unit('velocity')} squared"
                yield Finding(
                    "gas",
                    where,
                    f"sound in {subject} would go at {speed:.3g} m/s",
                    f"Give gas constants and c_p in {square} by kelvin",
                )


def sound_speed(gas: Gas | Mixture) -> float:
    """Return the speed of sound at room temperature, √(γ R T)."""
    heat = sum(share * part.heat_capacity(ROOM_TEMPERATURE) for part, share in parts_of(gas))
    gamma = heat / (heat - gas.constant)
    return math.sqrt(gamma * gas.constant * ROOM_TEMPERATURE)
