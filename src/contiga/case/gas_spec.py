"""The `gas` tables of a case: chambers of gas in closed slaves, inflators and vents."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from contiga.case.nodal_spec import NodesOf, NodesSpec
from contiga.case.spec import Name, Positive, Spec, is_number_or_rows, must_be
from contiga.dynamics.gas import Chamber, Inflator, Surroundings, Vent
from contiga.dynamics.gases import Gas, IdealGas, Mixture, ThermallyPerfectGas
from contiga.errors import CaseError
from contiga.io.units import base_factor

ATMOSPHERE, ROOM = 101_325.0, 293.15
"""Pressure, Pa, and temperature, K, around a chamber, by default."""
AIR = 1.4, 287.05
"""γ and R of dry air, J/(kg K)."""


# Tags in brackets are left out of the places that errors report.
NumberOrRows = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[list[list[float]], Tag("<rows>")],
    Discriminator(lambda value: "<rows>" if isinstance(value, list) else "<number>"),
    must_be(is_number_or_rows, "must be a number, or rows", "a number, or [[x, y], …]"),
]
HeatCapacity = Annotated[
    Annotated[list[float], Tag("<polynomial>")] | Annotated[list[list[float]], Tag("<rows>")],
    Discriminator(
        lambda value: (
            "<rows>"
            if isinstance(value, list) and any(isinstance(row, list) for row in value)
            else "<polynomial>"
        )
    ),
]


class OneGasSpec(Spec):
    """A gas by its R and its γ or c_p, in the units of the case."""

    constant: Positive
    gamma: Positive | None = None
    c_p: HeatCapacity | None = None
    """Rows T, c_p; or coefficients of a polynomial, with `between`."""
    between: tuple[float, float] | None = None

    @model_validator(mode="after")
    def _one_heat_capacity(self) -> Self:
        if (self.gamma is None) == (self.c_p is None):
            raise CaseError(
                "must have exactly one of the keys gamma, c_p",
                allowed="gamma = 1.4, or c_p = [[T, c_p], …]",
            )
        assert self.instance is not None
        return self

    @cached_property
    def instance(self) -> Gas:
        """The gas."""
        if self.gamma is not None:
            return IdealGas(self.gamma, self.constant)
        assert self.c_p is not None
        return ThermallyPerfectGas(self.constant, self.c_p, between=self.between)


class MixedGasSpec(OneGasSpec):
    """A gas in a mixture."""

    share: Positive
    """Share of the mass of the mixture."""


GasKind = Annotated[
    Annotated[Literal["air"], Tag("<air>")]
    | Annotated[OneGasSpec, Tag("<gas>")]
    | Annotated[list[MixedGasSpec], Tag("<mixture>")],
    Discriminator(
        lambda value: (
            "<mixture>" if isinstance(value, list) else "<air>" if value == "air" else "<gas>"
        )
    ),
    must_be(
        lambda value: (
            value == "air"
            or isinstance(value, dict)
            or (
                isinstance(value, list)
                and bool(value)
                and all(isinstance(gas, dict) for gas in value)
            )
        ),
        "must be a gas",
        '"air", { gamma = 1.4, constant = 287.05 }, { c_p = [[T, c_p], …], constant }, '
        "or a list of such tables, each with its share",
    ),
]


class InflatorSpec(Spec):
    """An inflator of a chamber."""

    mass_rate: NumberOrRows
    temperature: NumberOrRows
    """Temperature, kelvin."""
    gas: GasKind = "air"
    trigger: Name | None = None
    """Name of the sensor that fires it; without one its times are times of the run."""

    @model_validator(mode="after")
    def _inflator_is_possible(self) -> Self:
        assert self.inflator(None) is not None
        return self

    def inflator(self, gas: Gas | Mixture | None) -> Inflator:
        """Return the inflator of a gas."""
        return Inflator(self.mass_rate, self.temperature, gas, trigger=self.trigger)


class VentSpec(Spec):
    """A vent of a chamber; `on` gives its facets, which bodies may cover."""

    area: NumberOrRows
    coefficient: Positive = 1.0
    over: str = "pressure"
    to: str = "ambient"
    opens_at: float = -math.inf
    opens_after: float = -math.inf
    trigger: Name | None = None
    """Name of the sensor that opens it; its times count from then."""
    on: NodesSpec | None = None

    @model_validator(mode="after")
    def _vent_is_possible(self) -> Self:
        assert self.vent(lambda _: [0]) is not None
        return self

    def vent(self, nodes_of: NodesOf) -> Vent:
        """Return the vent."""
        keys = "over", "to", "opens_at", "opens_after", "trigger"
        options = {name: getattr(self, name) for name in keys}
        on = None if self.on is None else self.on.place(nodes_of)
        return Vent(self.area, coefficient=self.coefficient, on=on, **options)


class GasSpec(Spec):
    """A `[[gas]]`: `Chamber`, with all its options."""

    name: Name = "gas"
    slave: str
    pressure: Positive | None = None
    """Pressure around it, and in it at the start; 101 325 Pa if omitted."""
    temperature: Positive = ROOM
    """Temperature, kelvin."""
    gas: GasKind = "air"
    inflator: list[InflatorSpec] = Field(default_factory=list)
    vent: list[VentSpec] = Field(default_factory=list)
    leak: NumberOrRows = 0.0

    def chamber(self, units: tuple[str, str, str], nodes_of: NodesOf) -> Chamber:
        """Return the chamber, in these units of length, mass and time.

        `nodes_of` finds the nodes of its slave. Air and the pressure of the atmosphere are
        converted; temperatures are in kelvin.
        """
        length, mass, time = (
            base_factor(unit, dimension)
            for unit, dimension in zip(units, ("length", "mass", "time"), strict=True)
        )
        gamma, constant = AIR
        air = IdealGas(gamma, constant * (time / length) ** 2)
        pressure = self.pressure
        if pressure is None:
            pressure = ATMOSPHERE * length * time**2 / mass

        def gas_of(spec: Literal["air"] | OneGasSpec | list[MixedGasSpec]) -> Gas | Mixture:
            if isinstance(spec, list):
                return Mixture([(gas.instance, gas.share) for gas in spec])
            return spec.instance if isinstance(spec, OneGasSpec) else air

        return Chamber(
            self.slave,
            Surroundings(pressure, self.temperature, gas_of(self.gas)),
            inflators=[spec.inflator(gas_of(spec.gas)) for spec in self.inflator],
            vents=[spec.vent(nodes_of) for spec in self.vent],
            leak=self.leak,
            name=self.name,
        )

    def triggers(self) -> Iterator[tuple[str, str]]:
        """Yield the keys of triggers, and the names of their sensors."""
        triggers = [(f"inflator[{k}]", spec.trigger) for k, spec in enumerate(self.inflator)]
        triggers += [(f"vent[{k}]", spec.trigger) for k, spec in enumerate(self.vent)]
        return ((f"{key}.trigger", name) for key, name in triggers if name is not None)

    def describe(self) -> str:
        """Describe the table in words."""
        parts = [
            f"{len(openings)} {noun}{'' if len(openings) == 1 else 's'}"
            for openings, noun in ((self.inflator, "inflator"), (self.vent, "vent"))
            if openings
        ]
        parts += ["leaks"] if self.leak else []
        return f"in slave {self.slave}{''.join(f', {part}' for part in parts)}"
