"""The `gas` tables of a case: chambers of gas in closed slaves, inflators and vents."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from contiga.case.spec import MadeSpec, Name, NotNegative, Positive, Spec, is_number
from contiga.dynamics.gas import Chamber, IdealGas, Inflator, Surroundings, Vent
from contiga.errors import CaseError
from contiga.io.units import base_factor

ATMOSPHERE, ROOM = 101_325.0, 293.15
"""Pa and K around a chamber, if nothing else is said."""
AIR = 1.4, 287.05
"""γ and R of dry air, J/(kg K)."""


def _number_or_rows(value: Any) -> Any:
    # One message where a union of types would give one for each.
    rows = value if isinstance(value, list) else []
    if not (is_number(value) or (rows and all(isinstance(row, list) for row in rows))):
        raise CaseError(
            "must be a number, or rows", found=value, allowed="a number, or [[x, y], …]"
        )
    return value


def _air_or_gas(value: Any) -> Any:
    if not (value == "air" or isinstance(value, dict)):
        raise CaseError(
            "must be a gas", found=value, allowed='"air", or { gamma = 1.4, constant = 287.05 }'
        )
    return value


NumberOrRows = Annotated[float | list[list[float]], BeforeValidator(_number_or_rows)]


class IdealGasSpec(MadeSpec[IdealGas]):
    """A gas by its γ and R, in the units of the case."""

    makes = IdealGas
    gamma: Positive
    constant: Positive


GasKind = Annotated[Literal["air"] | IdealGasSpec, BeforeValidator(_air_or_gas)]


class InflatorSpec(Spec):
    """An inflator of a chamber."""

    mass_rate: NumberOrRows
    temperature: NumberOrRows
    """Kelvin."""
    gas: GasKind = "air"
    trigger: Name | None = None
    """Name of the sensor that fires it; its times are those of the run if omitted."""


class VentSpec(MadeSpec[Vent]):
    """A vent of a chamber."""

    makes = Vent
    area: NumberOrRows
    coefficient: Positive = 1.0
    over: str = "pressure"
    to: str = "ambient"
    opens_at: float | None = None
    opens_after: float | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the keys as `Vent` takes them."""
        return {name: value for name, value in super().arguments().items() if value is not None}


class GasSpec(Spec):
    """A `[[gas]]`: `Chamber`, with all its options."""

    name: Name = "gas"
    slave: str
    pressure: Positive | None = None
    """Around it, and in it at the start; that of the atmosphere if omitted."""
    temperature: Positive = ROOM
    """Kelvin."""
    gas: GasKind = "air"
    inflator: list[InflatorSpec] = Field(default_factory=list)
    vent: list[VentSpec] = Field(default_factory=list)
    leak: NotNegative = 0.0

    def chamber(self, units: tuple[str, str, str]) -> Chamber:
        """Make the chamber, in these units of length, mass and time."""
        length, mass, time = (
            base_factor(unit, what)
            for unit, what in zip(units, ("length", "mass", "time"), strict=True)
        )
        gamma, constant = AIR
        air = IdealGas(gamma, constant * (time / length) ** 2)
        pressure = self.pressure
        if pressure is None:
            pressure = ATMOSPHERE * length * time**2 / mass

        def gas_of(given: IdealGasSpec | str) -> IdealGas:
            return given.made if isinstance(given, IdealGasSpec) else air

        inflators = [
            Inflator(one.mass_rate, one.temperature, gas_of(one.gas), trigger=one.trigger)
            for one in self.inflator
        ]
        return Chamber(
            self.slave,
            Surroundings(pressure, self.temperature, gas_of(self.gas)),
            inflators=inflators,
            vents=[one.made for one in self.vent],
            leak=self.leak,
            name=self.name,
        )

    def describe(self) -> str:
        """Say it in words."""
        parts = [
            f"{len(some)} {what}{'' if len(some) == 1 else 's'}"
            for some, what in ((self.inflator, "inflator"), (self.vent, "vent"))
            if some
        ]
        parts += [f"leaks {self.leak:g} of its area"] if self.leak else []
        return f"in slave {self.slave}{''.join(f', {part}' for part in parts)}"
