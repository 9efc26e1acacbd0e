"""Prescribed motions: bodies and slaves that follow tables, whatever the contact forces.

A motion is not extrapolated: before the first time of its table it is at its start, after the last
at its end. Velocities are exact derivatives, right-continuous at rows of a table, left-continuous
at the last one, and zero outside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, read_only
from contiga.arrays.ordered import product
from contiga.arrays.piecewise import piece_at, rate_at
from contiga.curves.tables import as_times, table_of
from contiga.dynamics.kinks import jumps_of
from contiga.errors import FileError, InputError, UnitError
from contiga.io.sheet import read_sheet
from contiga.io.units import Quantity
from contiga.records import FloatArray
from contiga.rigid import pose, quaternion, twist
from contiga.rigid.frames import checked_pose
from contiga.rigid.transform import Axis, PoseLike, unit_axis, vector
from contiga.rigid.twist import Twist

POSE_COLUMNS = ("t", "x", "y", "z", "qw", "qx", "qy", "qz")
_POSE_KINDS: tuple[Quantity, ...] = (
    *("time", "length", "length", "length"),
    *("ratio", "ratio", "ratio", "ratio"),
)
_QUATERNION_TOL = 0.01
"""Deviation from length 1 of a quaternion in a file, which may have three digits."""


class BodyMotion(Protocol):
    """Pose of a body over time.

    A motion with kinks or jumps may have the property `kinks`: times at which automatic steps end.
    """

    def pose(self, t: float) -> PoseLike:
        """Return X_WB at time `t`: (4, 4), a scipy `Rotation`, or a pair (R, t)."""

    def twist(self, t: float) -> Twist:
        """Return the velocity of the frame's origin and the spin at time `t`, world axes."""


class SlaveMotion(Protocol):
    """Points of a slave over time; `kinks` as for a `BodyMotion`."""

    def points(self, t: float) -> FloatArray:
        """Return the points (n, 3) at time `t`, world coordinates."""

    def velocities(self, t: float) -> FloatArray:
        """Return the velocities (n, 3) at time `t`, world axes."""


def pose_at(motion: BodyMotion, t: float) -> FloatArray:
    """Return X_WB (4, 4) of a motion at time `t`; checked, since the motion may be a user's own.

    An error of `checked_pose` names the motion and the time.
    """
    return checked_pose(motion.pose(t), f"{type(motion).__name__}.pose({t:g})")


def kinks_in(motion: object) -> FloatArray:
    """Return the times (k,) at which steps end so that a motion or load is resolved.

    They are its `kinks`, unsorted; none without that property.
    """
    return np.asarray(getattr(motion, "kinks", ()), dtype=np.float64).reshape(-1)


def rows_in(motion: object) -> FloatArray:
    """Return the times (k,) of the rows of a motion's tables, between which it is smooth.

    They are its `rows`, unsorted; none without that property.
    """
    return np.asarray(getattr(motion, "rows", ()), dtype=np.float64).reshape(-1)


def is_known_ahead(motion: object) -> bool:
    """Return whether a motion says that it can be evaluated ahead of time.

    A user's own, without `known_ahead`, may come from a solver, and cannot.
    """
    return bool(getattr(motion, "known_ahead", False))


def is_still(motion: object) -> bool:
    """Return whether a motion says that it is at rest; False for one without `still`."""
    return bool(getattr(motion, "still", False))


def _rate_jumps(times: FloatArray, increments: FloatArray) -> FloatArray:
    """Return the times at which rates jump, of a motion by `increments` (n − 1, d) between rows.

    Jumps too small for a step to resolve are left out (`jumps_of`). The first and the last time are
    among them: there the motion begins and stops.
    """
    if len(times) < 2:
        return times
    return jumps_of(times, increments / np.diff(times)[:, None])


@dataclass(frozen=True)
class Fixed:
    """A body that does not move."""

    known_ahead = still = True

    def pose(self, t: float) -> FloatArray:
        """Return the identity."""
        return pose.identity()

    def twist(self, t: float) -> Twist:
        """Return a twist of zero."""
        return twist.still()


@dataclass(frozen=True)
class Stopped:
    """A body at the place that a motion gives it at one time."""

    known_ahead = True
    motion: BodyMotion
    time: float

    def pose(self, t: float) -> FloatArray:
        """Return the pose at the time of the stop."""
        return pose_at(self.motion, self.time)

    def twist(self, t: float) -> Twist:
        """Return a twist of zero."""
        return twist.still()


@dataclass(frozen=True, init=False, eq=False)
class Translate:
    """Movement along a table, linear between its rows.

    Parameters
    ----------
    table : (n, 4) rows t, dx, dy, dz; t strictly increasing
    """

    known_ahead: ClassVar[bool] = True
    times: FloatArray
    offsets: FloatArray

    def __init__(self, table: ArrayLike) -> None:
        rows = table_of(table, ("t", "dx", "dy", "dz"))
        object.__setattr__(self, "times", read_only(rows[:, 0]))
        object.__setattr__(self, "offsets", read_only(rows[:, 1:]))

    @property
    def rows(self) -> FloatArray:
        """Times of its rows."""
        return self.times

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end so that no part of the table is lost."""
        return _rate_jumps(self.times, np.diff(self.offsets, axis=0))

    def pose(self, t: float) -> FloatArray:
        """Return a translation by the table's offset at `t`."""
        return pose.translation([np.interp(t, self.times, d) for d in self.offsets.T])

    def twist(self, t: float) -> Twist:
        """Return the slope of the table at `t`, without spin."""
        return Twist(rate_at(self.times, self.offsets, t), np.zeros(3))


@dataclass(frozen=True, init=False, eq=False)
class Rotate:
    """Rotation about a fixed axis by a table, the angle linear between its rows.

    Parameters
    ----------
    table : (n, 2) rows t, angle in degrees; t strictly increasing. Angles may exceed 360.
    axis : "x", "y", "z" or a vector
    centre : (3,) a point on the axis, world coordinates
    """

    known_ahead: ClassVar[bool] = True
    times: FloatArray
    degrees: FloatArray
    axis: FloatArray
    centre: FloatArray

    def __init__(
        self, table: ArrayLike, axis: Axis = "z", centre: ArrayLike = (0.0, 0.0, 0.0)
    ) -> None:
        rows = table_of(table, ("t", "degrees"))
        object.__setattr__(self, "times", read_only(rows[:, 0]))
        object.__setattr__(self, "degrees", read_only(rows[:, 1]))
        object.__setattr__(self, "axis", read_only(unit_axis(axis)))
        object.__setattr__(self, "centre", read_only(vector(centre, "centre")))

    @property
    def rows(self) -> FloatArray:
        """Times of its rows."""
        return self.times

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end so that no part of the table is lost."""
        return _rate_jumps(self.times, np.diff(self.degrees)[:, None])

    def pose(self, t: float) -> FloatArray:
        """Return a rotation by the table's angle at `t`."""
        degrees = float(np.interp(t, self.times, self.degrees))
        return pose.rotation(self.axis, np.deg2rad(degrees), self.centre)

    def twist(self, t: float) -> Twist:
        """Return the spin about the axis, by the slope of the table at `t`."""
        spin = np.deg2rad(float(rate_at(self.times, self.degrees, t))) * self.axis
        return Twist(np.cross(spin, self.pose(t)[:3, 3] - self.centre), spin)


@dataclass(frozen=True, init=False, eq=False)
class Poses:
    """Poses at given times; between them positions are linear and rotations are slerped.

    Parameters
    ----------
    times : (n,) strictly increasing
    poses : n rigid poses X_WB: (n, 4, 4), rotations of scipy, or pairs (R, t)
    """

    known_ahead: ClassVar[bool] = True
    times: FloatArray
    poses: FloatArray

    def __init__(self, times: ArrayLike, poses: Iterable[PoseLike]) -> None:
        checked = [pose.as_pose(X, f"poses[{i}]") for i, X in enumerate(poses)]
        object.__setattr__(self, "times", read_only(as_times(times, len(checked))))
        object.__setattr__(self, "poses", read_only(np.array(checked)))

    @classmethod
    def from_table(cls, table: ArrayLike) -> Poses:
        """Make poses from rows t, x, y, z, qw, qx, qy, qz.

        Quaternions are normalised, as they may have few digits. One whose length differs from 1 by
        more than 1 % raises an error: most likely its columns are in another order.
        """
        rows = table_of(table, POSE_COLUMNS)
        rotations = quaternion.as_unit(rows[:, 4:], tolerance=_QUATERNION_TOL)
        poses = [pose.from_quaternion(q, x) for x, q in zip(rows[:, 1:4], rotations, strict=True)]
        return cls(rows[:, 0], poses)

    @classmethod
    def from_csv(cls, path: str | Path, *, units: tuple[str, str] | None = None) -> Poses:
        """Read poses from a CSV file with the header ``t,x,y,z,qw,qx,qy,qz``, in any order.

        Parameters
        ----------
        path : the CSV file
        units : length and time unit to convert to, such as ("mm", "ms"), if the header names
            units: ``t [s],x [m],…``

        Raises
        ------
        FileError
            The file is missing or unreadable, a column is missing, a cell is not a number.
        UnitError
            The header names a unit, which is not one of time or length, or `units` is missing.
        InputError
            The table is wrong, see `from_table`.
        """
        header = ",".join(POSE_COLUMNS)
        case_units = None if units is None else (units[0], "kg", units[1])
        try:
            sheet = read_sheet(Path(path), header)
            sheet.check_header(header)
            order = sheet.order(POSE_COLUMNS, (len(POSE_COLUMNS),), header)
            return cls.from_table(sheet.numbers(order, _POSE_KINDS, case_units).table)
        except (FileError, UnitError):
            raise
        except InputError as error:
            raise type(error)(str(error), where=str(path)) from error

    @property
    def rows(self) -> FloatArray:
        """Times of its rows."""
        return self.times

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end for the positions, then those for the rotations."""
        q = [pose.to_quaternion(X) for X in self.poses]
        rotations = [quaternion.rotation_vector(a, b) for a, b in pairwise(q)]
        translations = np.diff(self.poses[:, :3, 3], axis=0)
        return np.concatenate(
            [
                _rate_jumps(self.times, translations),
                _rate_jumps(self.times, np.reshape(rotations, (-1, 3))),
            ]
        )

    def pose(self, t: float) -> FloatArray:
        """Return the pose at `t`; a copy of the first or last one outside the times."""
        after = int(np.searchsorted(self.times, t, side="right"))
        if after == 0:
            return np.array(self.poses[0])
        if after == len(self.times):
            return np.array(self.poses[-1])
        t0, t1 = self.times[after - 1 : after + 1]
        share = float((t - t0) / (t1 - t0))
        return pose.interpolate(self.poses[after - 1], self.poses[after], share)

    def twist(self, t: float) -> Twist:
        """Return the constant velocity and spin of the piece that contains `t`; zero outside."""
        k = piece_at(self.times, t)
        if k is None:
            return twist.still()
        span = self.times[k + 1] - self.times[k]
        start, end = self.poses[k], self.poses[k + 1]
        rotation = quaternion.rotation_vector(pose.to_quaternion(start), pose.to_quaternion(end))
        return Twist((end[:3, 3] - start[:3, 3]) / span, rotation / span)


@dataclass(frozen=True, init=False, eq=False)
class Combine:
    """Motions applied one after the other, starting with the first; all in world axes."""

    motions: tuple[BodyMotion, ...]

    def __init__(self, motions: Sequence[BodyMotion]) -> None:
        object.__setattr__(self, "motions", tuple(motions))

    @property
    def known_ahead(self) -> bool:
        """True if all of them can be evaluated ahead of time."""
        return all(map(is_known_ahead, self.motions))

    @property
    def rows(self) -> FloatArray:
        """Times of the rows of all motions."""
        return np.concatenate([np.zeros(0), *map(rows_in, self.motions)])

    @property
    def kinks(self) -> FloatArray:
        """Kinks of all motions."""
        return np.concatenate([np.zeros(0), *map(kinks_in, self.motions)])

    def pose(self, t: float) -> FloatArray:
        """Return the product of the motions' poses, the last one leftmost."""
        return pose.compose(*(pose_at(motion, t) for motion in reversed(self.motions)))

    def twist(self, t: float) -> Twist:
        """Return the sum of the motions' twists, each moved by all later motions."""
        total, X = twist.still(), pose.identity()
        for motion in self.motions:
            carrier = pose_at(motion, t)
            total = twist.combined(motion.twist(t), carrier, total, X)
            X = pose.compose(carrier, X)
        return total


@dataclass(frozen=True, init=False, eq=False)
class Moved:
    """Slave points moved by the motion of a body.

    Parameters
    ----------
    base : (n, 3) points, or a `SlaveMotion` such as a file series, in the axes of the body
    motion : motion of the body
    """

    base: FloatArray | SlaveMotion
    motion: BodyMotion

    def __init__(self, base: ArrayLike | SlaveMotion, motion: BodyMotion) -> None:
        points = base if hasattr(base, "points") else read_only(as_points(base))
        object.__setattr__(self, "base", points)
        object.__setattr__(self, "motion", motion)

    @property
    def known_ahead(self) -> bool:
        """True if both motions can be evaluated ahead of time."""
        return is_known_ahead(self.motion) and (
            isinstance(self.base, np.ndarray) or is_known_ahead(self.base)
        )

    @property
    def rows(self) -> FloatArray:
        """Times of the rows of the body's motion."""
        return rows_in(self.motion)

    @property
    def still(self) -> bool:
        """True if neither the points nor the body move."""
        return isinstance(self.base, np.ndarray) and is_still(self.motion)

    @property
    def kinks(self) -> FloatArray:
        """Kinks of both motions."""
        return np.concatenate([kinks_in(self.base), kinks_in(self.motion)])

    def points(self, t: float) -> FloatArray:
        """Return world coordinates (n, 3) at `t`."""
        if is_still(self.motion):
            return self._base_points(t)
        return pose.apply(pose_at(self.motion, t), self._base_points(t))

    def velocities(self, t: float) -> FloatArray:
        """Return velocities (n, 3) at `t`, world axes, of the points and of the body together.

        Points that never move share one read-only array.
        """
        if is_still(self.motion):
            return self._zeros if isinstance(self.base, np.ndarray) else self.base.velocities(t)
        X_WB = pose_at(self.motion, t)
        of_body = self.motion.twist(t).at(X_WB[:3, 3], pose.apply(X_WB, self._base_points(t)))
        if isinstance(self.base, np.ndarray):
            return of_body
        return of_body + product(self.base.velocities(t), X_WB[:3, :3].T)

    @cached_property
    def _zeros(self) -> FloatArray:
        """Velocities (n, 3) of fixed points: one array, which is the same for all steps."""
        assert isinstance(self.base, np.ndarray)
        return read_only(np.zeros(self.base.shape))

    def _base_points(self, t: float) -> FloatArray:
        """Return the points (n, 3) at `t` in the axes of the body."""
        return self.base if isinstance(self.base, np.ndarray) else self.base.points(t)
