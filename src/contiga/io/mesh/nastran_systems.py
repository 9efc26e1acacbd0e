"""Coordinate systems of a Nastran deck, and the positions of its grid points.

Card layouts: MSC Nastran Quick Reference Guide, CORD1R … CORD2S, GRID, GRDSET.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.errors import MeshError
from contiga.io.mesh.deck_text import Position, orthonormal_axes
from contiga.io.mesh.nastran_cards import Card
from contiga.records import FloatArray

CORDS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")


class _Grid(NamedTuple):
    system: int
    """System of the coordinates; -1 for the default of GRDSET."""
    position: Position
    """Coordinates in that system; angles in degrees."""
    where: str


class _System(NamedTuple):
    kind: str
    """Type of the system: R, C or S."""
    within: int
    """System in which the three points are given; -1 for grid points."""
    points: tuple[Position, ...]
    """Origin, a point on z and one in the x-z plane; empty if grid points are named."""
    grids: tuple[int, ...]
    """Numbers of the grid points that stand for these points; else empty."""
    where: str


class _Axes(NamedTuple):
    kind: str
    """Type of the system: R, C or S."""
    origin: FloatArray
    """(3,) in the basic system."""
    rows: FloatArray
    """(3, 3) unit vectors x, y, z as rows, in the basic system."""


class Grids:
    """Grid points and coordinate systems of a deck, collected card by card in any order.

    `positions` resolves the systems once all cards are read.
    """

    def __init__(self) -> None:
        self._grids: dict[int, _Grid] = {}
        self._systems: dict[int, _System] = {}
        self._axes: dict[int, _Axes] = {0: _Axes("R", np.zeros(3), np.eye(3))}
        self._default_system = 0
        self._pending: list[int] = []
        """Systems whose axes are being computed."""

    def read_grid(self, card: Card) -> None:
        """Store the grid point of a GRID card.

        Raises
        ------
        MeshError
            A field is no number, or the number exists with another system or coordinates.
        """
        system = card.whole(1) if card.text(1) else -1
        grid = _Grid(system, card.position(2), card.where)
        first = self._grids.setdefault(card.whole(0), grid)
        if first[:2] != grid[:2]:
            raise MeshError(
                "a grid point is given twice, in different places",
                where=card.where,
                found=card.whole(0),
                allowed="each number once",
            )

    def read_defaults(self, card: Card) -> None:
        """Store the system of grid points that name none, before or after this GRDSET card."""
        self._default_system = card.whole(1)

    def read_system(self, card: Card) -> None:
        """Store the systems of a card: one or two of a CORD1, by grid points, one of a CORD2.

        Raises
        ------
        MeshError
            A field is no number, or the number exists with another definition.
        """
        kind = card.name[-1]
        if card.name.startswith("CORD1"):
            for k in (0, 4):
                if card.text(k):
                    grids = card.whole(k + 1), card.whole(k + 2), card.whole(k + 3)
                    self._add_system(card.whole(k), _System(kind, -1, (), grids, card.where))
        else:
            points = tuple(card.position(k) for k in (2, 5, 8))
            system = _System(kind, card.whole(1), points, (), card.where)
            self._add_system(card.whole(0), system)

    def _add_system(self, number: int, system: _System) -> None:
        first = self._systems.setdefault(number, system)
        if first[:4] != system[:4]:
            raise MeshError("a system is given twice", where=system.where, found=number)

    def positions(self) -> dict[int, Position]:
        """Return the positions of all grid points in the basic system, by number in file order.

        Raises
        ------
        MeshError
            A system or its grid point does not exist, a system refers to itself, also over
            others, or its points lie on a line.
        """
        return {number: self._position(number, "") for number in self._grids}

    def _position(self, number: int, where: str) -> Position:
        """Return a grid point's x, y, z in the basic system; without it, `MeshError` at `where`."""
        if number not in self._grids:
            raise MeshError("no grid point of that number", where=where, found=number)
        grid = self._grids[number]
        system = self._default_system if grid.system < 0 else grid.system
        if system == 0:
            return grid.position
        x, y, z = self._to_basic(system, grid.position, grid.where).tolist()
        return x, y, z

    def _to_basic(self, number: int, position: Position, where: str) -> FloatArray:
        """Return a position in a system (angles in degrees) as a point (3,) of the basic system."""
        axes = self._axes_of(number, where)
        a, b, c = position
        if axes.kind == "C":  # radius, angle, z
            position = (a * math.cos(math.radians(b)), a * math.sin(math.radians(b)), c)
        elif axes.kind == "S":  # radius, angle from z, angle about z
            flat = a * math.sin(math.radians(b))
            azimuth = math.radians(c)
            height = a * math.cos(math.radians(b))
            position = (flat * math.cos(azimuth), flat * math.sin(azimuth), height)
        basic: FloatArray = axes.origin + np.array(position) @ axes.rows
        return basic

    def _axes_of(self, number: int, where: str) -> _Axes:
        """Return the axes of a system; they are computed once, with the systems it refers to.

        Raises
        ------
        MeshError
            The system does not exist, is defined by itself, or its points lie on a line.
        """
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
        if number in self._pending:
            raise MeshError(
                "a coordinate system is defined by itself", where=system.where, found=number
            )
        self._pending.append(number)
        if system.within < 0:
            points = [np.array(self._position(grid, system.where)) for grid in system.grids]
        else:
            points = [self._to_basic(system.within, p, system.where) for p in system.points]
        self._pending.pop()
        a, b, c = points
        z, x, y = orthonormal_axes(b - a, c - a, system.where)
        axes = _Axes(system.kind, a, np.array([x, y, z]))
        self._axes[number] = axes
        return axes
