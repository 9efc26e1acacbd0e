"""Arrays of a state of which only some rows are kept: those rows, without the whole arrays.

A `State` shows whole arrays, and makes one of a few rows when it is asked for. What goes on from a
state asks for the rows.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from contiga.area.method import AreaInput, Areas
from contiga.arrays.ordered import product
from contiga.contact.force_records import Column
from contiga.contact.loads import Guards, Holds, Loads, holds_of
from contiga.contact.sparse import Sparse
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.rigid.frames import to_world


class StateLike(Protocol):
    """What is read of a `State`, which asks for its rows and so stands above them."""

    @property
    def contact(self) -> Any: ...
    @property
    def pose(self) -> FloatArray: ...
    @property
    def points_B(self) -> FloatArray: ...
    @property
    def stiffness(self) -> FloatArray: ...
    @property
    def tangent(self) -> FloatArray: ...
    @property
    def patch(self) -> IntArray: ...
    @property
    def guard_B(self) -> FloatArray: ...
    @property
    def penetration(self) -> FloatArray: ...
    @property
    def normal_B(self) -> FloatArray: ...


class KeptRows:
    """What is kept of a state; see `kept_of`."""

    def __init__(self, state: StateLike) -> None:
        self._state = state
        self._loads: Loads | None = vars(state).get("_loads")

    @property
    def is_made(self) -> bool:
        """Whether a start or a step of a contact has made the state, and not somebody by hand."""
        return self._loads is not None

    def column(self, name: str) -> Sparse | None:
        """What is kept of the array `name`; None where that is whole, or there is none."""
        loads = self._loads
        return None if loads is None else loads.column(name, self._state.points_B)

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of the array `name`."""
        column = self.column(name)
        shape = getattr(self._state, name).shape if column is None else column.shape
        return tuple(shape)

    def part(self, name: str, rows: IndexArray) -> FloatArray:
        """(len(rows), …) some rows of the array `name`; zeros of one that a state may lack."""
        column = self.column(name)
        if column is not None:
            return column.at(rows)
        whole: FloatArray = getattr(self._state, name)
        return whole[rows] if len(whole) else np.zeros((len(rows), *whole.shape[1:]))

    def listed(self, name: str) -> Column:
        """Rows (k,) of the array `name` (m, …), ascending, and their values; others are zero."""
        column = self.column(name)
        if column is not None:
            return Column(column.rows, column.values)
        whole = getattr(self._state, name)
        return Column(np.arange(len(whole), dtype=np.int32), whole)

    def nonzero(self, name: str) -> tuple[IndexArray, FloatArray]:
        """Rows (k,) of the array `name` (m,) that are not zero, and their values (k,)."""
        column = self.column(name)
        values = getattr(self._state, name) if column is None else column.values
        if column is not None and np.count_nonzero(values) == len(values):  # nearly always
            return column.rows, values
        rows = np.flatnonzero(values)
        return rows if column is None else column.rows[rows], values[rows]

    @property
    def centre_of_pressure(self) -> FloatArray:
        """(3,) mean of the feet, weighted by the normal forces, world axes; NaN without force."""
        rows, size = self.nonzero("normal_force")
        total = size.sum()
        if not total > 0.0:
            return np.full(3, np.nan)
        mean = product(size, self.part("foot_B", rows)) / total
        return to_world(self._state.pose, mean[None, :])[0]

    @property
    def deep(self) -> Column:
        """`penetration`, as `listed`."""
        return self.listed("penetration") if self._loads is None else self._loads.deep

    @property
    def holds(self) -> Holds:
        """What holds the points in contact."""
        if self._loads is not None:
            return self._loads.holds
        state = self._state
        rows = np.flatnonzero(state.patch >= 0).astype(np.int32)
        guards = state.guard_B[rows]
        pushed = guards.any(axis=1)
        deep = Column(rows, state.penetration[rows])
        return holds_of(deep, state.normal_B[rows], Guards(rows[pushed], guards[pushed]))

    @property
    def carried(self) -> tuple[Column, Column, Column, Column]:
        """Normal forces, normals, friction and damping, each as `listed`."""
        if self._loads is not None:
            return self._loads.carried
        names = "normal_force", "normal_B", "traction_B", "damping"
        size, normals, tractions, damping = map(self.listed, names)
        return size, normals, tractions, damping

    @property
    def area_input(self) -> AreaInput:
        """The nodes in contact, as area methods see them; looked up once."""
        arrays = vars(self._state)
        if "_area_input" not in arrays:
            arrays["_area_input"] = self._state.contact.area_input(self._state)
        seen: AreaInput = arrays["_area_input"]
        return seen

    def keep(self, seen: AreaInput, areas: Areas) -> None:
        """Take what was measured as the state was made, not to measure it again."""
        vars(self._state).update(_area_input=seen, areas=areas)

    @property
    def normal_springs(self) -> tuple[IndexArray, FloatArray]:
        """Springs that bound the slope of the normal forces, `tangent` or `stiffness`, as
        `nonzero`."""
        return self.nonzero("tangent" if self.shape("tangent")[0] else "stiffness")


kept_of = KeptRows
"""The rows that are kept of a state."""
