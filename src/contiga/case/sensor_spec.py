"""The `sensor` tables of a case: motion of points of bodies and of nodes, and sections."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from contiga.case.device_spec import TriggerSpec
from contiga.case.spec import DiscriminatedBy, InstanceSpec, Name, Pair, Vector, has_rows, must_be
from contiga.criteria.bands import Bands
from contiga.simulation.sensor import RELATIVE_MEASURES, RelativeSensor, Sensor
from contiga.simulation.slave_sensor import (
    NODE_MEASURES,
    SECTION_MEASURES,
    NodeSensor,
    SectionSensor,
)

Axes = Annotated[
    str | list[Vector],
    must_be(
        lambda value: isinstance(value, str) or has_rows(value),
        "must be a word, or three unit vectors",
        '"world", "body" or [[x, y, z], [x, y, z], [x, y, z]]',
    ),
]
"""A word, or three unit vectors at the start, which turn with the body."""


class BandsSpec(InstanceSpec[Bands]):
    """`{ limits, names }`: `Bands` of a criterion."""

    makes = Bands
    limits: list[float]
    names: list[str]


class PointSensorSpec(InstanceSpec[Sensor]):
    """A `[[sensor]]`: `Sensor`, with all its options."""

    makes = Sensor
    name: Name
    body: Name
    at: Vector | None = None
    """The point, at its place at the start; the centre of mass of a free body if omitted."""
    axes: Axes = "world"
    measures: list[str] = Field(default=["acceleration", "velocity", "displacement"])
    filter: str | None = None
    criteria: list[str] = Field(default_factory=list)
    bands: dict[str, BandsSpec] | None = None
    """Bands by criterion."""
    code: str | None = None
    """Code of its channels in ISO-MME files."""
    trigger: TriggerSpec | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        at = "" if self.at is None else f" at {self.at}"
        outputs = [*self.measures, *([self.filter] if self.filter else []), *self.criteria]
        outputs += [] if self.trigger is None else [self.trigger.describe()]
        axes = f"{self.axes} axes" if isinstance(self.axes, str) else "axes of its own"
        return f"on {self.body}{at}, {axes}: {', '.join(outputs)}"


class RelativeSensorSpec(InstanceSpec[RelativeSensor]):
    """A `[[sensor]]` with `between`: `RelativeSensor`, with all its options."""

    makes = RelativeSensor
    name: Name
    between: Annotated[list[Name], Field(min_length=2, max_length=2)]
    """Two bodies: the motion of the second is measured in the axes of the first."""
    at: Pair | None = None
    axes: Axes = "body"
    measures: list[str] = Field(default_factory=lambda: list(RELATIVE_MEASURES))
    criteria: list[str] = Field(default_factory=list)
    bands: dict[str, BandsSpec] | None = None
    dummy: str = "HIII-50"
    """Dummy whose neck and chest criteria apply."""
    code: str | None = None
    trigger: TriggerSpec | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        at = "" if self.at is None else f" at {self.at}"
        fires = [] if self.trigger is None else [self.trigger.describe()]
        outputs = ", ".join([*self.measures, *self.criteria, *fires])
        return f"between {' and '.join(self.between)}{at}: {outputs}"


class NodeSensorSpec(InstanceSpec[NodeSensor]):
    """A `[[sensor]]` with `node`: `NodeSensor`, with all its options."""

    makes = NodeSensor
    name: Name
    node: Name
    """Name of a slave."""
    at: Vector
    """A point near the node, at its place at the start."""
    measures: list[str] = Field(default_factory=lambda: list(NODE_MEASURES))
    code: str | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        return f"of the node of {self.node} at {self.at}: {', '.join(self.measures)}"


class SectionSensorSpec(InstanceSpec[SectionSensor]):
    """A `[[sensor]]` with `section`: `SectionSensor`, with all its options."""

    makes = SectionSensor
    name: Name
    section: Name
    """Name of a deforming slave."""
    plane: Pair
    """A point and the normal."""
    measures: list[str] = Field(default_factory=lambda: list(SECTION_MEASURES))
    code: str | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        point, normal = self.plane
        plane = f"the plane through {point} across {normal}"
        return f"of {self.section} cut by {plane}: {', '.join(self.measures)}"


SensorSpec = Annotated[
    PointSensorSpec | RelativeSensorSpec | NodeSensorSpec | SectionSensorSpec,
    DiscriminatedBy("body", "between", "node", "section"),
]
