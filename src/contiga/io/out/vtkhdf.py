"""Fields over time as transient PolyData in VTKHDF, which ParaView and VTK open.

Files follow the published VTKHDF specification, version 2: one partition, the triangles of all
parts as polygons and the points of clouds as vertices. The topology is stored once and every step
refers to it through the offsets under ``Steps``; only points and point data are appended, and a
step refers to an array of the step before if it is equal.

The group ``contiga``, which other readers ignore, has the names, kinds and sizes of the parts.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.display import Displayed, Facts
from contiga.errors import FileError, InputError
from contiga.extras import require
from contiga.io.out.full_disk import full_disk_errors
from contiga.io.out.hdf5 import ReadFile, open_file, whole_file
from contiga.io.out.vtkhdf_layout import (
    Part,
    Steps,
    arrays_of,
    check_steps,
    checked_part,
    create_array,
    offsets_of,
    read_parts,
    times_of,
    truncate_steps,
    write_frame,
)
from contiga.records import FloatArray

__all__ = ["FieldSeries", "FieldsWriter", "Part", "read_fields"]


class FieldsWriter:
    """Writer that appends steps to a VTKHDF file; as a context manager it closes it.

    After every step the file is complete and readable, also by ParaView during a run, and a program
    that crashes leaves all steps it had appended. The file stays open between steps: the program
    that writes it reads it by `read_fields`, or by ``h5py.File(path, locking=False)``.

    Parameters
    ----------
    path : the file, replaced if it exists
    parts : bodies and slaves in the order of the rows of the stacked points
    units : units of "Points" and of point data by name, stored beside the values

    Raises
    ------
    InputError
        A part of unknown kind, or with triangles that refer to a missing point.
    OutputError
        The file cannot be written.
    """

    def __init__(
        self, path: str | Path, parts: Sequence[Part], units: Mapping[str, str] | None = None
    ) -> None:
        self.path = Path(path)
        self._units = dict(units or {})
        self.parts = tuple(checked_part(part) for part in parts)
        self.n_points = sum(part.n_points for part in self.parts)
        self.n_cells = sum(part.n_cells for part in self.parts)
        self.n_steps = 0
        self._names: tuple[str, ...] = ()
        self._time = -np.inf
        self._last_arrays: dict[str, tuple[int, NDArray[Any]]] = {}
        self._steps = Steps(self.path)
        require("a file of fields over time", "h5py")
        with whole_file(self.path) as file:
            write_frame(file, self.parts)

    @classmethod
    def reopen(cls, path: str | Path, n_steps: int) -> FieldsWriter:
        """Return a writer that continues a file after its first `n_steps` steps.

        Later steps are removed from the file at once.

        Raises
        ------
        FileError
            The file is missing, not of this kind, or has fewer steps.
        OutputError
            It cannot be written.
        """
        series = read_fields(path)
        check_steps(n_steps, len(series.times), path)
        writer = cls.__new__(cls)
        writer.path = Path(path)
        writer._units = series.units
        writer.parts = series.parts
        writer.n_points = sum(part.n_points for part in series.parts)
        writer.n_cells = sum(part.n_cells for part in series.parts)
        writer.n_steps = n_steps
        writer._time = float(series.times[n_steps - 1]) if n_steps else -np.inf
        writer._last_arrays = {}
        writer._steps = Steps(writer.path)
        with writer._steps.changing() as root:
            for name, values, offsets in arrays_of(root):  # later steps reuse the space
                if n_steps:
                    n_rows = int(offsets[:n_steps].max()) + writer._rows(name)
                    values.resize(n_rows, axis=0)
                    continue
                del root[name]
                if name != "Points":
                    del root["Steps"][offsets_of(name)]
            truncate_steps(root, n_steps)
            if n_steps:
                for name, values, offsets in arrays_of(root):
                    start = int(offsets[n_steps - 1])
                    writer._last_arrays[name] = (start, values[start : start + writer._rows(name)])
        writer._names = tuple(writer._last_arrays)
        return writer

    def _rows(self, name: str) -> int:
        """Return the number of rows that a step has in an array."""
        return self.n_cells if name.startswith("CellData/") else self.n_points

    def append(
        self,
        time: float,
        points: ArrayLike,
        point_data: Mapping[str, ArrayLike] | None = None,
        cell_data: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Add a step; an array that is equal to the last one, bit by bit, is not written again.

        Parameters
        ----------
        time : later than the last step's
        points : (N, 3) of all parts, stacked in their order
        point_data : name to (N,) or (N, k); the same names and types at every step
        cell_data : the same of cells: the points of clouds, then the triangles, each in the order
            of the parts

        Raises
        ------
        InputError
            An array does not fit, names differ from the first step's, or time does not rise.
        OutputError
            The file cannot be written. After either error it has the steps before.
        """
        arrays = {"Points": _as_rows("points", points, self.n_points, 3)}
        for name, values in (point_data or {}).items():
            arrays[f"PointData/{name}"] = _as_rows(name, values, self.n_points, None)
        for name, values in (cell_data or {}).items():
            arrays[f"CellData/{name}"] = _as_rows(name, values, self.n_cells, None)
        last_arrays, steps, n = dict(self._last_arrays), self._steps, self.n_steps
        try:
            with steps.step(n + 1, sum(a.nbytes for a in arrays.values())):
                if n == 0:
                    for name, values in arrays.items():
                        create_array(steps.root, name, values)
                        if unit := self._units.get(name.rpartition("/")[2]):
                            steps.root[name].attrs["units"] = unit
                    self._names = tuple(name for name, _, _ in arrays_of(steps.root))
                self._check_step(float(time), arrays)
                for name, values in arrays.items():
                    steps[f"Steps/{offsets_of(name)}"].put(n, self._append_array(name, values))
                steps["Steps/Values"].put(n, float(time))
                for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets"):
                    offsets = steps[f"Steps/{name}"]
                    offsets.put(n, np.zeros((1, *offsets.columns)))
                steps["Steps/NumberOfParts"].put(n, 1)
        except BaseException:
            self._last_arrays = last_arrays  # existing data of this step are overwritten
            raise
        self.n_steps += 1
        self._time = float(time)

    def flush(self) -> None:
        """Flush the steps appended so far to the disk."""
        with full_disk_errors(self.path), self.path.open("rb") as file:
            os.fsync(file.fileno())

    def close(self) -> None:
        """Close the file, and make sure that it is on the disk."""
        self._steps.close()
        self.flush()

    def __enter__(self) -> FieldsWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_step(self, time: float, arrays: dict[str, NDArray[Any]]) -> None:
        """Refuse a time that does not rise, and other names, types or columns than before.

        The first step passes.
        """
        if self.n_steps == 0:
            return
        if not time > self._time:
            raise InputError(
                "time must rise from step to step", found=time, allowed=f"> {self._time}"
            )
        if set(self._names) != set(arrays):
            raise InputError(
                "data must have the same names at every step",
                found=sorted(set(arrays) ^ set(self._names)),
                allowed=", ".join(sorted(self._names)),
            )
        for name, values in arrays.items():
            stored = self._steps[name]
            if values.shape[1:] != stored.columns or values.dtype != stored.dtype:
                raise InputError(
                    f"{name} must have the same type and columns at every step",
                    found=f"shape {values.shape} of {values.dtype}",
                    allowed=f"{stored.columns} of {stored.dtype}",
                )

    def _append_array(self, name: str, values: NDArray[Any]) -> int:
        """Return the row at which the values of a step begin in their array.

        Those that are equal to the last ones byte by byte begin where these do. Others are written
        from the next chunk on, and kept to compare with.
        """
        if name in self._last_arrays:
            start, last = self._last_arrays[name]
            # Byte by byte: NaN is equal to itself here and 0.0 is not −0.0.
            if last.tobytes() == values.tobytes():
                return start
        # Steps start with a chunk: a chunk that also held the end of a step would be compressed
        # again, and its old space would be lost.
        stored = self._steps[name]
        start = -(-stored.length // stored.chunk) * stored.chunk
        stored.put(start, values)
        self._last_arrays[name] = (start, values.copy())
        return start


class FieldSeries(Displayed):
    """A fields file read back; arrays are read on request.

    The file is opened for each request, or once for a block ``with series.held():``. A step `i`
    may be negative, from the last one.
    """

    times: FloatArray
    """(steps,) times."""
    parts: tuple[Part, ...]
    """Bodies and slaves in the order of the stacked points."""
    names: tuple[str, ...]
    """Names of the point data."""
    cell_names: tuple[str, ...]
    """Names of the data of cells."""
    units: dict[str, str]
    """Units of "Points" and of point data by name, if the file gives them."""

    def __init__(
        self,
        path: Path,
        times: FloatArray,
        parts: tuple[Part, ...],
        units: Mapping[str, str | None],
    ) -> None:
        self.path = path
        self.names, self.cell_names = (
            tuple(name.removeprefix(kind) for name in units if name.startswith(kind))
            for kind in ("PointData/", "CellData/")
        )
        self.units = {name.rpartition("/")[2]: unit for name, unit in units.items() if unit}
        self.times = times
        self.parts = parts
        self._file = ReadFile(path)
        self.held = self._file.held
        self._starts: dict[str, NDArray[np.int64]] = {}

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.times)),
            ("parts", ", ".join(part.name for part in self.parts)),
            ("fields", ", ".join(self.names)),
        ]

    def points(self, i: int) -> FloatArray:
        """Return the points (N, 3) of all parts at step `i`, stacked.

        Raises
        ------
        InputError
            There is no such step.
        """
        return self._read(i, "Points")

    def data(self, i: int, name: str) -> NDArray[Any]:
        """Return the point data (N,) or (N, k) at step `i`.

        Raises
        ------
        InputError
            There is no such step or name.
        """
        if name not in self.names:
            raise self._unknown("point data", name, ", ".join(self.names))
        return self._read(i, f"PointData/{name}")

    def cell_data(self, i: int, name: str) -> NDArray[Any]:
        """Return cell data (C,) or (C, k) at step `i`: points of clouds, then triangles.

        Raises
        ------
        InputError
            There is no such step or name.
        """
        if name not in self.cell_names:
            raise self._unknown("data of cells", name, ", ".join(self.cell_names) or "none")
        return self._read(i, f"CellData/{name}")

    def rows(self, part: str) -> slice:
        """Return the rows of a part among the stacked points; of two of one name, the first.

        Raises
        ------
        InputError
            There is no part of that name.
        """
        start = 0
        for entry in self.parts:
            if entry.name == part:
                return slice(start, start + entry.n_points)
            start += entry.n_points
        raise self._unknown("part", part, ", ".join(entry.name for entry in self.parts))

    def _unknown(self, what: str, found: str, allowed: str) -> InputError:
        where = str(self.path)
        return InputError(f"no {what} of that name", where=where, found=found, allowed=allowed)

    def _read(self, i: int, name: str) -> NDArray[Any]:
        """Return an array of the file at step `i`; the first rows of all steps go to `_starts`."""
        if not -len(self.times) <= i < len(self.times):
            raise InputError(
                "no such step",
                where=str(self.path),
                found=i,
                allowed=f"0 to {len(self.times) - 1}",
            )
        is_cell_data = name.startswith("CellData/")
        count = sum(part.n_cells if is_cell_data else part.n_points for part in self.parts)
        with self._file.arrays() as array:
            if name not in self._starts:
                starts = array(f"VTKHDF/Steps/{offsets_of(name)}")
                self._starts[name] = starts[: len(self.times)]
            start = int(self._starts[name][i])
            values: NDArray[Any] = array(f"VTKHDF/{name}")[start : start + count]
        return values


def read_fields(path: str | Path) -> FieldSeries:
    """Return the series in a file written by `FieldsWriter`, with times, parts, names and units.

    Raises
    ------
    FileError
        The file is missing or was not written by contiga.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError("no such file", where=str(path))
    with open_file(path, "r") as file:
        try:
            root = file["VTKHDF"]
            times = times_of(root)
            units = {name: values.attrs.get("units") for name, values, _ in arrays_of(root)}
            parts = read_parts(root, file["contiga"])
        except (KeyError, ValueError) as error:
            raise FileError(
                "not a fields file of contiga",
                where=str(path),
                allowed="fields.vtkhdf of an output folder",
            ) from error
    return FieldSeries(path, times, parts, units)


def _as_rows(name: str, values: ArrayLike, count: int, columns: int | None) -> NDArray[Any]:
    """Return contiguous values (count,) or (count, k), k = `columns` if given; else refuse them.

    With `columns` = 3 they become float64; truth values become int8. A name must not be empty or
    have a "/".
    """
    array = np.asarray(values)
    if columns == 3:
        array = array.astype(np.float64)
    if array.dtype == np.bool_:
        array = array.astype(np.int8)
    is_valid = array.ndim in (1, 2) and len(array) == count
    if columns is not None:
        is_valid = is_valid and array.shape == (count, columns)
    if not is_valid or array.dtype.kind not in "iuf":
        raise InputError(
            f"{name} must have one row of numbers a point",
            found=f"shape {array.shape} of {array.dtype}",
            allowed=f"({count}, {columns})" if columns else f"({count},) or ({count}, k)",
        )
    if "/" in name or not name:
        raise InputError("a name of data must not be empty or hold '/'", found=name)
    return np.ascontiguousarray(array)
