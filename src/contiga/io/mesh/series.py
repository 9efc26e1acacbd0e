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

_MAX_CACHED_BYTES = 512 * 1024**2
"""Size of all frames up to which each file is read once."""
_DIGITS = re.compile(r"(\d+)")


def natural_order(path: Path) -> tuple[tuple[int, int, str], ...]:
    """Return a key to sort by file name with runs of digits as numbers: step_2 before step_10."""
    pieces = _DIGITS.split(path.name)
    # Odd pieces are the runs of digits.
    return tuple((0, int(p), p) if i % 2 else (1, 0, p) for i, p in enumerate(pieces))


def find_files(pattern: str | Path, folder: str | Path = ".") -> tuple[Path, ...]:
    """Return the files that match a pattern such as ``step_*.vtu``, in natural order.

    A relative pattern starts in `folder`; ``**`` stands for folders of any depth. The order is
    that of `natural_order`, by name without folder.

    Raises
    ------
    FileError
        No file matches, or the pattern is one whose meaning depends on the version of pathlib.
    """
    pattern = Path(pattern)
    start = Path(pattern.anchor) if pattern.is_absolute() else Path(folder)
    relative = pattern.relative_to(pattern.anchor) if pattern.is_absolute() else pattern
    *folders, name = relative.parts or ("",)
    has_bad_folder = any("**" in part and part != "**" for part in folders)
    if not name or "**" in name or "\0" in str(relative) or has_bad_folder:
        raise FileError(
            "is not a file name pattern", found=str(pattern), allowed="such as step_*.vtu"
        )
    files: list[Path] = []
    with suppress(OSError):  # a name that is too long
        files = sorted((p for p in start.glob(str(relative)) if p.is_file()), key=natural_order)
    if not files:
        raise FileError("no file fits the pattern", where=str(start), found=str(pattern))
    return tuple(files)


class MeshSeries:
    """Positions of the nodes over time, from one mesh file per instant.

    Between two instants each node moves on a straight line at constant speed; before the first
    and after the last instant it is at rest. All files are read once at the start, to check them;
    if their points take more than 512 MB in all, two are kept and others read again when needed.

    Parameters
    ----------
    files : mesh or cloud files with the same nodes in the same order
    times : (k,) the instants, rising
    factor : factor on the coordinates (a change of unit)

    Raises
    ------
    FileError, MeshError
        A file cannot be read, has another number of nodes than the first, states a unit, or has
        coordinates that are not finite; no files; times that do not rise or are not one a file.
    """

    known_ahead = True
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
        instants = np.asarray(real(times, "series"), dtype=np.float64)
        if instants.shape != (len(self.files),):
            raise MeshError(
                "a series needs one time a file",
                where="series",
                found=instants.shape,
                allowed=f"({len(self.files)},)",
            )
        if not np.isfinite(instants).all() or (np.diff(instants) <= 0.0).any():
            raise MeshError(
                "the times of a series must rise", where="series", found=instants.tolist()
            )
        self.times = read_only(instants)
        # All files are read now, so that a bad one stops a run before it starts.
        first = self._read(0)
        self._frames: dict[int, FloatArray] = {0: first}
        cache_all = first.nbytes * len(self.files) <= _MAX_CACHED_BYTES
        for i in range(1, len(self.files)):
            points = self._read(i)
            if points.shape != first.shape:
                raise MeshError(
                    "the files of a series must have the same nodes",
                    where=str(self.files[i]),
                    found=f"{len(points)} nodes",
                    allowed=f"{len(first)} as in {self.files[0]}",
                )
            if cache_all:
                self._frames[i] = points

    @property
    def kinks(self) -> FloatArray:
        """The instants, between which the motion is linear."""
        return self.times

    def points(self, t: float) -> FloatArray:
        """Return the positions (n, 3) at time `t`, a new array; outside the times, the end's."""
        after = int(np.searchsorted(self.times, t, side="right"))
        if after == 0:
            return self._frame(0).copy()
        before = after - 1
        if after == len(self.times) or self.times[before] == t:
            return self._frame(before).copy()
        start, end = self.times[before], self.times[after]
        share = (t - start) / (end - start)
        # This form gives both ends exactly.
        between: FloatArray = (1.0 - share) * self._frame(before) + share * self._frame(after)
        return between

    def velocities(self, t: float) -> FloatArray:
        """Return the velocities (n, 3) at time `t`; at an instant those of the interval after it.

        At the last instant they are those of the interval before it; outside they are 0.
        """
        k = piece_at(self.times, t)
        if k is None:
            return np.zeros_like(self._frame(0))
        displacement = self._frame(k + 1) - self._frame(k)
        return np.asarray(displacement / (self.times[k + 1] - self.times[k]))

    def _frame(self, index: int) -> FloatArray:
        """Return the points (n, 3) of a file; if it is read, only those of one other file stay."""
        if index not in self._frames:
            while len(self._frames) > 1:
                del self._frames[next(iter(self._frames))]
            self._frames[index] = self._read(index)
        return self._frames[index]

    def _read(self, index: int) -> FloatArray:
        """Return the points (n, 3) of a file times the factor, read-only.

        A unit in the file, and points that are not finite, are a `MeshError`.
        """
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
