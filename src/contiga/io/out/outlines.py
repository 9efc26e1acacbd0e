"""Outlines of contact regions over time as transient PolyData in VTKHDF, for ParaView.

Written to the published VTKHDF specification, version 2. The number of lines differs from step to
step, so every step is a partition of its own, with its points, its lines and, as point data, the
region's number (``cluster``) and the contact's (``contact``).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError
from contiga.io.out.hdf5 import ReadFile, open_file, whole_file
from contiga.io.out.vtkhdf_layout import (
    CELLS,
    Growing,
    Steps,
    check_steps,
    create_growing,
    create_root,
    create_steps,
    times_of,
    truncate_steps,
)
from contiga.records import FloatArray, IntArray

_LINES = CELLS.index("Lines")
_LABELS = ("cluster", "contact")
_PARTS_OF_A_STEP = 3
"""Bytes written for a step, over those of its lines, at most."""


class Loops(NamedTuple):
    """Closed lines of one step, points[first[i]:first[i+1]] each."""

    points: FloatArray
    """(k, 3) points, world axes; the first of a line is not repeated at its end."""
    first: NDArray[np.int64]
    """(lines + 1,) index of the first point of each line."""
    cluster: IntArray
    """(lines,) number of the region in its contact."""
    contact: IntArray
    """(lines,) number of the contact."""


class OutlinesWriter:
    """Writer that appends steps to a file of outlines, which is readable after every step.

    Parameters
    ----------
    path : the file, replaced if it exists

    Raises
    ------
    OutputError
        The file cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.n_steps = 0
        self._steps = Steps(self.path)
        with whole_file(self.path) as file:
            _write_frame(create_root(file))

    @classmethod
    def reopen(cls, path: str | Path, n_steps: int) -> OutlinesWriter:
        """Continue a file after its first `n_steps` steps; later ones are dropped.

        Raises
        ------
        FileError
            The file is missing, not of this kind, or has fewer steps.
        """
        check_steps(n_steps, len(read_outlines(path).times), path)
        writer = cls.__new__(cls)
        writer.path, writer.n_steps = Path(path), n_steps
        writer._steps = Steps(writer.path)
        with writer._steps.changing() as root:
            _truncate(root, n_steps)
        return writer

    def append(self, time: float, loops: Loops) -> None:
        """Add a step; one without lines is empty."""
        n_bytes = _PARTS_OF_A_STEP * (loops.points.nbytes + loops.first.nbytes)
        with self._steps.step(self.n_steps + 1, n_bytes):
            self._append(float(time), loops)
        self.n_steps += 1

    def _append(self, time: float, loops: Loops) -> None:
        points, first = loops.points, loops.first
        steps = self._steps
        before = steps["Points"].length
        starts = {
            "PartOffsets": self.n_steps,
            "NumberOfParts": 1,
            "PointOffsets": before,
            "PointDataOffsets/cluster": before,
            "PointDataOffsets/contact": before,
            "Values": time,
        }
        for name, value in starts.items():
            steps[f"Steps/{name}"].extend([value])
        for name, value in (
            # Each step has an entry more than cells: readers add the step's number to what is
            # said here, but take 0 for a topology that never changes.
            ("CellOffsets", steps["Lines/Offsets"].length - self.n_steps),
            ("ConnectivityIdOffsets", steps["Lines/Connectivity"].length),
        ):
            row = np.zeros((1, len(CELLS)), np.int64)
            row[0, _LINES] = value
            steps[f"Steps/{name}"].extend(row)
        steps["Points"].extend(points)
        for name in _LABELS:
            labels = np.repeat(getattr(loops, name), np.diff(first))
            steps[f"PointData/{name}"].extend(labels)
        steps["NumberOfPoints"].extend([len(points)])
        _append_cells(steps, first)

    def close(self) -> None:
        """Close the file."""
        self._steps.close()


def _append_cells(steps: Steps, first: NDArray[np.int64]) -> None:
    """Append a step's cells: closed lines points[first[i]:first[i + 1]], and no other kinds."""
    count = len(first) - 1
    for name in CELLS:
        is_lines = name == "Lines"
        steps[f"{name}/NumberOfCells"].extend([count if is_lines else 0])
        steps[f"{name}/NumberOfConnectivityIds"].extend([int(first[-1]) + count if is_lines else 0])
        steps[f"{name}/Offsets"].extend(first + np.arange(count + 1) if is_lines else [0])
    steps["Lines/Connectivity"].extend(_closed_lines(first))


class OutlineSeries:
    """A file of outlines read back. Lines are read on request."""

    def __init__(self, path: Path, times: FloatArray) -> None:
        self.path = path
        self.times = times
        self._file = ReadFile(path)
        self.held = self._file.held

    def loops(self, i: int) -> Loops:
        """Return the lines of step `i`, from 0."""
        with self._file.arrays() as array:
            counts = array("VTKHDF/NumberOfPoints")[: i + 1]
            start, stop = int(counts[:-1].sum()), int(counts.sum())
            cells = array("VTKHDF/Lines/NumberOfCells")[: i + 1]
            row = 1 + int(cells[:-1].sum()) + i
            offsets = array("VTKHDF/Lines/Offsets")[row : row + int(cells[-1]) + 1]
            first = np.asarray(offsets, np.int64) - np.arange(len(offsets))
            label = {name: array(f"VTKHDF/PointData/{name}")[start:stop] for name in _LABELS}
            return Loops(
                np.asarray(array("VTKHDF/Points")[start:stop], np.float64),
                first,
                *(np.asarray(label[name][first[:-1]], np.int32) for name in _LABELS),
            )


def read_outlines(path: str | Path) -> OutlineSeries:
    """Open a file written by `OutlinesWriter`.

    Raises
    ------
    FileError
        The file is missing or not one of outlines.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError("no such file", where=str(path))
    with open_file(path, "r") as file:
        try:
            root = file["VTKHDF"]
            times = times_of(root)
            whole = all(f"PointData/{name}" in root for name in _LABELS)
        except KeyError:
            whole = False
        if not whole:
            raise FileError("not a file of outlines of contiga", where=str(path))
    return OutlineSeries(path, times)


def _closed_lines(first: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the points of all lines in turn, each ending where it starts."""
    total = np.arange(int(first[-1]), dtype=np.int64)
    return np.insert(total, first[1:], first[:-1])


def _write_frame(root: Any) -> None:
    create_growing(root, "NumberOfPoints", (), np.int64)
    create_growing(root, "Points", (3,), np.float64)
    for name in CELLS:
        group = root.create_group(name)
        for array in ("NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"):
            create_growing(group, array, (), np.int64)
    Growing(root["Lines/Offsets"]).extend([0])  # so that no step starts at 0
    create_steps(root)
    for name in _LABELS:
        create_growing(root, f"PointData/{name}", (), np.int32)
        create_growing(root, f"Steps/PointDataOffsets/{name}", (), np.int64)


def _truncate(root: Any, n: int) -> None:
    """Drop all steps after the first `n`."""
    points = int(root["NumberOfPoints"][:n].sum())
    lengths = {"NumberOfPoints": n, "Points": points}
    lengths |= {f"PointData/{name}": points for name in _LABELS}
    for name in CELLS:
        cells = int(root[f"{name}/NumberOfCells"][:n].sum())
        ids = int(root[f"{name}/NumberOfConnectivityIds"][:n].sum())
        lengths |= {f"{name}/NumberOfCells": n, f"{name}/NumberOfConnectivityIds": n}
        lead = int(name == "Lines")
        lengths |= {f"{name}/Offsets": lead + cells + n, f"{name}/Connectivity": ids}
    for name, length in lengths.items():
        root[name].resize(length, axis=0)
    truncate_steps(root, n)
