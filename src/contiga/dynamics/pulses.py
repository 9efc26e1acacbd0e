"""Pulses: bodies that move without rotation, by a velocity or an acceleration over time.

The table is integrated exactly, so that pose, velocity and acceleration agree to rounding. A pulse
is not extrapolated: outside its rows the acceleration is zero and the velocity constant. A run that
lasts longer than its pulse is refused by `check_covers`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only
from contiga.curves.tables import table_of
from contiga.dynamics.pieces import Pieces, pieces_between
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.transform import Axis, unit_axis, vector
from contiga.rigid.twist import Twist

_TIME_TOL = 1e-9
"""Tolerance of times over those of the run: conversion of units and sums of steps round them."""


@dataclass(frozen=True, init=False, eq=False)
class _Pulse:
    """A translation by piecewise polynomials, with constant velocity before and after them."""

    known_ahead: ClassVar[bool] = True
    displacements: Pieces
    _order: ClassVar[int]
    """Order of the derivative of the displacement that the table contains."""

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end so that no part of the table is lost."""
        return self.displacements.kinks(self._order)

    @property
    def rows(self) -> FloatArray:
        """Times of the rows."""
        return np.asarray(self.displacements.times, np.float64)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the rows."""
        return self.displacements.times[0], self.displacements.times[-1]

    def displacement(self, t: float) -> FloatArray:
        """Return the displacement (3,) since the first row, negative before it, world axes."""
        first, last = self.span
        if first <= t <= last:
            return self.displacements.value(t)
        end = last if t > last else first
        return self.displacements.value(end) + (t - end) * self.displacements.value(end, 1)

    def velocity(self, t: float) -> FloatArray:
        """Return the velocity (3,) at `t`, world axes; outside the rows that of the nearer end."""
        first, last = self.span
        return self.displacements.value(min(max(t, first), last), 1)

    def acceleration(self, t: float) -> FloatArray:
        """Return the acceleration (3,) at `t`, world axes; zero outside the rows.

        It is right-continuous at rows, and left-continuous at the last one.
        """
        first, last = self.span
        return self.displacements.value(t, 2) if first <= t <= last else np.zeros(3)

    def pose(self, t: float) -> FloatArray:
        """Return a translation by the displacement at `t`."""
        X = pose.identity()
        X[:3, 3] = self.displacement(t)
        return X

    def twist(self, t: float) -> Twist:
        """Return the velocity at `t`, without spin."""
        return Twist(self.velocity(t), np.zeros(3))


@dataclass(frozen=True, init=False, eq=False)
class Velocity(_Pulse):
    """Translation with the velocity of a table.

    Parameters
    ----------
    table : (n, 2) rows t, v with a `direction`, or (n, 4) rows t, vx, vy, vz; n ≥ 2, t strictly
        increasing
    direction : "x", "y", "z" or a vector of any length
    smooth : monotone cubics between the rows in place of straight lines

    Raises
    ------
    InputError
        A table of another shape; a direction that is missing, or not needed.

    Examples
    --------
    From rest to a velocity of 2 within a time of 4, and constant from there on

    >>> run_up = Velocity([[0.0, 0.0], [4.0, 2.0], [9.0, 2.0]], direction="x")
    >>> run_up.displacement(4.0).tolist(), run_up.displacement(9.0).tolist()
    ([4.0, 0.0, 0.0], [14.0, 0.0, 0.0])
    """

    _order = 1

    def __init__(
        self, table: ArrayLike, *, direction: Axis | None = None, smooth: bool = False
    ) -> None:
        rates = _vectors(table, "v", direction, smooth)
        object.__setattr__(self, "displacements", rates.integral(np.zeros(3)))


@dataclass(frozen=True, init=False, eq=False)
class Accelerated(_Pulse):
    """Translation with the acceleration of a table.

    Parameters
    ----------
    table : (n, 2) rows t, a with a `direction`, or (n, 4) rows t, ax, ay, az; n ≥ 2, t strictly
        increasing
    direction : "x", "y", "z" or a vector of any length
    velocity : (3,) at the first row's time, world axes
    smooth : monotone cubics between the rows in place of straight lines

    Raises
    ------
    InputError
        A table of another shape; a direction that is missing, or not needed; an invalid velocity.

    Examples
    --------
    A sled that stops from a velocity of 10 within a time of 4 by a triangular acceleration

    >>> stop = [[0.0, 0.0], [2.0, -5.0], [4.0, 0.0]]
    >>> sled = Accelerated(stop, direction="x", velocity=[10.0, 0.0, 0.0])
    >>> sled.velocity(4.0).tolist(), sled.displacement(4.0).tolist()
    ([0.0, 0.0, 0.0], [20.0, 0.0, 0.0])
    """

    _order = 2

    def __init__(
        self,
        table: ArrayLike,
        *,
        direction: Axis | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        smooth: bool = False,
    ) -> None:
        start = vector(velocity, "velocity")
        rates = _vectors(table, "a", direction, smooth).integral(start)
        object.__setattr__(self, "displacements", rates.integral(np.zeros(3)))


def check_covers(span: tuple[float, float] | None, start: float, end: float, where: str) -> None:
    """Refuse a pulse or a load over time that does not last from `start` to `end` of a run.

    Parameters
    ----------
    span : first and last time of its rows; None for a constant load
    start, end : times of the run
    where : key or name of the pulse

    Raises
    ------
    InputError
        The pulse begins later or stops earlier, by more than rounding.

    >>> check_covers((0.0, 100.0), 0.0, 80.0, "body[0].motion")
    """
    if span is None:
        return
    first, last = span
    tol = _TIME_TOL * (abs(start) + abs(end) + abs(end - start))
    if last < end - tol:
        raise InputError(
            f"stops at {last:.9g}, and the run needs it up to {end:.9g}",
            where=where,
            found=last,
            allowed=f"a last row at {end:.9g} or later",
            remedy=f"Add a last row [{end:.9g}, 0], or end the run at {last:.9g}",
        )
    if first > start + tol:
        raise InputError(
            f"begins at {first:.9g}, and the run needs it from {start:.9g} on",
            where=where,
            found=first,
            allowed=f"a first row at {start:.9g} or earlier",
            remedy=f"Add a first row [{start:.9g}, 0], or start the run at {first:.9g}",
        )


def _vectors(table: ArrayLike, letter: str, direction: Axis | None, smooth: bool) -> Pieces:
    """Return the vectors of a table as a function of time: linear between rows, cubic if `smooth`.

    `letter` is "v" or "a", for messages. Rows t, v are along `direction`. An `InputError` is raised
    if it is missing for these, or given for rows of vectors, or if the table has another shape.
    """
    components = tuple(f"{letter}{axis}" for axis in "xyz")
    try:
        shape = np.shape(table)
    except ValueError:  # rows of several lengths, which `table_of` reports
        shape = ()
    if direction is None:
        if shape[1:] == (2,):
            raise InputError(
                f"rows [t, {letter}] need a direction",
                where="direction",
                allowed="'x', 'y', 'z' or a vector",
                remedy=f"Give the direction, or rows [t, {', '.join(components)}]",
            )
        rows = table_of(table, ("t", *components), at_least=2)
        values = rows[:, 1:]
    else:
        if shape[1:] == (4,):
            raise InputError(
                f"rows [t, {', '.join(components)}] have their direction in them",
                where="direction",
                found=direction,
                remedy=f"Remove the direction, or give rows [t, {letter}]",
            )
        axis = unit_axis(direction, "direction")
        rows = table_of(table, ("t", letter), at_least=2)
        values = rows[:, 1:] * axis
    return pieces_between(read_only(rows[:, 0]), values, smooth=smooth)
