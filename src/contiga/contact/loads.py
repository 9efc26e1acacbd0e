"""Keep arrays of a state for the points in contact only: all other rows are zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IndexArray


class Column(NamedTuple):
    """Values of some points; of others they are zero.

    >>> some = Column(np.array([1, 3]), np.array([5.0, 0.0]))
    >>> some.at(np.array([0, 1])).tolist(), some.nonzero().rows.tolist()
    ([0.0, 5.0], [1])
    """

    rows: IndexArray
    """(k,) the points, ascending."""
    values: FloatArray
    """(k, …)."""

    def at(self, rows: IndexArray) -> FloatArray:
        """Return (len(rows), …) values of other points."""
        if len(rows) == len(self.rows) and (rows is self.rows or (rows == self.rows).all()):
            return np.array(self.values)
        out = np.zeros((len(rows), *self.values.shape[1:]))
        if len(self.rows):
            place = np.minimum(np.searchsorted(self.rows, rows), len(self.rows) - 1)
            there = self.rows[place] == rows
            out[there] = self.values[place[there]]
        return out

    def add_to(self, total: FloatArray) -> None:
        """Add the values to `total` (n, …), an array over all points."""
        if len(self.rows) == len(total):  # all rows, in order: a tenth of the time
            total += self.values
        else:
            total[self.rows] += self.values

    def nonzero(self) -> Column:
        """The points whose value (k,) is not zero."""
        if np.count_nonzero(self.values) == len(self.values):  # nearly always
            return self
        rows = np.flatnonzero(self.values)
        return Column(self.rows[rows], self.values[rows])


NOWHERE = np.zeros((0, 3))
"""Velocities that are not told, and forces there are none of."""
NONE = np.zeros(0)
NO_ROWS = np.zeros(0, np.int32)
NO_SIZES, NO_FORCES = Column(NO_ROWS, NONE), Column(NO_ROWS, NOWHERE)


class Holds(NamedTuple):
    """The guards and depths of points in contact, one row each, body axes."""

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
        guard, depth = (Column(self.rows, each).at(rows) for each in (self.guard, self.depth))
        return guard, depth, np.isin(rows, self.rows[self.opposed])


class Guards(NamedTuple):
    """Outward normals that tell which walls are opposite for some points, body axes."""

    rows: IndexArray
    """(k,) the points, ascending."""
    normal: FloatArray
    """(k, 3) of length one."""


UNGUARDED = Guards(NO_ROWS, NOWHERE)


def holds_of(held: Column, normal: FloatArray, opposed: Guards) -> Holds:
    """Make the `Holds` of points `held` = (rows, depth).

    Guards are those `opposed`, else `normal` (k, 3).
    """
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


class Kept(NamedTuple):
    """Rows of the arrays of a `State` that say nothing without contact, by their names."""

    penetration: Column
    """With the two that follow, of all points in contact."""
    normal_B: Column
    foot_B: Column
    guard_B: Guards
    normal_force: Column
    """With all that follows, of those that carry forces."""
    stiffness: Column
    memory: Column
    force: Column
    """Of nodes: of all where the points that carry are others."""
    stiffness_bound: Column | None
    """None where the law gives none."""
    damping: Column | None
    """None, with the next, where nothing is damped."""
    viscosity: Column | None
    friction_memory: Column | None
    """None, with the two that follow, without friction."""
    traction_B: Column | None
    tangential: Column | None

    @property
    def springs(self) -> Column:
        """Springs that bound the slope of the normal forces."""
        bound = self.stiffness_bound
        return (self.stiffness if bound is None else bound).nonzero()

    def whole(self, name: str, p_B: FloatArray) -> FloatArray:
        """The array `name` of a state of points p_B (n, 3)."""
        column: Column | Guards | None = getattr(self, name)
        if column is None:  # there is no such thing
            shape = {"friction_memory": (len(p_B), 0), "traction_B": (0, 3)}
            return np.zeros(shape.get(name, (0,)))
        rows, values = column
        whole = p_B.copy() if name == "foot_B" else np.zeros((len(p_B), *values.shape[1:]))
        whole[rows] = values
        return whole
