"""The `sensor` tables of a case: points of bodies and nodes whose motion is told, and sections."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from contiga.case.spec import Name, Spec, Vector, by_key
from contiga.criteria.bands import Bands
from contiga.simulation.sensor import RELATIVE_MEASURES, RelativeSensor, Sensor
from contiga.simulation.slave_sensor import (
    NODE_MEASURES,
    SECTION_MEASURES,
    NodeSensor,
    SectionSensor,
)


class BandsSpec(Spec):
    """`{ limits, names }`: `Bands` of a criterion."""

    limits: list[float]
    names: list[str]

    @cached_property
    def bands(self) -> Bands:
        """The bands."""
        return Bands(self.limits, self.names)

    @model_validator(mode="after")
    def _bands_are_possible(self) -> Self:
        assert self.bands is not None
        return self


class PointSensorSpec(Spec):
    """A `[[sensor]]`: `Sensor`, with all its options."""

    name: Name
    body: Name
    at: Vector | None = None
    """The point, where it is at the start; the centre of mass of a free body if omitted."""
    axes: str = "world"
    measures: list[str] = Field(default=["acceleration", "velocity", "displacement"])
    filter: str | None = None
    criteria: list[str] = Field(default_factory=list)
    bands: dict[str, BandsSpec] | None = None
    """By criterion."""
    code: str | None = None
    """Of its channels in ISO-MME files."""

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
            bands={name: one.bands for name, one in (self.bands or {}).items()},
            code=self.code,
        )

    @model_validator(mode="after")
    def _sensor_is_possible(self) -> Self:
        assert self.sensor is not None
        return self

    def describe(self) -> str:
        """In words."""
        at = "" if self.at is None else f" at {self.at}"
        outputs = [*self.measures, *([self.filter] if self.filter else []), *self.criteria]
        return f"on {self.body}{at}, {self.axes} axes: {', '.join(outputs)}"


class RelativeSensorSpec(Spec):
    """A `[[sensor]]` with `between`: `RelativeSensor`, with all its options."""

    name: Name
    between: Annotated[list[Name], Field(min_length=2, max_length=2)]
    """Two bodies, the first of which sees the second."""
    at: Annotated[list[Vector], Field(min_length=2, max_length=2)] | None = None
    axes: str = "body"
    measures: list[str] = Field(default_factory=lambda: list(RELATIVE_MEASURES))
    criteria: list[str] = Field(default_factory=list)
    bands: dict[str, BandsSpec] | None = None
    dummy: str = "HIII-50"
    """Whose neck and chest criteria are of."""
    code: str | None = None

    @cached_property
    def sensor(self) -> RelativeSensor:
        """The sensor."""
        return RelativeSensor(
            self.name,
            self.between,
            at=self.at,
            axes=self.axes,
            measures=self.measures,
            criteria=self.criteria,
            bands={name: one.bands for name, one in (self.bands or {}).items()},
            dummy=self.dummy,
            code=self.code,
        )

    @model_validator(mode="after")
    def _sensor_is_possible(self) -> Self:
        assert self.sensor is not None
        return self

    def describe(self) -> str:
        """In words."""
        at = "" if self.at is None else f" at {self.at}"
        outputs = ", ".join([*self.measures, *self.criteria])
        return f"between {' and '.join(self.between)}{at}: {outputs}"


class NodeSensorSpec(Spec):
    """A `[[sensor]]` with `node`: `NodeSensor`, with all its options."""

    name: Name
    node: Name
    """A slave."""
    at: Vector
    """Near to the node, where the slave stands."""
    measures: list[str] = Field(default_factory=lambda: list(NODE_MEASURES))
    code: str | None = None

    @cached_property
    def sensor(self) -> NodeSensor:
        """The sensor."""
        return NodeSensor(self.name, self.node, at=self.at, measures=self.measures, code=self.code)

    @model_validator(mode="after")
    def _sensor_is_possible(self) -> Self:
        assert self.sensor is not None
        return self

    def describe(self) -> str:
        """In words."""
        return f"of the node of {self.node} at {self.at}: {', '.join(self.measures)}"


class SectionSensorSpec(Spec):
    """A `[[sensor]]` with `section`: `SectionSensor`, with all its options."""

    name: Name
    section: Name
    """A slave that deforms."""
    plane: Annotated[list[Vector], Field(min_length=2, max_length=2)]
    """A point and the normal."""
    measures: list[str] = Field(default_factory=lambda: list(SECTION_MEASURES))
    code: str | None = None

    @cached_property
    def sensor(self) -> SectionSensor:
        """The sensor."""
        return SectionSensor(
            self.name, self.section, plane=self.plane, measures=self.measures, code=self.code
        )

    @model_validator(mode="after")
    def _sensor_is_possible(self) -> Self:
        assert self.sensor is not None
        return self

    def describe(self) -> str:
        """In words."""
        point, normal = self.plane
        where = f"the plane through {point} across {normal}"
        return f"of {self.section} cut by {where}: {', '.join(self.measures)}"


if TYPE_CHECKING:
    SensorSpec = PointSensorSpec | RelativeSensorSpec | NodeSensorSpec | SectionSensorSpec
else:
    SensorSpec = by_key(
        body=PointSensorSpec,
        between=RelativeSensorSpec,
        node=NodeSensorSpec,
        section=SectionSensorSpec,
    )
