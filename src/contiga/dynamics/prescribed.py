"""Prescribed motion: bodies and slaves that follow tables, whatever the contact does.

Outside its table a motion is held: before the first time it stands where it starts, after the
last where it ends. It is never extrapolated. Velocities are exact derivatives: at a row of a table
that of the piece which begins there, at the last row that of the piece which ends there, zero
where a motion is held.
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
from contiga.rigid.frames import standing
from contiga.rigid.transform import Axis, PoseLike, unit_axis, vector
from contiga.rigid.twist import Twist

POSE_COLUMNS = ("t", "x", "y", "z", "qw", "qx", "qy", "qz")
_POSE_KINDS: tuple[Quantity, ...] = (
    *("time", "length", "length", "length"),
    *("ratio", "ratio", "ratio", "ratio"),
)
# What is left of a unit quaternion written with three digits.
_QUATERNION_TOLERANCE = 0.01


class BodyMotion(Protocol):
    """Pose of a body over time.

    A motion with kinks or jumps may have `kinks`: times at which automatic steps end.
    """

    def pose(self, t: float) -> PoseLike:
        """X_WB at time `t`: (4, 4), a scipy `Rotation`, or a pair (R, t)."""

    def twist(self, t: float) -> Twist:
        """Velocity of the frame's origin and spin at time `t`, world axes."""


class SlaveMotion(Protocol):
    """Points of a slave over time; `kinks` as for a `BodyMotion`."""

    def points(self, t: float) -> FloatArray:
        """World coordinates at time `t`, (n, 3)."""

    def velocities(self, t: float) -> FloatArray:
        """Velocities at time `t`, (n, 3), world axes."""


def pose_at(motion: BodyMotion, t: float) -> FloatArray:
    """X_WB (4, 4) of a motion at time `t`; checked, since the motion may be a user's own."""
    return standing(motion.pose(t), f"{type(motion).__name__}.pose({t:g})")


def kinks_in(motion: object) -> FloatArray:
    """Return the times (k,) at which steps end so that a motion is resolved."""
    return np.asarray(getattr(motion, "kinks", ()), dtype=np.float64).reshape(-1)


def rows_in(motion: object) -> FloatArray:
    """Return the times (k,) of the rows of a motion's tables, between which it is smooth."""
    return np.asarray(getattr(motion, "rows", ()), dtype=np.float64).reshape(-1)


def is_told(motion: object) -> bool:
    """Return whether a motion is known at any time; a user's own may come live from a solver."""
    return bool(getattr(motion, "told", False))


def is_still(motion: object) -> bool:
    """Return whether a motion is known to be at rest."""
    return bool(getattr(motion, "still", False))


def _turns(times: FloatArray, steps: FloatArray) -> FloatArray:
    """Times at which what goes evenly between rows, by `steps` (n − 1, d), goes otherwise."""
    if len(times) < 2:
        return times
    # Outside its table it is held: it begins and stops there.
    return jumps_of(times, steps / np.diff(times)[:, None])


@dataclass(frozen=True)
class Fixed:
    """A body that stays where its geometry is."""

    told = still = True

    def pose(self, t: float) -> FloatArray:
        """The identity."""
        return pose.identity()

    def twist(self, t: float) -> Twist:
        """Return a twist of zero."""
        return twist.still()


@dataclass(frozen=True)
class Stopped:
    """A body that stays where a motion has it at one time."""

    told = True
    motion: BodyMotion
    time: float

    def pose(self, t: float) -> FloatArray:
        """Return the pose, which never changes."""
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

    told: ClassVar[bool] = True
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
        """Times at which steps end, so that they take the whole table into account."""
        return _turns(self.times, np.diff(self.offsets, axis=0))

    def pose(self, t: float) -> FloatArray:
        """A translation by the table's offset at `t`."""
        return pose.translation([np.interp(t, self.times, d) for d in self.offsets.T])

    def twist(self, t: float) -> Twist:
        """The slope of the table at `t`; no spin."""
        return Twist(rate_at(self.times, self.offsets, t), np.zeros(3))


@dataclass(frozen=True, init=False, eq=False)
class Rotate:
    """Turning about a fixed axis along a table, the angle linear between its rows.

    Parameters
    ----------
    table : (n, 2) rows t, angle in degrees; t strictly increasing. Angles above 360 are turns.
    axis : "x", "y", "z" or a vector
    centre : (3,) a point on the axis, at rest in the world
    """

    told: ClassVar[bool] = True
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
        """Times at which steps end, so that they take the whole table into account."""
        return _turns(self.times, np.diff(self.degrees)[:, None])

    def pose(self, t: float) -> FloatArray:
        """A rotation by the table's angle at `t`."""
        degrees = float(np.interp(t, self.times, self.degrees))
        return pose.rotation(self.axis, np.deg2rad(degrees), self.centre)

    def twist(self, t: float) -> Twist:
        """Spin about the axis, by the slope of the table at `t`."""
        spin = np.deg2rad(float(rate_at(self.times, self.degrees, t))) * self.axis
        return Twist(np.cross(spin, self.pose(t)[:3, 3] - self.centre), spin)


@dataclass(frozen=True, init=False, eq=False)
class Poses:
    """Poses at given times; between them the position is linear and the turn is slerped.

    Parameters
    ----------
    times : (n,) strictly increasing
    poses : n rigid poses X_WB: (n, 4, 4), rotations of scipy, or pairs (R, t)
    """

    told: ClassVar[bool] = True
    times: FloatArray
    poses: FloatArray

    def __init__(self, times: ArrayLike, poses: Iterable[PoseLike]) -> None:
        checked = [pose.as_pose(X, f"poses[{i}]") for i, X in enumerate(poses)]
        object.__setattr__(self, "times", read_only(as_times(times, len(checked))))
        object.__setattr__(self, "poses", read_only(np.array(checked)))

    @classmethod
    def from_table(cls, table: ArrayLike) -> Poses:
        """Poses from rows t, x, y, z, qw, qx, qy, qz.

        Quaternions written with few digits are brought to length 1; one that is off by more than
        1 % is refused, since its columns are most likely in another order.
        """
        rows = table_of(table, POSE_COLUMNS)
        turns = quaternion.as_unit(rows[:, 4:], tolerance=_QUATERNION_TOLERANCE)
        poses = [pose.from_quaternion(q, x) for x, q in zip(rows[:, 1:4], turns, strict=True)]
        return cls(rows[:, 0], poses)

    @classmethod
    def from_csv(cls, path: str | Path, *, units: tuple[str, str] | None = None) -> Poses:
        """Poses from a CSV file with the header ``t,x,y,z,qw,qx,qy,qz`` (columns in any order).

        Parameters
        ----------
        path : the CSV file
        units : length and time unit to convert to, such as ("mm", "ms"), where the header says
            units: ``t [s],x [m],…``

        Raises
        ------
        FileError
            The file is missing or unreadable, a column is missing, a cell is not a number.
        UnitError
            The header says a unit, which is none of time or length, or there are no `units`.
        InputError
            The table is wrong, as in `from_table`.
        """
        where, header = str(path), ",".join(POSE_COLUMNS)
        case = None if units is None else (units[0], "kg", units[1])
        try:
            sheet = read_sheet(Path(path), header)
            sheet.check_header(header)
            order = sheet.order(POSE_COLUMNS, (len(POSE_COLUMNS),), header)
            return cls.from_table(sheet.numbers(order, _POSE_KINDS, case).table)
        except (FileError, UnitError):
            raise
        except InputError as error:
            raise type(error)(str(error), where=where) from error

    @property
    def rows(self) -> FloatArray:
        """Times of its rows."""
        return self.times

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps end, so that they take the whole table into account."""
        q = [pose.to_quaternion(X) for X in self.poses]
        turns = [quaternion.rotation_vector(a, b) for a, b in pairwise(q)]
        ways = np.diff(self.poses[:, :3, 3], axis=0)
        both = [_turns(self.times, steps) for steps in (ways, np.reshape(turns, (-1, 3)))]
        return np.concatenate(both)

    def pose(self, t: float) -> FloatArray:
        """The pose at `t`."""
        after = int(np.searchsorted(self.times, t, side="right"))
        if after == 0:
            return np.array(self.poses[0])
        if after == len(self.times):
            return np.array(self.poses[-1])
        t0, t1 = self.times[after - 1 : after + 1]
        part = float((t - t0) / (t1 - t0))
        return pose.interpolate(self.poses[after - 1], self.poses[after], part)

    def twist(self, t: float) -> Twist:
        """The even motion of the piece that `t` lies in."""
        k = piece_at(self.times, t)
        if k is None:
            return twist.still()
        span = self.times[k + 1] - self.times[k]
        start, end = self.poses[k], self.poses[k + 1]
        way = quaternion.rotation_vector(pose.to_quaternion(start), pose.to_quaternion(end))
        return Twist((end[:3, 3] - start[:3, 3]) / span, way / span)


@dataclass(frozen=True, init=False, eq=False)
class Combine:
    """Motions applied one after the other, the first one first; all axes are the world's."""

    motions: tuple[BodyMotion, ...]

    def __init__(self, motions: Sequence[BodyMotion]) -> None:
        object.__setattr__(self, "motions", tuple(motions))

    @property
    def told(self) -> bool:
        """True if all of them are known at any time."""
        return all(map(is_told, self.motions))

    @property
    def rows(self) -> FloatArray:
        """Times of the rows of all parts."""
        return np.concatenate([np.zeros(0), *map(rows_in, self.motions)])

    @property
    def kinks(self) -> FloatArray:
        """Kinks of all parts."""
        return np.concatenate([np.zeros(0), *(kinks_in(motion) for motion in self.motions)])

    def pose(self, t: float) -> FloatArray:
        """The product of the motions' poses."""
        return pose.compose(*(pose_at(motion, t) for motion in reversed(self.motions)))

    def twist(self, t: float) -> Twist:
        """Twists of the motions, each carried by those after it."""
        total, X = twist.still(), pose.identity()
        for motion in self.motions:
            carrier = pose_at(motion, t)
            total = twist.combined(motion.twist(t), carrier, total, X)
            X = pose.compose(carrier, X)
        return total


@dataclass(frozen=True, init=False, eq=False)
class Moved:
    """Slave points carried by a body's motion.

    Parameters
    ----------
    base : (n, 3) points at rest, or a `SlaveMotion` (a file series) to be carried along
    motion : how they are carried
    """

    base: FloatArray | SlaveMotion
    motion: BodyMotion

    def __init__(self, base: ArrayLike | SlaveMotion, motion: BodyMotion) -> None:
        carried = base if hasattr(base, "points") else read_only(as_points(base))
        object.__setattr__(self, "base", carried)
        object.__setattr__(self, "motion", motion)

    @property
    def told(self) -> bool:
        """True if both motions are known at any time."""
        return is_told(self.motion) and (isinstance(self.base, np.ndarray) or is_told(self.base))

    @property
    def rows(self) -> FloatArray:
        """Times of the rows of the carrying motion."""
        return rows_in(self.motion)

    @property
    def still(self) -> bool:
        """True if they are at rest, and nothing carries them."""
        return isinstance(self.base, np.ndarray) and is_still(self.motion)

    @property
    def kinks(self) -> FloatArray:
        """Kinks of both motions."""
        return np.concatenate([kinks_in(self.base), kinks_in(self.motion)])

    def points(self, t: float) -> FloatArray:
        """World coordinates at `t`, (n, 3)."""
        if is_still(self.motion):
            return self._carried(t)
        return pose.apply(pose_at(self.motion, t), self._carried(t))

    def velocities(self, t: float) -> FloatArray:
        """Velocities at `t`, (n, 3), world axes: of what is carried, and of what carries it."""
        if is_still(self.motion):
            return self._still if isinstance(self.base, np.ndarray) else self.base.velocities(t)
        X_WB = pose_at(self.motion, t)
        moved = self.motion.twist(t).at(X_WB[:3, 3], pose.apply(X_WB, self._carried(t)))
        if isinstance(self.base, np.ndarray):
            return moved
        return moved + product(self.base.velocities(t), X_WB[:3, :3].T)

    @cached_property
    def _still(self) -> FloatArray:
        assert isinstance(self.base, np.ndarray)
        return read_only(np.zeros(self.base.shape))

    def _carried(self, t: float) -> FloatArray:
        return self.base if isinstance(self.base, np.ndarray) else self.base.points(t)
