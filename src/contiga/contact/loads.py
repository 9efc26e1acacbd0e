"""What a state keeps of the points in contact: some rows, of which whole arrays can be made."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.contact.force_records import Column
from contiga.contact.sparse import Sparse
from contiga.records import FloatArray, IndexArray, IntArray

NOWHERE = np.zeros((0, 3))
"""Velocities that are not told, and forces there are none of."""
NONE = np.zeros(0)
NO_ROWS = np.zeros(0, np.int32)
NO_SIZES, NO_FORCES = Column(NO_ROWS, NONE), Column(NO_ROWS, NOWHERE)
NO_MEMORY = np.zeros((0, 0))
OF_HELD = {"penetration": "penetration", "normal_B": "normal", "foot_B": "foot"}
"""Array of a state -> field of `Loads` with its rows of the points in contact."""
OF_CARRYING = {
    "normal_force": "normal_force",
    "stiffness": "stiffness",
    "memory": "memory",
    "force": "world",
    "damping": "damping",
    "viscosity": "viscosity",
    "friction_memory": "friction_memory",
    "traction_B": "traction",
    "tangential": "tangential",
    "tangent": "tangent",
}
"""Arrays of the same kind hold those that carry forces."""
ABSENT = dict.fromkeys(("damping", "viscosity", "tangential", "tangent"), Sparse(0, *NO_SIZES)) | {
    "traction_B": Sparse(0, *NO_FORCES)
}
"""Arrays that a state may lack."""


class Holds(NamedTuple):
    """What holds points in contact, one row each, body axes."""

    rows: IndexArray
    """(k,) the points, ascending."""
    guard: FloatArray
    """(k, 3) outward normals that tell which walls are opposite."""
    depth: FloatArray
    """(k,) how deep they are."""
    opposed: NDArray[np.bool_]
    """(k,) whose nearest wall is opposite."""

    def at(self, rows: IndexArray) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Guards (len(rows), 3), depths and opposed of these points, zero where there is none."""
        n = len(rows)
        guard, depth, opposed = np.zeros((n, 3)), np.zeros(n), np.zeros(n, np.bool_)
        if len(self.rows):
            place = np.minimum(np.searchsorted(self.rows, rows), len(self.rows) - 1)
            held = np.flatnonzero(self.rows[place] == rows)
            place = place[held]
            guard[held], depth[held] = self.guard[place], self.depth[place]
            opposed[held] = self.opposed[place]
        return guard, depth, opposed


class Guards(NamedTuple):
    """Outward normals that tell which walls are opposite for some points, body axes."""

    rows: IndexArray
    """(k,) the points, ascending."""
    normal: FloatArray
    """(k, 3) of length one."""


UNGUARDED = Guards(NO_ROWS, NOWHERE)
UNHELD = Holds(NO_ROWS, NOWHERE, NONE, np.zeros(0, np.bool_))


def holds_of(held: Column, normal: FloatArray, opposed: Guards) -> Holds:
    """Of the points `held` = (rows, depth); guards are those `opposed`, else `normal` (k, 3)."""
    rows, depth = held
    marked = np.zeros(len(rows), np.bool_)
    if len(opposed.rows):
        at, normal = np.searchsorted(rows, opposed.rows), normal.copy()
        normal[at], marked[at] = opposed.normal, True
    return Holds(rows, normal, depth, marked)


def merged(first: Guards, second: Guards) -> Guards:
    """Both, of different points."""
    if len(first.rows) == 0 or len(second.rows) == 0:
        return first if len(second.rows) == 0 else second
    rows = np.concatenate((first.rows, second.rows))
    order = np.argsort(rows)
    return Guards(rows[order], np.concatenate((first.normal, second.normal))[order])


class Loads(NamedTuple):
    """Of points in contact, one row each, body axes; see `State`."""

    held: IntArray
    """Those in contact, with the three that follow."""
    penetration: FloatArray
    normal: FloatArray
    foot: FloatArray
    rows: IntArray
    """Those of them that carry forces, with all that follows."""
    normal_force: FloatArray
    stiffness: FloatArray
    memory: FloatArray
    world: FloatArray | None
    """(k, 3) forces, world axes; None where they are those of other points."""
    damping: FloatArray | None = None
    """None, with the next, where nothing is damped."""
    viscosity: FloatArray | None = None
    friction_memory: FloatArray | None = None
    """None, with the two that follow, without friction."""
    traction: FloatArray | None = None
    tangential: FloatArray | None = None
    opposed: Guards = UNGUARDED
    """Those in contact whose nearest wall is opposite."""
    tangent: FloatArray | None = None
    """None where the law gives none."""

    @property
    def deep(self) -> Column:
        """How deep points are."""
        return Column(self.held, self.penetration)

    @property
    def holds(self) -> Holds:
        """What holds them: guards are the normals at the feet, where nothing else tells."""
        return holds_of(self.deep, self.normal, self.opposed)

    @property
    def carried(self) -> tuple[Column, Column, Column, Column]:
        """Normal forces, normals, friction and damping, whose work the next step counts."""
        damping, traction = self.damping, self.traction
        return (
            Column(self.rows, self.normal_force),
            Column(self.held, self.normal),
            NO_FORCES if traction is None else Column(self.rows, traction),
            NO_SIZES if damping is None else Column(self.rows, damping),
        )

    def column(self, name: str, p_B: FloatArray) -> Sparse | None:
        """Return what is kept of the array `name` of a state of n points, p_B (n, 3); None where it
        is kept whole. An array that says that there is no such thing has no rows."""
        n = len(p_B)
        if name in OF_HELD:
            values = getattr(self, OF_HELD[name])
            return Sparse(n, self.held, values, p_B if name == "foot_B" else None)
        if name == "guard_B":
            return Sparse(n, *self.opposed)
        values = getattr(self, OF_CARRYING[name]) if name in OF_CARRYING else None
        if values is not None:
            return Sparse(n, self.rows, values)
        return Sparse(n, NO_ROWS, NO_MEMORY) if name == "friction_memory" else ABSENT.get(name)
