"""Prescribed motion: bodies and slaves that follow tables, whatever the contact does.

Outside its table a motion is held: before the first time it stands where it starts, after the
last where it ends. It is never extrapolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import FileError, InputError
from contiga.num import pose, quaternion
from contiga.num.arrays import as_points, read_only
from contiga.num.transform import Axis, unit_axis, vector
from contiga.records import FloatArray

POSE_COLUMNS = ("t", "x", "y", "z", "qw", "qx", "qy", "qz")
# What is left of a unit quaternion written with three digits.
_QUATERNION_TOLERANCE = 0.01


class BodyMotion(Protocol):
    """Where a body stands over time."""

    def pose(self, t: float) -> FloatArray:
        """X_WB at time `t`, (4, 4)."""


class SlaveMotion(Protocol):
    """Where a slave's points are over time."""

    def points(self, t: float) -> FloatArray:
        """World coordinates at time `t`, (n, 3)."""


@dataclass(frozen=True)
class Fixed:
    """A body that stays where its geometry is."""

    def pose(self, t: float) -> FloatArray:
        """The identity."""
        return pose.identity()


@dataclass(frozen=True, init=False, eq=False)
class Translate:
    """Movement along a table, linear between its rows.

    Parameters
    ----------
    table : (n, 4) rows t, dx, dy, dz; t strictly increasing
    """

    times: FloatArray
    offsets: FloatArray

    def __init__(self, table: ArrayLike) -> None:
        rows = _table(table, ("t", "dx", "dy", "dz"))
        object.__setattr__(self, "times", read_only(rows[:, 0]))
        object.__setattr__(self, "offsets", read_only(rows[:, 1:]))

    def pose(self, t: float) -> FloatArray:
        """A translation by the table's offset at `t`."""
        return pose.translation([np.interp(t, self.times, d) for d in self.offsets.T])


@dataclass(frozen=True, init=False, eq=False)
class Rotate:
    """Turning about a fixed axis along a table, the angle linear between its rows.

    Parameters
    ----------
    table : (n, 2) rows t, angle in degrees; t strictly increasing. Angles above 360 are turns.
    axis : "x", "y", "z" or a vector
    centre : (3,) a point on the axis, at rest in the world
    """

    times: FloatArray
    degrees: FloatArray
    axis: FloatArray
    centre: FloatArray

    def __init__(
        self, table: ArrayLike, axis: Axis = "z", centre: ArrayLike = (0.0, 0.0, 0.0)
    ) -> None:
        rows = _table(table, ("t", "degrees"))
        object.__setattr__(self, "times", read_only(rows[:, 0]))
        object.__setattr__(self, "degrees", read_only(rows[:, 1]))
        object.__setattr__(self, "axis", read_only(unit_axis(axis)))
        object.__setattr__(self, "centre", read_only(vector(centre, "centre")))

    def pose(self, t: float) -> FloatArray:
        """A rotation by the table's angle at `t`."""
        degrees = float(np.interp(t, self.times, self.degrees))
        return pose.rotation(self.axis, np.deg2rad(degrees), self.centre)


@dataclass(frozen=True, init=False, eq=False)
class Poses:
    """Poses at given times; between them the position is linear and the turn is slerped.

    Parameters
    ----------
    times : (n,) strictly increasing
    poses : (n, 4, 4) rigid poses X_WB
    """

    times: FloatArray
    poses: FloatArray

    def __init__(self, times: ArrayLike, poses: Sequence[ArrayLike] | FloatArray) -> None:
        checked = [pose.as_pose(X, f"poses[{i}]") for i, X in enumerate(poses)]
        own = _times(times, len(checked))
        object.__setattr__(self, "times", read_only(own))
        object.__setattr__(self, "poses", read_only(np.array(checked)))

    @classmethod
    def from_table(cls, table: ArrayLike) -> Poses:
        """Poses from rows t, x, y, z, qw, qx, qy, qz.

        Quaternions written with few digits are brought to length 1; one that is off by more than
        1 % is refused, since its columns are most likely in another order.
        """
        rows = _table(table, POSE_COLUMNS)
        turns = quaternion.as_unit(rows[:, 4:], tolerance=_QUATERNION_TOLERANCE)
        poses = [pose.from_quaternion(q, x) for x, q in zip(rows[:, 1:4], turns, strict=True)]
        return cls(rows[:, 0], poses)

    @classmethod
    def from_csv(cls, path: str | Path) -> Poses:
        """Poses from a CSV file with the header ``t,x,y,z,qw,qx,qy,qz`` (columns in any order).

        Raises
        ------
        FileError
            The file is missing or unreadable, a column is missing, a cell is not a number.
        InputError
            The table is wrong, as in `from_table`.
        """
        where = str(path)
        try:
            return cls.from_table(_read_columns(Path(path), POSE_COLUMNS))
        except FileError:
            raise
        except InputError as error:
            raise type(error)(str(error), where=where) from error

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


@dataclass(frozen=True, init=False, eq=False)
class Combine:
    """Motions applied one after the other, the first one first; all axes are the world's."""

    motions: tuple[BodyMotion, ...]

    def __init__(self, motions: Sequence[BodyMotion]) -> None:
        object.__setattr__(self, "motions", tuple(motions))

    def pose(self, t: float) -> FloatArray:
        """The product of the motions' poses."""
        return pose.compose(*(motion.pose(t) for motion in reversed(self.motions)))


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
        own = base if hasattr(base, "points") else read_only(as_points(base))
        object.__setattr__(self, "base", own)
        object.__setattr__(self, "motion", motion)

    def points(self, t: float) -> FloatArray:
        """World coordinates at `t`, (n, 3)."""
        rest = self.base if isinstance(self.base, np.ndarray) else self.base.points(t)
        return pose.apply(self.motion.pose(t), rest)


def _table(table: ArrayLike, columns: tuple[str, ...]) -> FloatArray:
    """Rows of finite numbers, one for each of `columns`, the first strictly increasing."""
    allowed = f"rows [{', '.join(columns)}], {columns[0]} strictly increasing"
    try:
        rows = np.asarray(table, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a motion table must be rows of numbers, all of the same length",
            where="table",
            allowed=allowed,
        ) from error
    if rows.ndim != 2 or rows.shape[1] != len(columns) or len(rows) == 0:
        raise InputError(
            f"a motion table must have {len(columns)} columns and at least one row",
            where="table",
            found=rows.shape,
            allowed=allowed,
        )
    if not np.isfinite(rows).all():
        row = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
        raise InputError(
            f"row {row} is not finite", where="table", found=rows[row].tolist(), allowed=allowed
        )
    _times(rows[:, 0], len(rows))
    return rows


def _times(times: ArrayLike, count: int) -> FloatArray:
    own = np.asarray(times, dtype=np.float64)
    if own.shape != (count,) or count == 0 or not np.isfinite(own).all():
        raise InputError(
            "there must be one finite time for each pose, and at least one",
            where="times",
            found=own.shape,
            allowed=f"({max(count, 1)},)",
        )
    back = np.flatnonzero(np.diff(own) <= 0.0)
    if back.size:
        row = int(back[0])
        raise InputError(
            f"the times go back or repeat at row {row + 1}",
            where="table",
            found=own[row : row + 2].tolist(),
            allowed="strictly increasing times",
        )
    return own


def _read_columns(path: Path, columns: tuple[str, ...]) -> FloatArray:
    """The named columns of a CSV file."""
    header = ",".join(columns)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(
            f"the file cannot be read ({error})", where=str(path), allowed=f"CSV, header {header}"
        ) from error
    rows = [(i, line) for i, line in enumerate(lines, start=1) if line.strip()]
    names = [name.strip() for name in rows[0][1].split(",")] if rows else []
    missing = [name for name in columns if name not in names]
    if missing:
        raise FileError(
            f"the column {missing[0]!r} is missing",
            where=f"{path}:1",
            found=",".join(names),
            allowed=f"a header with {header}",
        )
    order = [names.index(name) for name in columns]
    values = []
    for number, line in rows[1:]:
        cells = line.split(",")
        try:
            values.append([float(cells[i]) for i in order])
        except (ValueError, IndexError) as error:
            raise FileError(
                "a row does not have a number for every column",
                where=f"{path}:{number}",
                found=line,
                allowed=header,
            ) from error
    return np.array(values).reshape(-1, len(columns))
