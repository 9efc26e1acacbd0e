"""The layout of a transient PolyData file in VTKHDF.

VTKHDF specification, version 2: https://docs.vtk.org, "VTKHDF format specification", PolyData and
temporal data. One partition is written once; ``Steps`` has, for each step, the first row of its
values in the arrays, and 0 for its topology.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError, InputError, OutputError
from contiga.io.out.full_disk import full_disk
from contiga.io.out.hdf5 import close_file, open_file, set_aside
from contiga.records import FloatArray, IntArray

_VERSION = (2, 2)
CELLS = ("Vertices", "Lines", "Polygons", "Strips")
_KINDS = ("body", "slave")
_DATA = ("PointData", "CellData")
# Rows of a chunk: some hundred kB each, so that one step is a few chunks.
_CHUNK_ROWS = 16384
_STEP_CHUNK_ROWS = 256
_COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


class Part(NamedTuple):
    """One body or slave among the stacked points."""

    name: str
    kind: str
    """"body" or "slave"."""
    n_points: int
    triangles: NDArray[Any] | None
    """(m, 3) rows of the part's own points; None for a cloud."""

    @property
    def n_cells(self) -> int:
        """The number of triangles, or of the points of a cloud."""
        return self.n_points if self.triangles is None else len(self.triangles)


def checked_part(part: Part) -> Part:
    """Return the part with its triangles copied to int64 (m, 3).

    Raises
    ------
    InputError
        Its kind is unknown, or a triangle names a point it has not.
    """
    triangles = None
    if part.kind not in _KINDS:
        raise InputError(
            "a part must be a body or a slave", found=part.kind, allowed=", ".join(_KINDS)
        )
    if part.triangles is not None:
        triangles = np.array(part.triangles, dtype=np.int64).reshape(-1, 3)
        if len(triangles) and (triangles.min() < 0 or triangles.max() >= part.n_points):
            raise InputError(
                "a triangle names a point that is not there",
                where=part.name,
                allowed=f"0 to {part.n_points - 1}",
            )
    return Part(part.name, part.kind, int(part.n_points), triangles)


def write_frame(file: Any, parts: tuple[Part, ...]) -> None:
    """Write type, parts and topology into an empty file, and groups for steps that are empty."""
    root = create_root(file)
    count = sum(part.n_points for part in parts)
    root["NumberOfPoints"] = np.array([count], dtype=np.int64)
    starts = np.cumsum([0, *(part.n_points for part in parts)])
    vertices, triangles = [np.empty((0, 1), np.int64)], [np.empty((0, 3), np.int64)]
    for part, start in zip(parts, starts, strict=False):
        if part.triangles is None:
            vertices.append(start + np.arange(part.n_points, dtype=np.int64)[:, None])
        else:
            triangles.append(start + part.triangles)
    cells = {"Vertices": np.concatenate(vertices), "Polygons": np.concatenate(triangles)}
    for name in CELLS:
        group, corners = root.create_group(name), cells.get(name, np.empty((0, 1), np.int64))
        n_cells, n_corners = corners.shape
        group["NumberOfCells"] = np.array([n_cells], dtype=np.int64)
        group["NumberOfConnectivityIds"] = np.array([corners.size], dtype=np.int64)
        offsets = n_corners * np.arange(n_cells + 1, dtype=np.int64)
        for array, values in (("Offsets", offsets), ("Connectivity", corners.ravel())):
            options = _COMPRESSION if len(values) > _STEP_CHUNK_ROWS else {}
            group.create_dataset(array, data=values, **options)
    create_steps(root)
    for kind in _DATA:
        root.create_group(kind)
        root.create_group(f"Steps/{kind}Offsets")
    # the names of the parts and their numbers of points, which VTK does not store
    group = file.create_group("contiga")
    group.attrs["names"] = [part.name for part in parts]
    group.attrs["kinds"] = [part.kind for part in parts]
    group.attrs["n_points"] = np.array([part.n_points for part in parts], dtype=np.int64)
    n_triangles = [-1 if part.triangles is None else len(part.triangles) for part in parts]
    group.attrs["n_triangles"] = np.array(n_triangles, dtype=np.int64)


def create_root(file: Any) -> Any:
    """Create the group that VTK reads, with its type."""
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array(_VERSION, dtype=np.int64)
    root.attrs["Type"] = np.bytes_("PolyData")
    return root


def create_steps(root: Any) -> None:
    """Create the group of steps with the arrays that every kind of data needs, empty."""
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    for name in ("PartOffsets", "NumberOfParts", "PointOffsets"):
        create_growing(steps, name, (), np.int64)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        create_growing(steps, name, (len(CELLS),), np.int64)
    create_growing(steps, "Values", (), np.float64)


def read_parts(root: Any, group: Any) -> tuple[Part, ...]:
    """Return parts with triangles on their own points, from the topology and stored sizes."""
    triangles = root["Polygons/Connectivity"][:].reshape(-1, 3)
    parts, first_point, first_triangle = [], 0, 0
    entries = (group.attrs[key] for key in ("names", "kinds", "n_points", "n_triangles"))
    for name, kind, n_points, n_triangles in zip(*entries, strict=True):
        part_triangles: IntArray | None = None
        if n_triangles >= 0:
            rows = triangles[first_triangle : first_triangle + n_triangles] - first_point
            part_triangles = rows.astype(np.int32)
            first_triangle += int(n_triangles)
        parts.append(Part(str(name), str(kind), int(n_points), part_triangles))
        first_point += int(n_points)
    return tuple(parts)


def times_of(root: Any) -> FloatArray:
    """Return the times (k,) of the counted steps."""
    count = int(root["Steps"].attrs["NSteps"])
    return np.array(root["Steps/Values"][:count], dtype=np.float64)


def check_steps(n_steps: int, n_stored: int, path: str | Path) -> None:
    """Refuse to continue from missing steps.

    Raises
    ------
    FileError
        The file has fewer steps.
    """
    if not 0 <= n_steps <= n_stored:
        raise FileError(
            "the file has fewer steps than it is to go on from",
            where=str(path),
            found=n_steps,
            allowed=f"0 to {n_stored}",
        )


def create_growing(group: Any, name: str, columns: tuple[int, ...], dtype: Any) -> None:
    """Create an empty array that grows by few rows per step."""
    group.create_dataset(
        name, (0, *columns), dtype, maxshape=(None, *columns), chunks=(_STEP_CHUNK_ROWS, *columns)
    )


def create_array(root: Any, name: str, values: NDArray[Any]) -> None:
    """Create an array for the values of steps, and that of their first rows, unless they exist.

    Both are empty. A step's rows fill chunks of equal size, at most `_CHUNK_ROWS` rows each.
    """
    pieces = -(-len(values) // _CHUNK_ROWS)
    rows = -(-len(values) // max(pieces, 1))
    columns = values.shape[1:]
    if name not in root:
        root.create_dataset(
            name,
            (0, *columns),
            values.dtype,
            maxshape=(None, *columns),
            chunks=(max(rows, 1), *columns),
            **_COMPRESSION,
        )
    if offsets_of(name) not in root["Steps"]:
        create_growing(root["Steps"], offsets_of(name), (), np.int64)


def offsets_of(name: str) -> str:
    """Return the path, under Steps, of an array's first rows by step."""
    if name == "Points":
        return "PointOffsets"
    kind, _, array = name.partition("/")
    return f"{kind}Offsets/{array}"


def arrays_of(root: Any) -> list[tuple[str, Any, Any]]:
    """Return (name, values, step offsets) of each array: points, point data and cell data."""
    names = ["Points"] if "Points" in root else []
    names += [f"{kind}/{name}" for kind in _DATA for name in root.get(kind, ())]
    return [(name, root[name], root["Steps"][offsets_of(name)]) for name in names]


class Growing:
    """An array of an open file that grows by rows.

    It uses h5py's low-level interface and keeps its dataspaces: h5py's slices cost four times as
    much, a look-up by name as much as a write, and steps are many small arrays.

    Parameters
    ----------
    stored : the h5py dataset
    """

    def __init__(self, stored: Any) -> None:
        self._id = stored.id
        self.dtype: np.dtype[Any] = stored.dtype
        self.columns: tuple[int, ...] = stored.shape[1:]
        self.chunk: int = stored.chunks[0]
        self.length = self._complete_length = int(stored.shape[0])
        self._file_space = self._id.get_space()
        self._rows_space = self._id.get_space()
        self._rows_shape: tuple[int, ...] = ()
        self._first_column = (0,) * len(self.columns)

    def put(self, start: int, values: Any) -> None:
        """Write `values` from row `start` on; the array ends with them, cut off or made longer.

        Values are converted to its type; rows between its end and `start` become 0.
        """
        rows = np.ascontiguousarray(values, dtype=self.dtype).reshape(-1, *self.columns)
        end = start + len(rows)
        extent = (end, *self.columns)
        if end != self.length:
            self._id.set_extent(extent)
            self.length = end
        if len(rows):
            self._file_space.set_extent_simple(extent)
            self._file_space.select_hyperslab((start, *self._first_column), rows.shape)
            if rows.shape != self._rows_shape:
                self._rows_space.set_extent_simple(rows.shape)
                self._rows_shape = rows.shape
            self._id.write(self._rows_space, self._file_space, rows)

    def extend(self, values: Any) -> None:
        """Write `values` at the end."""
        self.put(self.length, values)

    def keep(self) -> None:
        """Accept the written rows as complete."""
        self._complete_length = self.length

    def drop(self) -> None:
        """Remove the rows written since the last `keep`.

        VTK expects arrays to be as long as the counted steps, and else writes beyond its memory.
        """
        self.length = self._complete_length
        self._id.set_extent((self.length, *self.columns))


class Steps:
    """A file that steps are appended to, open from the first step until it is closed.

    A step is written and flushed before it is counted, and then its count is flushed. So the file
    is complete between steps: a program that crashes leaves all steps it had appended, and others
    may read them; a reader that opens the file during a flush may have to open it again.

    Parameters
    ----------
    path : a file with the groups of VTKHDF and its steps
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: Any = None
        self._count: Any = None
        self._arrays: dict[str, Growing] = {}

    @property
    def root(self) -> Any:
        """The group of VTKHDF; the file is opened if necessary.

        Raises
        ------
        OutputError
            It cannot be opened.
        """
        return self._open()["VTKHDF"]

    def _open(self) -> Any:
        if self._file is None:
            self._file = open_file(self._path, "r+")
            from h5py import h5a

            # h5py would replace an attribute in order to change it.
            self._count = h5a.open(self._file["VTKHDF/Steps"].id, b"NSteps")
        return self._file

    def __getitem__(self, name: str) -> Growing:
        """Return an array by its name below the group of VTKHDF; it is valid until `close`."""
        array = self._arrays.get(name)
        if array is None:
            array = self._arrays[name] = Growing(self.root[name])
        return array

    @contextmanager
    def step(self, number: int, n_bytes: int) -> Iterator[None]:
        """Write a step within this block; readers see `number` steps when it has ended.

        Parameters
        ----------
        number : number of steps with this one
        n_bytes : upper bound of the size of its arrays, bytes

        Raises
        ------
        OutputError
            It cannot be written. After any error the arrays have their length of before the block.
        """
        with self._hdf5_errors():
            set_aside(self._open(), n_bytes, self._path)
            try:
                yield
                self._file.flush()
                # The count is written last, after all counted data: readers never see an incomplete
                # step.
                self._count.write(np.array(number, np.int64))
                self._file.flush()
            except BaseException:
                with suppress(OSError, RuntimeError):  # the first error is reported
                    for array in self._arrays.values():
                        array.drop()
                raise
        for array in self._arrays.values():
            array.keep()

    @contextmanager
    def changing(self) -> Iterator[Any]:
        """Provide the group of VTKHDF for changes that add nothing; then close the file.

        Raises
        ------
        OutputError
            They cannot be written.
        """
        try:
            with self._hdf5_errors():
                root = self.root
                set_aside(self._file, 0, self._path)
                yield root
        finally:
            self.close()

    def close(self) -> None:
        """Close the file; it is opened again for further writing.

        Raises
        ------
        OutputError
            The last data cannot be written.
        """
        file, self._file, self._count = self._file, None, None
        self._arrays.clear()
        if file is not None:
            with self._hdf5_errors():
                close_file(file, self._path)

    @contextmanager
    def _hdf5_errors(self) -> Iterator[None]:
        """Turn errors of HDF5, or of a full disk, into an `OutputError` about the file."""
        try:
            yield
        except (OSError, RuntimeError) as error:
            message = f"cannot be written as HDF5: {error}"
            full = full_disk(error, self._path)
            raise full or OutputError(message, where=str(self._path)) from error


def truncate_steps(root: Any, n_steps: int) -> None:
    """Set the number of steps to `n_steps`, and cut all arrays under Steps to that length.

    Arrays of values are not changed.
    """
    steps = root["Steps"]
    steps.attrs["NSteps"] = np.int64(n_steps)
    names: list[str] = []
    steps.visit(names.append)
    for name in names:
        if hasattr(steps[name], "resize"):  # an array, not a group
            steps[name].resize(n_steps, axis=0)
