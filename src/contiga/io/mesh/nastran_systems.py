"""Coordinate systems of a Nastran deck, and the places of its grid points.

Card layouts: MSC Nastran Quick Reference Guide, CORD1R … CORD2S, GRID, GRDSET.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.errors import MeshError
from contiga.io.mesh.nastran_cards import Card
from contiga.records import FloatArray

Place = tuple[float, float, float]
CORDS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")


class _Grid(NamedTuple):
    system: int
    place: Place
    where: str


class _System(NamedTuple):
    kind: str
    """Type of the system: R, C or S."""
    within: int
    """System in which the three points are given; -1 for grid points."""
    points: tuple[Place, ...]
    grids: tuple[int, ...]
    where: str


class _Axes(NamedTuple):
    kind: str
    origin: FloatArray
    rows: FloatArray
    """(3, 3) x, y, z as rows."""


class Grids:
    """Grid points and systems as they are read; `positions` once all are known."""

    def __init__(self) -> None:
        self._grids: dict[int, _Grid] = {}
        self._systems: dict[int, _System] = {}
        self._axes: dict[int, _Axes] = {0: _Axes("R", np.zeros(3), np.eye(3))}
        self._default = 0
        self._asked: list[int] = []

    def grid(self, card: Card) -> None:
        """Read GRID; one given twice must be equal."""
        system = card.whole(1) if card.text(1) else -1
        grid = _Grid(system, card.place(2), card.where)
        known = self._grids.setdefault(card.whole(0), grid)
        if known[:2] != grid[:2]:
            raise MeshError(
                "a grid point is given twice, in different places",
                where=card.where,
                found=card.whole(0),
                allowed="each number once",
            )

    def defaults(self, card: Card) -> None:
        """Read GRDSET: the system of grid points that name none."""
        self._default = card.whole(1)

    def system(self, card: Card) -> None:
        """Read CORD1 by grid points, two per card, or CORD2 by places."""
        kind = card.name[-1]
        if card.name.startswith("CORD1"):
            for k in (0, 4):
                if card.text(k):
                    grids = card.whole(k + 1), card.whole(k + 2), card.whole(k + 3)
                    self._put(card.whole(k), _System(kind, -1, (), grids, card.where))
        else:
            points = tuple(card.place(k) for k in (2, 5, 8))
            self._put(card.whole(0), _System(kind, card.whole(1), points, (), card.where))

    def _put(self, number: int, system: _System) -> None:
        known = self._systems.setdefault(number, system)
        if known[:4] != system[:4]:
            raise MeshError("a system is given twice", where=system.where, found=number)

    def positions(self) -> dict[int, Place]:
        """Return the places of all grid points in the basic system, in the file's order.

        Raises
        ------
        MeshError
            A system that is not there, stands on itself, or whose points lie on a line.
        """
        return {number: self._position(number, "") for number in self._grids}

    def _position(self, number: int, where: str) -> Place:
        if number not in self._grids:
            raise MeshError("no grid point of that number", where=where, found=number)
        grid = self._grids[number]
        system = self._default if grid.system < 0 else grid.system
        if system == 0:
            return grid.place
        x, y, z = self._to_basic(system, grid.place, grid.where).tolist()
        return x, y, z

    def _to_basic(self, number: int, place: Place, where: str) -> FloatArray:
        axes = self._axes_of(number, where)
        a, b, c = place
        if axes.kind == "C":  # radius, angle, z
            place = (a * math.cos(math.radians(b)), a * math.sin(math.radians(b)), c)
        elif axes.kind == "S":  # radius, angle from z, angle about z
            flat = a * math.sin(math.radians(b))
            turn = math.radians(c)
            place = (flat * math.cos(turn), flat * math.sin(turn), a * math.cos(math.radians(b)))
        moved: FloatArray = axes.origin + np.array(place) @ axes.rows
        return moved

    def _axes_of(self, number: int, where: str) -> _Axes:
        if number in self._axes:
            return self._axes[number]
        system = self._systems.get(number)
        if system is None:
            raise MeshError(
                "no system of that number",
                where=where,
                found=number,
                allowed=", ".join(map(str, sorted({0, *self._systems}))),
            )
        if number in self._asked:
            raise MeshError(
                "a coordinate system is defined by itself", where=system.where, found=number
            )
        self._asked.append(number)
        if system.within < 0:
            points = [np.array(self._position(grid, system.where)) for grid in system.grids]
        else:
            points = [self._to_basic(system.within, p, system.where) for p in system.points]
        self._asked.pop()
        self._axes[number] = _Axes(system.kind, points[0], _rows(points, system.where))
        return self._axes[number]


def _rows(points: list[FloatArray], where: str) -> FloatArray:
    """Return the axes of a system from three points.

    The second point is on z, the third in the half-plane of x and z.
    """
    a, b, c = points
    z = b - a
    y = np.cross(z, c - a)
    if not np.linalg.norm(y) > 1e-12 * np.linalg.norm(z) * np.linalg.norm(c - a):
        raise MeshError("the three points of a system lie on a line", where=where)
    z = z / np.linalg.norm(z)
    y = y / np.linalg.norm(y)
    return np.array([np.cross(y, z), y, z])
