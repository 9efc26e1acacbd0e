"""Outlines of contact regions over time as transient PolyData in VTKHDF, for ParaView.

Written to the published VTKHDF specification, version 2. The number of lines differs from step to
step, so every step is a partition of its own, with its points, its lines and, as point data, the
region's number (``cluster``) and the contact's (``contact``).
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

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
_CELL_ARRAYS = ("NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity")
_LABELS = ("cluster", "contact")
_SIZE_FACTOR = 3
"""Upper bound of the bytes of a step, over the bytes of its lines."""


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
            root = create_root(file)
            create_growing(root, "NumberOfPoints", (), np.int64)
            create_growing(root, "Points", (3,), np.float64)
            for name in CELLS:
                group = root.create_group(name)
                for array in _CELL_ARRAYS:
                    create_growing(group, array, (), np.int64)
            Growing(root["Lines/Offsets"]).extend([0])  # so that no step starts at 0
            create_steps(root)
            for name in _LABELS:
                create_growing(root, f"PointData/{name}", (), np.int32)
                create_growing(root, f"Steps/PointDataOffsets/{name}", (), np.int64)

    @classmethod
    def reopen(cls, path: str | Path, n_steps: int) -> OutlinesWriter:
        """Return a writer that continues a file after its first `n_steps` steps.

        Later steps are removed from the file at once.

        Raises
        ------
        FileError
            The file is missing, not of this kind, or has fewer steps.
        OutputError
            It cannot be written.
        """
        check_steps(n_steps, len(read_outlines(path).times), path)
        writer = cls.__new__(cls)
        writer.path, writer.n_steps = Path(path), n_steps
        writer._steps = Steps(writer.path)
        with writer._steps.changing() as root:
            n_points = int(root["NumberOfPoints"][:n_steps].sum())
            lengths = {"NumberOfPoints": n_steps, "Points": n_points}
            lengths |= {f"PointData/{name}": n_points for name in _LABELS}
            for name in CELLS:
                counts = f"{name}/NumberOfCells", f"{name}/NumberOfConnectivityIds"
                n_cells, n_ids = (int(root[count][:n_steps].sum()) for count in counts)
                lengths |= dict.fromkeys(counts, n_steps)
                n_before = int(name == "Lines")
                lengths[f"{name}/Offsets"] = n_before + n_cells + n_steps
                lengths[f"{name}/Connectivity"] = n_ids
            for name, length in lengths.items():
                root[name].resize(length, axis=0)
            truncate_steps(root, n_steps)
        return writer

    def append(self, time: float, loops: Loops) -> None:
        """Add a step, which may have no lines; readers see all of it or nothing.

        Raises
        ------
        OutputError
            It cannot be written; the file has the steps before.
        """
        n_bytes = _SIZE_FACTOR * (loops.points.nbytes + loops.first.nbytes)
        with self._steps.step(self.n_steps + 1, n_bytes):
            points, first, steps = loops.points, loops.first, self._steps
            n_points = steps["Points"].length
            starts = {
                "PartOffsets": self.n_steps,
                "NumberOfParts": 1,
                "PointOffsets": n_points,
                "PointDataOffsets/cluster": n_points,
                "PointDataOffsets/contact": n_points,
                "Values": float(time),
            }
            for name, value in starts.items():
                steps[f"Steps/{name}"].extend([value])
            for name, value in (
                # Each step has one entry more than cells. Readers add the number of the step to
                # this offset, but take 0 for a topology that never changes.
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
            # closed lines points[first[i]:first[i + 1]] that end where they start; no other cells
            corners = np.insert(np.arange(int(first[-1]), dtype=np.int64), first[1:], first[:-1])
            for name in CELLS:
                n_lines, ids = (len(first) - 1, corners) if name == "Lines" else (0, corners[:0])
                steps[f"{name}/NumberOfCells"].extend([n_lines])
                steps[f"{name}/NumberOfConnectivityIds"].extend([len(ids)])
                steps[f"{name}/Offsets"].extend(first[: n_lines + 1] + np.arange(n_lines + 1))
            steps["Lines/Connectivity"].extend(corners)
        self.n_steps += 1

    def close(self) -> None:
        """Close the file; the next step opens it again."""
        self._steps.close()


class OutlineSeries:
    """A file of outlines read back; lines are read on request.

    The file is opened for each request, or once for a block ``with series.held():``.
    """

    def __init__(self, path: Path, times: FloatArray) -> None:
        self.path = path
        self.times = times
        self._file = ReadFile(path)
        self.held = self._file.held

    def loops(self, i: int) -> Loops:
        """Return the lines of step `i`, from 0; that there is such a step is not checked."""
        with self._file.arrays() as array:
            counts = array("VTKHDF/NumberOfPoints")[: i + 1]
            start, stop = int(counts[:-1].sum()), int(counts.sum())
            cells = array("VTKHDF/Lines/NumberOfCells")[: i + 1]
            row = 1 + int(cells[:-1].sum()) + i
            offsets = array("VTKHDF/Lines/Offsets")[row : row + int(cells[-1]) + 1]
            first = np.asarray(offsets, np.int64) - np.arange(len(offsets))
            labels = {name: array(f"VTKHDF/PointData/{name}")[start:stop] for name in _LABELS}
            return Loops(
                np.asarray(array("VTKHDF/Points")[start:stop], np.float64),
                first,
                *(np.asarray(labels[name][first[:-1]], np.int32) for name in _LABELS),
            )


def read_outlines(path: str | Path) -> OutlineSeries:
    """Return the series in a file written by `OutlinesWriter`, with the times of its steps.

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
            is_complete = all(f"PointData/{name}" in root for name in _LABELS)
        except KeyError:
            is_complete = False
        if not is_complete:
            raise FileError("not a file of outlines of contiga", where=str(path))
    return OutlineSeries(path, times)
