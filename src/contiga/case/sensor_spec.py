"""The `sensor` tables of a case: points of bodies whose motion is told."""

from __future__ import annotations

from functools import cached_property
from typing import Self

from pydantic import Field, model_validator

from contiga.case.spec import Name, Spec, Vector
from contiga.simulation.sensor import Sensor


class SensorSpec(Spec):
    """A `[[sensor]]`: `Sensor`, with all its options."""

    name: Name
    body: Name
    at: Vector | None = None
    """The point, where it is at the start; the centre of mass of a free body if omitted."""
    axes: str = "world"
    measures: list[str] = Field(default=["acceleration", "velocity", "displacement"])
    filter: str | None = None
    criteria: list[str] = Field(default_factory=list)

    @cached_property
    def sensor(self) -> Sensor:
        """The sensor."""
        return Sensor(
            self.name,
            self.body,
            at=self.at,
            axes=self.axes,
            measures=self.measures,
            filter=self.filter,
            criteria=self.criteria,
        )

    @model_validator(mode="after")
    def _sensor_is_possible(self) -> Self:
        assert self.sensor is not None
        return self

    def describe(self) -> str:
        """In words."""
        at = "" if self.at is None else f" at {self.at}"
        told = [*self.measures, *([self.filter] if self.filter else []), *self.criteria]
        return f"on {self.body}{at}, {self.axes} axes: {', '.join(told)}"
