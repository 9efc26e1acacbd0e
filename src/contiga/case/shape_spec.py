"""`{ kind = "deform" }` of a body: its control points over time."""

from __future__ import annotations

import zipfile
from typing import Literal

import numpy as np

from contiga.case.spec import ExistingFile, InstanceSpec, MotionSpec
from contiga.curves.tables import as_times
from contiga.dynamics.shapes import ControlPoints
from contiga.errors import CaseError, FileError
from contiga.records import FloatArray

ARRAYS = "times", "control_points"
"""Names of the arrays in a file."""


class ShapeSpec(InstanceSpec[ControlPoints], MotionSpec):
    """`{ kind = "deform", table = [[t, x, y, z, …], …] }`, or the same as a `file`.

    A row has the coordinates of all control points, in the order of `body.net.points`. A file is
    one of NumPy, .npz, with the arrays times (k,) and control_points (k, m, 3). Smooth between, in
    units of the case.
    """

    kind: Literal["deform"] = "deform"
    table: list[list[float]] | None = None
    file: ExistingFile | None = None

    @staticmethod
    def makes(table: list[list[float]] | None, file: str | None) -> ControlPoints:
        """Return the motion of a table or a file.

        Raises
        ------
        InputError
            Not one of them is given, rows have no 1 + 3 m numbers, times do not rise, or the file
            is wrong.
        """
        if (file is None) == (table is None):
            raise CaseError("must have exactly one of the keys file or table")
        if file is not None:
            return ControlPoints(*_read_arrays(file))
        lengths = sorted({len(row) for row in table or []})
        if len(lengths) != 1 or lengths[0] < 4 or lengths[0] % 3 != 1:
            raise CaseError(
                "must have rows [t, x, y, z, …] of all control points",
                where="table",
                found=f"rows of {', '.join(map(str, lengths)) or 'nothing'} numbers",
                allowed="1 + 3 m numbers a row, as body.net.points has m rows",
            )
        rows = np.array(table)
        as_times(rows[:, 0], len(rows))
        return ControlPoints(rows[:, 0], rows[:, 1:].reshape(len(rows), -1, 3))

    def describe(self) -> str:
        """Describe the table in words."""
        times, points = self.instance.times, self.instance.points
        span = f"t = {times[0]:g} to {times[-1]:g}"
        return f"shaped by {points.shape[1]} control points in {len(times)} rows, {span}"


def _read_arrays(file: str) -> tuple[FloatArray, FloatArray]:
    """Return the times and control points of a file; their shapes are not checked.

    Raises
    ------
    FileError
        It cannot be read, or an array is missing or holds no numbers.
    """
    allowed = f"a .npz of NumPy with {ARRAYS[0]} (k,) and {ARRAYS[1]} (k, m, 3)"
    try:
        with np.load(file, allow_pickle=False) as arrays:
            missing = [name for name in ARRAYS if name not in arrays]
            columns = [] if missing else [arrays[name] for name in ARRAYS]
    except (OSError, ValueError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        raise FileError("cannot be read", where=file, allowed=allowed) from error
    if missing:
        raise FileError(f"has no array {missing[0]!r}", where=file, allowed=allowed)
    for name, array in zip(ARRAYS, columns, strict=True):
        if array.dtype.kind not in "iuf":
            raise FileError(
                f"the array {name!r} must hold numbers",
                where=file,
                found=array.dtype,
                allowed=allowed,
            )
    times, points = columns
    return times, points
