"""What an area method is given, and what it answers."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

from contiga.geometry.body import Body
from contiga.records import FloatArray, IntArray, Projection


class AreaInput(NamedTuple):
    """The points in contact, as an area method sees them."""

    body: Body
    """The master."""
    rows: IntArray
    """(n_c,) rows of the points in contact."""
    points: FloatArray
    """(n, 3) all slave points, body frame."""
    feet: Projection
    """n_c rows: the feet of the points in contact, body frame."""
    slave_area: FloatArray | None
    """(n,) tributary areas of the slave, where it has them."""


class Areas(NamedTuple):
    """Nodal contact areas, and the connected regions they belong to."""

    area: FloatArray
    """(n_c,) length²."""
    clusters: IntArray
    """(n_c,) number of the region, from 0."""


@runtime_checkable
class AreaMethod(Protocol):
    """How much area each point in contact stands for."""

    def measure(self, inp: AreaInput) -> Areas:
        """Areas of the points in contact; empty arrays where there are none."""
        ...  # pragma: no cover
