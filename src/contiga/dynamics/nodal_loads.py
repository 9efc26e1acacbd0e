"""Loads on the nodes of what deforms: pressures on facets, forces shared by nodes."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only
from contiga.curves.tables import table_of
from contiga.dynamics.loads import _at, _over_time
from contiga.dynamics.pieces import Pieces, pieces_between
from contiga.dynamics.places import facets_at, nodes_at, place_of
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.slaves.quads import (
    SkinCorners,
    at_corners,
    corner_areas,
    corner_vectors,
    corners_of,
)
from contiga.slaves.slave import Slave


class NodalForces(Protocol):
    """A load, once it knows its nodes."""

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the forces (n, 3) on nodes at points (n, 3)."""


class _OverTime:
    """Base of loads over time."""

    value: FloatArray | Pieces

    def at_time(self, t: float) -> Self:
        """A constant load, as this one is at time `t`."""
        constant = copy(self)
        object.__setattr__(constant, "value", read_only(_at(self.value, t).copy()))
        return constant

    @property
    def span(self) -> tuple[float, float] | None:
        """First and last time that its table covers; None for a constant load."""
        value = self.value
        return (value.times[0], value.times[-1]) if isinstance(value, Pieces) else None

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end so that none of its impulse is lost."""
        return self.value.kinks() if isinstance(self.value, Pieces) else np.zeros(0)


@dataclass(frozen=True, init=False, eq=False)
class Pressure(_OverTime):
    """A pressure on facets of a slave that deforms, across them wherever they turn.

    It pushes against their normals: into solids. A balloon whose normals point outward is blown up
    by a negative one.

    Parameters
    ----------
    pressure : force / area, a number, or (k, 2) rows t, p with t strictly increasing
    on : which facets: a table of one place as `Deforming(fixed=…)` has them, ``{"plane": …}``;
        facets all of whose corners are there. All of them if omitted
    smooth : monotone cubics between the rows in place of straight lines

    Raises
    ------
    InputError
        No number and no rows, a table that is no place.

    Examples
    --------
    >>> import contiga as cg
    >>> blown = cg.motion.Pressure([[0.0, 0.0], [5.0, -0.02]])
    >>> blown.span
    (0.0, 5.0)
    """

    value: FloatArray | Pieces
    on: Mapping[str, Any]

    def __init__(
        self, pressure: ArrayLike, *, on: Mapping[str, Any] | None = None, smooth: bool = False
    ) -> None:
        put = object.__setattr__
        put(self, "value", _number_over_time(pressure, smooth))
        put(self, "on", dict(on or {}))

    def nodes(self, slave: Slave, where: str) -> NodalForces:
        """The load with the facets of a slave."""
        key = place_of(self.on, (), where)
        facets = facets_at(key, self.on.get(key or ""), slave, where)
        if slave.facets is None or not facets.any():
            raise InputError(
                "no facet has all its corners there",
                where=where,
                found=self.on,
                allowed="a larger place",
            )
        return _OnFacets(self, corners_of(slave.facets, slave.quads, facets))


@dataclass(frozen=True, init=False, eq=False)
class NodalForce(_OverTime):
    """A force on nodes of a slave that deforms, in a direction that stays.

    Parameters
    ----------
    force : (3,) in all, or (k, 4) rows t, x, y, z with t strictly increasing; world axes
    on : which nodes: a table of one place as `Deforming(fixed=…)` has them; all if omitted. Where
        they are all corners of facets they share it by the areas of these at rest, else evenly
    smooth : monotone cubics between the rows in place of straight lines

    Raises
    ------
    InputError
        No vector and no rows, a table that is no place.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.motion.NodalForce([0, 0, -5.0], on={"layer": ([1, 0, 0], 0.0)}).value.tolist()
    [0.0, 0.0, -5.0]
    """

    value: FloatArray | Pieces
    on: Mapping[str, Any]

    def __init__(
        self, force: ArrayLike, *, on: Mapping[str, Any] | None = None, smooth: bool = False
    ) -> None:
        put = object.__setattr__
        put(self, "value", _over_time(force, "force", smooth))
        put(self, "on", dict(on or {}))

    def nodes(self, slave: Slave, where: str) -> NodalForces:
        """The load with the nodes of a slave."""
        key = place_of(self.on, (), where)
        return _Shared(self, shares_at(key, self.on.get(key or ""), slave, where))


def shares_at(key: str | None, value: Any, slave: Slave, where: str) -> FloatArray:
    """Return the shares (n,), 1 in all, of the nodes of a slave at a place.

    By the areas of facets at rest, where the nodes are all corners of facets that are wholly at the
    place; evenly elsewhere.

    Parameters
    ----------
    key, value, where : as of `contiga.dynamics.places.nodes_at`
    slave : slave with the nodes

    Raises
    ------
    InputError
        As `nodes_at`.
    """
    rows = nodes_at(key, value, slave, where)
    if slave.facets is not None:
        facets = facets_at(key, value, slave, where)
        if facets.any() and np.isin(np.flatnonzero(rows), slave.facets[facets]).all():
            skin = corners_of(slave.facets, slave.quads, facets)
            areas = at_corners(skin, corner_areas(slave.points, skin), len(slave))
            return areas / areas.sum()
    return rows / rows.sum()


class _OnFacets(NamedTuple):
    load: Pressure
    skin: SkinCorners

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """−p ∫ N n dA at the corners of faces: the gradient of the volume they close."""
        pressure = float(_at(self.load.value, time)[0])
        if pressure == 0.0:
            return np.zeros(points.shape)
        quads, triangles = corner_vectors(points, self.skin)
        sums = [
            at_corners(self.skin, (quads[..., k], triangles[..., k]), len(points)) for k in range(3)
        ]
        return -pressure * np.stack(sums, axis=1)


class _Shared(NamedTuple):
    load: NodalForce
    shares: FloatArray
    """(n,) of each node, 1 in all."""

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Each node its share."""
        return self.shares[:, None] * _at(self.load.value, time)


def _number_over_time(given: ArrayLike, smooth: bool) -> FloatArray | Pieces:
    """A number, or one over time, as the first of three."""
    if np.ndim(given) == 0:
        try:
            number = float(given)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            number = np.nan
        if not np.isfinite(number):
            raise InputError(
                "must be a number, or rows", where="pressure", found=given, allowed="p, or [t, p]"
            )
        return read_only(np.array([number, 0.0, 0.0]))
    rows = table_of(given, ("t", "p"), where="pressure", at_least=2)
    padded = np.concatenate([rows[:, 1:], np.zeros((len(rows), 2))], axis=1)
    return pieces_between(read_only(rows[:, 0]), padded, smooth=smooth)
