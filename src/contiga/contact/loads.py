"""What a state keeps of the points in contact: some rows, of which whole arrays can be made."""

from __future__ import annotations

from typing import Any, NamedTuple

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

    def sparse(self, p_B: FloatArray) -> dict[str, Sparse]:
        """The arrays of a state that are of n points, p_B (n, 3), by name."""
        n, rows = len(p_B), self.rows
        columns = {
            "normal_force": self.normal_force,
            "stiffness": self.stiffness,
            "memory": self.memory,
            "force": self.world,
            "damping": self.damping,
            "viscosity": self.viscosity,
            "friction_memory": self.friction_memory,
            "traction_B": self.traction,
            "tangential": self.tangential,
            "tangent": self.tangent,
        }
        return {
            "penetration": Sparse(n, self.held, self.penetration),
            "normal_B": Sparse(n, self.held, self.normal),
            "foot_B": Sparse(n, self.held, self.foot, p_B),
            "guard_B": Sparse(n, *self.opposed),
        } | {
            name: Sparse(n, rows, values) for name, values in columns.items() if values is not None
        }

    def without(self, n: int) -> dict[str, Any]:
        """The arrays of a state of n points that say that there is no such thing, by name."""
        none: dict[str, Any] = {"tangent": np.zeros(0)} if self.tangent is None else {}
        if self.damping is None:
            none |= {"damping": np.zeros(0), "viscosity": np.zeros(0)}
        if self.friction_memory is None:
            none |= {"friction_memory": np.zeros((n, 0)), "traction_B": np.zeros((0, 3))}
            none["tangential"] = np.zeros(0)
        return none
