"""Define arrays of a state with rows for the points in contact only; other rows are zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IndexArray


class Column(NamedTuple):
    """Values of some points; those of other points are zero.

    >>> some = Column(np.array([1, 3]), np.array([5.0, 0.0]))
    >>> some.at(np.array([0, 1])).tolist(), some.nonzero().rows.tolist()
    ([0.0, 5.0], [1])
    """

    rows: IndexArray
    """(k,) the points, ascending."""
    values: FloatArray
    """(k, …)."""

    def at(self, rows: IndexArray) -> FloatArray:
        """Return the values (len(rows), …) of any points, copied; zero for rows not listed."""
        if len(rows) == len(self.rows) and (rows is self.rows or (rows == self.rows).all()):
            return np.array(self.values)
        out = np.zeros((len(rows), *self.values.shape[1:]))
        if len(self.rows):
            position = np.minimum(np.searchsorted(self.rows, rows), len(self.rows) - 1)
            is_listed = self.rows[position] == rows
            out[is_listed] = self.values[position[is_listed]]
        return out

    def add_to(self, total: FloatArray) -> None:
        """Add the values to `total` (n, …), an array over all points."""
        if len(self.rows) == len(total):  # all rows, in order: a tenth of the time
            total += self.values
        else:
            total[self.rows] += self.values

    def nonzero(self) -> Column:
        """Return the points whose value (k,) is not zero; the column itself if no value is zero."""
        if np.count_nonzero(self.values) == len(self.values):  # nearly always
            return self
        rows = np.flatnonzero(self.values)
        return Column(self.rows[rows], self.values[rows])


NO_POINTS = np.zeros((0, 3))
"""No vectors: velocities that are not given, forces without points."""
NONE = np.zeros(0)
NO_ROWS = np.zeros(0, np.int32)
NO_SIZES, NO_FORCES = Column(NO_ROWS, NONE), Column(NO_ROWS, NO_POINTS)


class GuardStates(NamedTuple):
    """The guards and depths of points in contact, one row each, body axes."""

    rows: IndexArray
    """(k,) the points, ascending."""
    guard: FloatArray
    """(k, 3) outward normals by which walls are opposite or not."""
    depth: FloatArray
    """(k,) penetrations."""
    is_opposed: NDArray[np.bool_]
    """(k,) whether the nearest wall is opposite."""

    def at(self, rows: IndexArray) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Return guards (len(rows), 3), depths and `is_opposed` of points, zero if not listed."""
        guard, depth = (Column(self.rows, each).at(rows) for each in (self.guard, self.depth))
        return guard, depth, np.isin(rows, self.rows[self.is_opposed])


class Guards(NamedTuple):
    """Guards of some points, body axes: outward normals by which walls are opposite or not."""

    rows: IndexArray
    """(k,) the points, ascending."""
    normal: FloatArray
    """(k, 3) of length one."""


UNGUARDED = Guards(NO_ROWS, NO_POINTS)


def guard_states_of(depths: Column, normal: FloatArray, opposed: Guards) -> GuardStates:
    """Return the guards and depths of the points in contact, `depths` = (rows, depth).

    The guard of a point is the normal (k, 3) at its foot, or that in `opposed` for the points that
    it lists, a subset of those in `depths`.
    """
    rows, depth = depths
    is_opposed = np.zeros(len(rows), np.bool_)
    if len(opposed.rows):
        rows_opposed, normal = np.searchsorted(rows, opposed.rows), normal.copy()
        normal[rows_opposed], is_opposed[rows_opposed] = opposed.normal, True
    return GuardStates(rows, normal, depth, is_opposed)


def merged(first: Guards, second: Guards) -> Guards:
    """Return the guards of two sets without common points, ascending.

    If one is empty the other is returned itself.
    """
    if len(first.rows) == 0 or len(second.rows) == 0:
        return first if len(second.rows) == 0 else second
    rows = np.concatenate((first.rows, second.rows))
    order = np.argsort(rows)
    return Guards(rows[order], np.concatenate((first.normal, second.normal))[order])


class KeptColumns(NamedTuple):
    """Rows, for points in contact, of those arrays of a `State` that are zero without contact."""

    penetration: Column
    """Rows of all points in contact, as in the two fields that follow."""
    normal_B: Column
    foot_B: Column
    guard_B: Guards
    normal_force: Column
    """Rows of the points that carry forces, as in all fields that follow."""
    stiffness: Column
    memory: Column
    force: Column
    """Rows of nodes: all nodes if other points than nodes carry forces."""
    stiffness_bound: Column | None
    """None if the law has none."""
    damping: Column | None
    """None without damping, as the next field."""
    viscosity: Column | None
    friction_memory: Column | None
    """None without friction, as the two fields that follow."""
    traction_B: Column | None
    tangential: Column | None

    @property
    def springs(self) -> Column:
        """Springs, force/length, that bound the slopes of the normal forces."""
        bound = self.stiffness_bound
        return (self.stiffness if bound is None else bound).nonzero()

    def whole(self, name: str, p_B: FloatArray) -> FloatArray:
        """Return the array `name` of a state for all points p_B (n, 3): zero for those not listed.

        The foot of a point that is not listed is the point; columns that are None have no rows, or
        no columns.
        """
        column: Column | Guards | None = getattr(self, name)
        if column is None:
            shape = {"friction_memory": (len(p_B), 0), "traction_B": (0, 3)}
            return np.zeros(shape.get(name, (0,)))
        rows, values = column
        whole = p_B.copy() if name == "foot_B" else np.zeros((len(p_B), *values.shape[1:]))
        whole[rows] = values
        return whole
