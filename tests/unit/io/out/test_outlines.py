"""Files of outlines against VTK's own reader, and going on after a stop."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import FileError
from contiga.io.out.outlines import Loops, OutlinesWriter, read_outlines

COUNTS = [[], [4], [4, 3, 5], [], [3, 3], [6]]


def loops(i):
    """Lines of step i, as many as COUNTS says, of as many points."""
    rng = np.random.default_rng(i)
    first = np.concatenate(([0], np.cumsum(COUNTS[i]))).astype(np.int64)
    n = len(COUNTS[i])
    return Loops(
        rng.normal(size=(int(first[-1]), 3)),
        first,
        np.arange(n, dtype=np.int32)[::-1].copy(),
        np.full(n, i, np.int32),
    )


def write(path, n=6):
    writer = OutlinesWriter(path)
    for i in range(n):
        writer.append(0.5 * i, loops(i))
    return path


def assert_reads_back(path, n):
    series = read_outlines(path)
    assert series.times.tolist() == [0.5 * i for i in range(n)]
    for i in range(n):
        for one, other in zip(series.loops(i), loops(i), strict=True):
            assert np.array_equal(one, other)


def assert_vtk_reads(path, n):
    pytest.importorskip("vtk")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    for i in [*range(n)[::-2], *range(n)]:
        reader.UpdateTimeStep(0.5 * i)
        mesh, given = reader.GetOutputDataObject(0), loops(i)
        assert mesh.GetNumberOfCells() == mesh.GetNumberOfLines() == len(COUNTS[i])
        for k in range(mesh.GetNumberOfLines()):
            ids = mesh.GetCell(k).GetPointIds()
            row = list(range(given.first[k], given.first[k + 1]))
            assert [ids.GetId(j) for j in range(ids.GetNumberOfIds())] == [*row, row[0]]
        if len(given.points):
            assert np.array_equal(vtk_to_numpy(mesh.GetPoints().GetData()), given.points)
            for name in ("cluster", "contact"):
                actual = vtk_to_numpy(mesh.GetPointData().GetArray(name))
                assert np.array_equal(actual, np.repeat(getattr(given, name), COUNTS[i]))


def test_lines_that_change_are_read_back_and_by_vtk(tmp_path):
    path = write(tmp_path / "o.vtkhdf")
    assert_reads_back(path, 6)
    assert_vtk_reads(path, 6)


@pytest.mark.parametrize("kept", [0, 1, 3, 4])
def test_a_file_goes_on_after_any_step(tmp_path, kept):
    path = write(tmp_path / "o.vtkhdf", 5)
    writer = OutlinesWriter.reopen(path, kept)
    for i in range(kept, 6):
        writer.append(0.5 * i, loops(i))
    assert_reads_back(path, 6)
    assert_vtk_reads(path, 6)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_outlines(tmp_path / "none.vtkhdf")
    from contiga.io.out.vtkhdf import FieldsWriter, Part

    FieldsWriter(tmp_path / "f.vtkhdf", [Part("cloud", "slave", 2, None)])
    with pytest.raises(FileError, match="not a file of outlines"):
        read_outlines(tmp_path / "f.vtkhdf")
    with pytest.raises(FileError, match="fewer steps"):
        OutlinesWriter.reopen(write(tmp_path / "o.vtkhdf"), 7)


@pytest.mark.parametrize("after", [0, 3, 8, 10, 12, 16, 20])
def test_a_step_that_is_interrupted_is_written_over(tmp_path, interrupted, after):
    path = tmp_path / "o.vtkhdf"
    writer = OutlinesWriter(path)
    for i in range(2):
        writer.append(0.5 * i, loops(i))
    interrupted(after, lambda: writer.append(1.0, loops(4)))
    for i in range(2, 5):
        writer.append(0.5 * i, loops(i))
        writer.close()
    assert_reads_back(path, 5)
    assert_vtk_reads(path, 5)
