"""A series of mesh files as a motion: one file per instant, straight lines between."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only, real
from contiga.arrays.piecewise import piece_at
from contiga.errors import FileError, MeshError
from contiga.io.mesh.read_mesh import read_raw
from contiga.records import FloatArray
from contiga.slaves.checks import check_points

_KEPT_BYTES = 512 * 1024**2
_DIGITS = re.compile(r"(\d+)")


def natural_order(path: Path) -> tuple[tuple[int, int, str], ...]:
    """Return a sorting key that takes runs of digits as numbers: step_2 before step_10."""
    pieces = _DIGITS.split(path.name)
    # Odd pieces are the runs of digits.
    return tuple((0, int(p), p) if i % 2 else (1, 0, p) for i, p in enumerate(pieces))


def find_files(pattern: str | Path, folder: str | Path = ".") -> tuple[Path, ...]:
    """Return the files that match a pattern such as ``step_*.vtu``, in natural order.

    ``**`` stands for folders of any depth.

    Raises
    ------
    FileError
        None does, or no name can: what pathlib makes of such a pattern depends on its version.
    """
    pattern = Path(pattern)
    start = Path(pattern.anchor) if pattern.is_absolute() else Path(folder)
    relative = pattern.relative_to(pattern.anchor) if pattern.is_absolute() else pattern
    *folders, name = relative.parts or ("",)
    if not name or "**" in name or "\0" in str(relative) or any(map(_is_odd, folders)):
        raise FileError(
            "is not a file name pattern", found=str(pattern), allowed="such as step_*.vtu"
        )
    files: list[Path] = []
    with suppress(OSError):  # a name that is too long
        files = sorted((p for p in start.glob(str(relative)) if p.is_file()), key=natural_order)
    if not files:
        raise FileError("no file fits the pattern", where=str(start), found=str(pattern))
    return tuple(files)


def _is_odd(part: str) -> bool:
    return "**" in part and part != "**"


class MeshSeries:
    """Positions of the nodes over time, from one mesh file per instant.

    Between two instants each node moves on a straight line at constant speed; before the first
    and after the last it stays where that file has it.

    Parameters
    ----------
    files : mesh or cloud files with the same nodes in the same order
    times : (k,) the instants, rising
    factor : what the coordinates are multiplied by (a change of unit)

    Raises
    ------
    FileError, MeshError
        A file cannot be read, has other nodes than the first, or the times do not fit.
    """

    told = True
    """Whether it is known at any time."""

    def __init__(
        self,
        files: Sequence[str | Path],
        times: ArrayLike,
        *,
        factor: float = 1.0,
    ) -> None:
        self.files = tuple(Path(file) for file in files)
        self.factor = float(factor)
        if not self.files:
            raise MeshError("a series needs at least one file", where="series")
        self.times = _as_times(times, len(self.files))
        # All files are read now, so that a bad one stops a run before it starts.
        self._kept: dict[int, FloatArray] = {}
        first = self._read(0)
        self._kept[0] = first
        self._keep_all = first.nbytes * len(self.files) <= _KEPT_BYTES
        for i in range(1, len(self.files)):
            points = self._read(i)
            if points.shape != first.shape:
                raise MeshError(
                    "the files of a series must have the same nodes",
                    where=str(self.files[i]),
                    found=f"{len(points)} nodes",
                    allowed=f"{len(first)} as in {self.files[0]}",
                )
            if self._keep_all:
                self._kept[i] = points

    @property
    def kinks(self) -> FloatArray:
        """The instants, between which the motion is linear."""
        return self.times

    def points(self, t: float) -> FloatArray:
        """Return the positions (n, 3) at time `t`."""
        after = int(np.searchsorted(self.times, t, side="right"))
        if after == 0:
            return self._frame(0).copy()
        before = after - 1
        if after == len(self.times) or self.times[before] == t:
            return self._frame(before).copy()
        start, end = self.times[before], self.times[after]
        share = (t - start) / (end - start)
        # This form gives both ends exactly.
        mixed: FloatArray = (1.0 - share) * self._frame(before) + share * self._frame(after)
        return mixed

    def velocities(self, t: float) -> FloatArray:
        """Return the velocities (n, 3) at time `t`, from the file at `t` to the next, or 0."""
        k = piece_at(self.times, t)
        if k is None:
            return np.zeros_like(self._frame(0))
        way = self._frame(k + 1) - self._frame(k)
        return np.asarray(way / (self.times[k + 1] - self.times[k]))

    def _frame(self, index: int) -> FloatArray:
        if index not in self._kept:
            while len(self._kept) > 1:
                del self._kept[next(iter(self._kept))]
            self._kept[index] = self._read(index)
        return self._kept[index]

    def _read(self, index: int) -> FloatArray:
        mesh = read_raw(self.files[index])
        check_points(mesh.points, where=str(self.files[index]), ids=mesh.node_ids)
        if mesh.unit is not None:
            raise MeshError(
                "a file of a series says its unit",
                where=str(self.files[index]),
                found=mesh.unit,
                allowed="no unit in the file: the series has one for all",
            )
        return read_only(mesh.points * self.factor)


def _as_times(times: ArrayLike, count: int) -> FloatArray:
    array = np.asarray(real(times, "series"), dtype=np.float64)
    if array.shape != (count,):
        raise MeshError(
            "a series needs one time a file",
            where="series",
            found=array.shape,
            allowed=f"({count},)",
        )
    if not np.isfinite(array).all() or (np.diff(array) <= 0.0).any():
        raise MeshError("the times of a series must rise", where="series", found=array.tolist())
    return read_only(array)
