"""Loads on deforming nodes: pressures on facets, and forces shared by nodes."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only
from contiga.curves.tables import table_of
from contiga.dynamics.loads import value_at, vector_over_time
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
    """A load on the nodes of one slave."""

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the forces (n, 3) on nodes at points (n, 3)."""


class _OverTime:
    """Base of loads over time."""

    value: FloatArray | Pieces

    def at_time(self, t: float) -> Self:
        """Return a constant load with the value at time `t`."""
        constant = copy(self)
        object.__setattr__(constant, "value", read_only(value_at(self.value, t).copy()))
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
    """A pressure on facets of a slave that deforms, normal to them as they turn.

    It acts against their normals: into solids. A negative pressure inflates a balloon whose normals
    point outward.

    Parameters
    ----------
    pressure : force / area, a number, or (k, 2) rows t, p with t strictly increasing
    on : facets all of whose corners are at a place: a table as for `Deforming(fixed=…)`, such as
        ``{"plane": …}``; all facets if omitted
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
    """Pressure as the first of three numbers."""
    on: Mapping[str, Any]

    def __init__(
        self, pressure: ArrayLike, *, on: Mapping[str, Any] | None = None, smooth: bool = False
    ) -> None:
        if np.ndim(pressure) == 0:
            try:
                number = float(pressure)  # type: ignore[arg-type]
            except (TypeError, ValueError):
                number = np.nan
            if not np.isfinite(number):
                raise InputError(
                    "must be a number, or rows",
                    where="pressure",
                    found=pressure,
                    allowed="p, or [t, p]",
                )
            value: FloatArray | Pieces = read_only(np.array([number, 0.0, 0.0]))
        else:
            rows = table_of(pressure, ("t", "p"), where="pressure", at_least=2)
            vectors = np.concatenate([rows[:, 1:], np.zeros((len(rows), 2))], axis=1)
            value = pieces_between(read_only(rows[:, 0]), vectors, smooth=smooth)
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "on", dict(on or {}))

    def nodes(self, slave: Slave, where: str) -> NodalForces:
        """Return the load on the facets of a slave.

        Raises
        ------
        InputError
            A slave without facets, an invalid place, or no facet with all its corners there.
        """
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
    """A force on nodes of a slave that deforms, in a fixed direction.

    Parameters
    ----------
    force : (3,) total, or (k, 4) rows t, x, y, z with t strictly increasing; world axes
    on : nodes at a place: a table as for `Deforming(fixed=…)`; all if omitted. If they are all
        corners of facets there, they share the force by the areas of these at rest, else evenly
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
        put(self, "value", vector_over_time(force, "force", smooth))
        put(self, "on", dict(on or {}))

    def nodes(self, slave: Slave, where: str) -> NodalForces:
        """Return the load on the nodes of a slave, with shares by their areas at rest.

        Raises
        ------
        InputError
            See `shares_at`.
        """
        key = place_of(self.on, (), where)
        return _Shared(self, shares_at(key, self.on.get(key or ""), slave, where))


def shares_at(key: str | None, value: Any, slave: Slave, where: str) -> FloatArray:
    """Return the shares (n,), 1 in total, of the nodes of a slave at a place.

    They are proportional to the areas of facets at rest, if the nodes are all corners of facets
    that are wholly at the place, else equal.

    Parameters
    ----------
    key, value, where : see `contiga.dynamics.places.nodes_at`
    slave : slave with the nodes

    Raises
    ------
    InputError
        See `nodes_at`.
    """
    mask = nodes_at(key, value, slave, where)
    if slave.facets is not None:
        facets = facets_at(key, value, slave, where)
        if facets.any() and np.isin(np.flatnonzero(mask), slave.facets[facets]).all():
            skin = corners_of(slave.facets, slave.quads, facets)
            areas = at_corners(skin, corner_areas(slave.points, skin), len(slave))
            return areas / areas.sum()
    return mask / mask.sum()


class _OnFacets(NamedTuple):
    load: Pressure
    skin: SkinCorners

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the forces (n, 3) −p ∫ N n dA at all nodes, −p times the gradient of the volume.

        They are zero at nodes that are no corner of a face; p is zero outside its rows.
        """
        pressure = float(value_at(self.load.value, time)[0])
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
    """(n,) of each node, 1 in total."""

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the share (n, 3) of each node in the force; zero outside the force's rows."""
        return self.shares[:, None] * value_at(self.load.value, time)
