"""Define sensors of slaves: the motion of a node, and the force through a section of elements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only
from contiga.arrays.ordered import length, row_products
from contiga.criteria.bands import Bands
from contiga.dynamics.places import box_text
from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray
from contiga.rigid.transform import vector
from contiga.simulation.sensor import SPRING_MEASURES, _checked_code, _checked_names, _two_points

NODE_MEASURES = ("displacement", "velocity")
SECTION_MEASURES = SPRING_MEASURES
MAX_DISTANCE = 0.5
"""Largest distance of a node from the place of its sensor, as a share of the slave's diagonal."""


@dataclass(frozen=True, init=False, eq=False)
class NodeSensor:
    """A sensor of the motion of a node of a driven, free or deforming slave.

    Parameters
    ----------
    name : prefix of its columns
    node : name of the slave
    at : (3,) where the slave stands before the run: its node nearest to this is measured, which
        is to be within half of the slave's size
    measures : of "displacement" (from where the slave stands before the run) and "velocity", along
        the axes of the world
    code : as of a `Sensor`

    Raises
    ------
    InputError
        Unknown measures, a place that is none, a code of other than 12 capital letters and digits.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.NodeSensor("tip", "beam", at=[100, 0, 0]).measures
    ('displacement', 'velocity')
    """

    criteria: ClassVar[tuple[str, ...]] = ()
    bands: ClassVar[Mapping[str, Bands]] = {}

    name: str
    node: str
    at: FloatArray
    measures: tuple[str, ...]
    code: str | None

    def __init__(
        self,
        name: str,
        node: str,
        *,
        at: ArrayLike,
        measures: Iterable[str] = NODE_MEASURES,
        code: str | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "name", name)
        put(self, "node", node)
        put(self, "at", read_only(vector(at, "at")))
        put(self, "measures", _checked_names("measures", measures, NODE_MEASURES))
        put(self, "code", _checked_code(code))


@dataclass(frozen=True, init=False, eq=False)
class SectionSensor:
    """A sensor of the force that elements carry through a plane section of a slave.

    The nodes beyond the plane, on the side of its normal, belong to the section throughout the run.
    The force is the sum of all element forces on these nodes: the force of the remaining part on
    the part beyond. In a slave in tension it points against the normal. Contacts, loads, weight and
    damping of the nodes are not included.

    Parameters
    ----------
    name : prefix of its columns
    section : name of a slave that deforms
    plane : (2, 3) a point and the normal of the plane, where the slave stands before the run
    measures : of "force" and "moment", that about the point of the plane, which stays; along the
        axes of the world
    code : as of a `Sensor`

    Raises
    ------
    InputError
        Unknown measures, a plane without a normal, a code of other than 12 capital letters and
        digits.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.SectionSensor("root", "beam", plane=[[5, 0, 0], [1, 0, 0]]).measures
    ('force', 'moment')
    """

    criteria: ClassVar[tuple[str, ...]] = ()
    bands: ClassVar[Mapping[str, Bands]] = {}

    name: str
    section: str
    plane: FloatArray
    measures: tuple[str, ...]
    code: str | None

    def __init__(
        self,
        name: str,
        section: str,
        *,
        plane: ArrayLike,
        measures: Iterable[str] = SECTION_MEASURES,
        code: str | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "name", name)
        put(self, "section", section)
        both = _two_points(plane, "plane")
        if not both[1].any():
            raise InputError(
                "has no normal",
                where="plane",
                found=both.tolist(),
                allowed="a point and a direction that is not zero",
            )
        put(self, "plane", both)
        put(self, "measures", _checked_names("measures", measures, SECTION_MEASURES))
        put(self, "code", _checked_code(code))


SlaveSensor = NodeSensor | SectionSensor


def slave_of(sensor: SlaveSensor) -> str:
    """Return the name of the slave that a sensor is on."""
    return sensor.node if isinstance(sensor, NodeSensor) else sensor.section


def nodes_of(sensor: SlaveSensor, points: FloatArray) -> IndexArray:
    """Return the numbers (k,) of the nodes of a slave with points (n, 3) that a sensor measures.

    These are the node nearest to the place of a node sensor, or all nodes of a section sensor that
    lie on the side to which its normal points.

    Raises
    ------
    InputError
        All nodes of a slave are on one side of a section, or the nearest is farther from a place
        than `MAX_DISTANCE` of the slave's diagonal (unless the slave has only one node).
    """
    if isinstance(sensor, NodeSensor):
        away = points - sensor.at
        nearest = np.argmin(row_products(away, away), keepdims=True)
        distance, size = length(away[nearest[0]]), length(np.ptp(points, axis=0))
        if len(points) > 1 and distance > MAX_DISTANCE * size:
            raise InputError(
                f"no node is near: the nearest one, {nearest[0]}, is {distance:.6g} away",
                where=f"sensor {sensor.name!r}: at",
                found=sensor.at.tolist(),
                allowed=f"a place within {MAX_DISTANCE * size:.6g} of a node of the slave, which "
                f"reaches {box_text(points)}",
            )
        return nearest
    point, normal = sensor.plane
    height = row_products(points - point, normal)
    beyond = np.flatnonzero(height > 0.0)
    if len(beyond) in (0, len(points)):
        raise InputError(
            "all nodes of the slave are on one side of it",
            where=f"sensor {sensor.name!r}: plane",
            found=sensor.plane.tolist(),
            allowed=f"a plane through the slave: nodes {box_text(points)}",
        )
    return beyond
