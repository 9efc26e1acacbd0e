"""Find temperatures and gas constants that are probably in another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator

from contiga.dynamics.gases import Gas, Mixture, parts_of
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

COLDEST = 150.0
"""Kelvin, below any filled bag; temperatures given in degrees Celsius are lower."""
SOUND_SPEEDS = (100.0, 2000.0)
"""Range of the speed of sound at room temperature, m/s: from heavy refrigerants to beyond
hydrogen."""
ROOM = 293.15
"""Room temperature, kelvin."""


def check_gas(scene: Scene) -> Iterator[Finding]:
    """Report temperatures and gases of chambers that are probably in another unit."""
    for name, chamber in scene.model.gas.items():
        gases: dict[str, Gas | Mixture] = {"the gas around it": chamber.surroundings.gas}
        temperatures = {"the temperature around it": chamber.surroundings.temperature}
        for k, inflator in enumerate(chamber.inflators):
            temperatures[f"the temperature of inflator[{k}]"] = float(inflator.temperature.y.min())
            if inflator.gas is not None:
                gases[f"the gas of inflator[{k}]"] = inflator.gas
        where = f"gas {name}"
        for what, temperature in temperatures.items():
            if temperature < COLDEST:
                yield Finding(
                    "gas", where, f"{what} is {temperature:.4g} K", "Give temperatures in kelvin"
                )
        if not scene.said.known:
            continue
        for what, gas in gases.items():
            speed = _sound_speed(gas) * scene.said.si(1, 0, -1)
            if not SOUND_SPEEDS[0] <= speed <= SOUND_SPEEDS[1]:
                square = f"{scene.said.unit('velocity')} squared"
                yield Finding(
                    "gas",
                    where,
                    f"sound in {what} would go at {speed:.3g} m/s",
                    f"Give gas constants and c_p in {square} by kelvin",
                )


def _sound_speed(gas: Gas | Mixture) -> float:
    """Return the speed of sound at room temperature, √(γ R T)."""
    heat = sum(share * part.heat_capacity(ROOM) for part, share in parts_of(gas))
    gamma = heat / (heat - gas.constant)
    return math.sqrt(gamma * gas.constant * ROOM)
