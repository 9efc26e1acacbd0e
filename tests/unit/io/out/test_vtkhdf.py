"""Fields files against VTK's own reader, and going on after a stop."""

from __future__ import annotations

import subprocess
import sys

import h5py
import numpy as np
import pytest

from contiga.errors import FileError, InputError, OutputError
from contiga.io.out.vtkhdf import FieldsWriter, Part, read_fields

PARTS = [
    Part("plate", "body", 5, np.array([[0, 1, 2], [2, 3, 4]])),
    Part("cloud", "slave", 7, None),
    Part("pad", "slave", 6, np.array([[0, 1, 2], [3, 4, 5], [1, 2, 3]], dtype=np.int32)),
]
N = 18
POLYGONS = [[0, 1, 2], [2, 3, 4], [12, 13, 14], [15, 16, 17], [13, 14, 15]]
LABELS = np.repeat(np.arange(3, dtype=np.int32), [5, 7, 6])


def step(i):
    """Points and data of step i; penetration rests from step 2 to 3."""
    rng = np.random.default_rng(i)
    data = {
        "part": LABELS,
        "contact_status": rng.integers(-1, 8, N).astype(np.int32),
        "penetration": np.full(N, float(max(i, 3) if i in (2, 3) else i)),
        "force": rng.standard_normal((N, 3)),
    }
    return rng.standard_normal((N, 3)), data


def write(path, n=6):
    writer = FieldsWriter(path, PARTS)
    for i in range(n):
        writer.append(0.25 * i, *step(i))
    writer.close()
    return path


def test_units_stand_beside_the_values_and_stay(tmp_path):
    path = tmp_path / "f.vtkhdf"
    units = {"Points": "mm", "force": "N", "part": ""}
    writer = FieldsWriter(path, PARTS, units)
    for i in range(2):
        writer.append(0.25 * i, *step(i))
    writer.close()
    with FieldsWriter.reopen(path, 1) as writer:
        writer.append(0.25, *step(1))
    assert read_fields(path).units == {"Points": "mm", "force": "N"}
    with h5py.File(path) as file:
        assert file["VTKHDF/PointData/force"].attrs["units"] == "N"
    assert_vtk_reads(path, [0, 1])


def vtk_reader(path):
    pytest.importorskip("vtk")
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader


def assert_vtk_reads(path, steps):
    """VTK finds the same times, topology, points and data at each of `steps`, in any order."""
    reader = vtk_reader(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    # VTK takes a single step for a mesh at rest.
    assert list(times or [0.0]) == [0.25 * i for i in range(len(steps))]
    for i in [*steps[::-2], *steps]:
        reader.UpdateTimeStep(0.25 * i)
        mesh = reader.GetOutputDataObject(0)
        points, data = step(i)
        assert np.array_equal(vtk_to_numpy(mesh.GetPoints().GetData()), points)
        assert vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3).tolist() == (
            POLYGONS
        )
        assert np.diff(vtk_to_numpy(mesh.GetPolys().GetOffsetsArray())).tolist() == [3] * 5
        assert vtk_to_numpy(mesh.GetVerts().GetConnectivityArray()).tolist() == list(range(5, 12))
        assert np.diff(vtk_to_numpy(mesh.GetVerts().GetOffsetsArray())).tolist() == [1] * 7
        assert mesh.GetNumberOfLines() == mesh.GetNumberOfStrips() == 0
        assert mesh.GetPointData().GetNumberOfArrays() == len(data)
        for name, values in data.items():
            actual = vtk_to_numpy(mesh.GetPointData().GetArray(name))
            assert actual.dtype == values.dtype
            assert np.array_equal(actual, values)


def assert_reads_back(path, n):
    series = read_fields(path)
    assert series.times.tolist() == [0.25 * i for i in range(n)]
    for i in range(n):
        points, data = step(i)
        assert np.array_equal(series.points(i), points)
        assert set(series.names) == set(data)
        for name, values in data.items():
            assert np.array_equal(series.data(i, name), values)
            assert series.data(i, name).dtype == values.dtype


def test_vtk_reads_every_step_as_it_was_given(tmp_path):
    assert_vtk_reads(write(tmp_path / "f.vtkhdf"), list(range(6)))


def test_fields_read_back_as_they_were_given(tmp_path):
    path = write(tmp_path / "f.vtkhdf")
    assert_reads_back(path, 6)
    series = read_fields(path)
    for part, given in zip(series.parts, PARTS, strict=True):
        assert part[:3] == given[:3]
        if given.triangles is None:
            assert part.triangles is None
        else:
            assert np.array_equal(part.triangles, given.triangles)
    assert series.rows("cloud") == slice(5, 12)
    assert np.array_equal(series.points(-1), series.points(5))


def cells(i):
    """Data of cells at step i: 7 points of the cloud, then 5 triangles; `kind` rests."""
    rng = np.random.default_rng(100 + i)
    return {"density": rng.standard_normal(12), "six": rng.standard_normal((12, 6)),
            "kind": np.arange(12.0)}  # fmt: skip


@pytest.mark.parametrize("kept", [0, 2, 4])
def test_vtk_reads_data_of_cells_and_a_reopened_file_goes_on_with_them(tmp_path, kept):
    path = tmp_path / "f.vtkhdf"
    with FieldsWriter(path, PARTS, {"density": "mJ/mm³"}) as writer:
        for i in range(4):
            writer.append(0.25 * i, *step(i), cells(i))
    with FieldsWriter.reopen(path, kept) as writer:
        for i in range(kept, 6):
            writer.append(0.25 * i, *step(i), cells(i))
    assert_vtk_reads(path, list(range(6)))
    series, reader = read_fields(path), vtk_reader(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    assert set(series.cell_names) == {"density", "six", "kind"}
    assert series.units == {"density": "mJ/mm³"}
    assert "density" not in series.names
    for i in (5, 0, 3):
        reader.UpdateTimeStep(0.25 * i)
        data = reader.GetOutput().GetCellData()
        for name, values in cells(i).items():
            np.testing.assert_array_equal(series.cell_data(i, name), values)
            np.testing.assert_array_equal(vtk_to_numpy(data.GetArray(name)), values)


def test_data_of_cells_must_fit(tmp_path):
    with FieldsWriter(tmp_path / "f.vtkhdf", PARTS) as writer:
        with pytest.raises(InputError, match=r"density must have one row.*\(12,\)"):
            writer.append(0.0, *step(0), {"density": np.zeros(18)})
        writer.append(0.0, *step(0), cells(0))
        with pytest.raises(InputError, match="same names at every step"):
            writer.append(1.0, *step(1))
    with pytest.raises(InputError, match=r"no data of cells of that name.*density"):
        read_fields(tmp_path / "f.vtkhdf").cell_data(0, "force")


def test_topology_and_resting_arrays_are_stored_once(tmp_path):
    with h5py.File(write(tmp_path / "f.vtkhdf")) as file:
        root = file["VTKHDF"]
        assert root["Polygons/Connectivity"].shape == (15,)
        assert root["Vertices/Connectivity"].shape == (7,)
        assert root["Points"].shape == (6 * N, 3)
        assert root["PointData/force"].shape == (6 * N, 3)
        assert root["PointData/part"].shape == (N,)
        assert root["PointData/penetration"].shape == (5 * N,)
        assert root["Steps/CellOffsets"].shape == (6, 4)
        assert root["Steps/ConnectivityIdOffsets"].shape == (6, 4)
        assert root["Steps"].attrs["NSteps"] == 6


@pytest.mark.parametrize("kept", [0, 1, 3, 6])
def test_a_reopened_file_goes_on_as_if_never_closed(tmp_path, kept):
    path = write(tmp_path / "f.vtkhdf")
    writer = FieldsWriter.reopen(path, kept)
    assert writer.n_steps == kept
    assert writer.parts[1].name == "cloud"
    if kept:
        assert_reads_back(path, kept)
        assert_vtk_reads(path, list(range(kept)))
    for i in range(kept, 6):
        writer.append(0.25 * i, *step(i))
    assert_reads_back(path, 6)
    assert_vtk_reads(path, list(range(6)))
    writer.close()
    with h5py.File(path) as file, h5py.File(write(tmp_path / "g.vtkhdf")) as straight:
        for name in ("Points", "PointData/part", "PointData/penetration", "PointData/force"):
            assert np.array_equal(file["VTKHDF"][name], straight["VTKHDF"][name])


def test_a_reopened_file_may_not_go_on_from_steps_it_has_not(tmp_path):
    path = write(tmp_path / "f.vtkhdf", n=2)
    for n in (3, -1):
        with pytest.raises(FileError, match="0 to 2"):
            FieldsWriter.reopen(path, n)


def test_the_file_is_readable_while_it_is_written(tmp_path):
    path = tmp_path / "f.vtkhdf"
    writer = FieldsWriter(path, PARTS)
    for i in range(3):
        writer.append(0.25 * i, *step(i))
        assert_reads_back(path, i + 1)
        assert_vtk_reads(path, list(range(i + 1)))


def test_another_program_reads_the_file_while_it_is_written(tmp_path):
    path = tmp_path / "f.vtkhdf"
    writer = FieldsWriter(path, PARTS)
    program = (
        "import h5py\n"
        f"with h5py.File({str(path)!r}) as file:\n"
        "    print(file['VTKHDF/Steps'].attrs['NSteps'], len(file['VTKHDF/Points']))\n"
    )
    for i in range(2):
        writer.append(0.25 * i, *step(i))
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        assert result.stdout.split() == [str(i + 1), str((i + 1) * N)]


def test_a_closed_writer_goes_on_where_it_is_asked_to(tmp_path):
    path = tmp_path / "f.vtkhdf"
    writer = FieldsWriter(path, PARTS)
    for i in range(3):
        writer.append(0.25 * i, *step(i))
        writer.close()
    assert_reads_back(path, 3)


def test_a_step_that_was_not_finished_is_not_seen_and_written_over(tmp_path):
    path = write(tmp_path / "f.vtkhdf", n=4)
    with h5py.File(path, "r+") as file:
        # As if the program had died before it counted the fourth step.
        file["VTKHDF/Steps"].attrs["NSteps"] = 3
    assert len(read_fields(path).times) == 3
    writer = FieldsWriter.reopen(path, 3)
    for i in range(3, 6):
        writer.append(0.25 * i, *step(i))
    assert_reads_back(path, 6)


@pytest.mark.parametrize("after", range(12))
def test_a_step_that_is_interrupted_is_written_over(tmp_path, interrupted, after):
    path = tmp_path / "f.vtkhdf"
    writer = FieldsWriter(path, PARTS)
    for i in range(2):
        writer.append(0.25 * i, *step(i))
    # Once of another step than the one that comes in its place, and once of the same.
    interrupted(after, lambda: writer.append(0.5, *step(7)))
    interrupted(after, lambda: writer.append(0.5, *step(2)))
    assert_reads_back(path, 2)
    for i in range(2, 5):
        writer.append(0.25 * i, *step(i))
    assert_reads_back(path, 5)
    interrupted(after, lambda: writer.append(1.25, *step(8)))
    writer.close()
    assert_reads_back(path, 5)
    assert_vtk_reads(path, list(range(5)))
    FieldsWriter.reopen(path, 5).append(1.25, *step(5))
    assert_reads_back(path, 6)


def test_many_points_are_chunked_and_light(tmp_path):
    path, n = tmp_path / "f.vtkhdf", 50_001
    writer = FieldsWriter(path, [Part("a", "slave", n, None)])
    rng = np.random.default_rng(0)
    moved = [rng.random((n, 3)) for _ in range(2)]
    for i, points in enumerate(moved):
        writer.append(i, points, {"force": np.zeros((n, 3))})
    series = read_fields(path)
    assert all(np.array_equal(series.points(i), points) for i, points in enumerate(moved))
    writer.close()
    assert path.stat().st_size < 1.05 * 2 * moved[0].nbytes
    with h5py.File(path) as file:
        assert file["VTKHDF/Points"].chunks[0] < n
        # Each step starts with a chunk.
        assert file["VTKHDF/Steps/PointOffsets"][1] % file["VTKHDF/Points"].chunks[0] == 0
    reader = vtk_reader(path)
    from vtkmodules.util.numpy_support import vtk_to_numpy

    for i in (1, 0):
        reader.UpdateTimeStep(i)
        actual = vtk_to_numpy(reader.GetOutputDataObject(0).GetPoints().GetData())
        assert np.array_equal(actual, moved[i])


@pytest.mark.parametrize(
    ("time", "points", "data", "message"),
    [
        (1.0, np.zeros((N, 2)), {}, "points must have one row"),
        (1.0, np.zeros((N - 1, 3)), {}, "points must have one row"),
        (1.0, np.zeros((N, 3)), {"part": np.zeros(3)}, "part must have one row"),
        (1.0, np.zeros((N, 3)), {"a": ["x"] * N}, "a must have one row"),
        (1.0, np.zeros((N, 3)), {"a/b": np.zeros(N)}, "hold '/'"),
        (1.0, np.zeros((N, 3)), {}, "same names"),
        (0.25, *step(1), "time must rise"),
        (1.0, step(1)[0], {**step(1)[1], "force": np.zeros(N)}, "force must have the same"),
        (1.0, step(1)[0], {**step(1)[1], "part": np.zeros(N)}, "part must have the same"),
    ],
)
def test_a_step_that_does_not_fit_is_refused_and_leaves_the_file(
    tmp_path, time, points, data, message
):
    path = write(tmp_path / "f.vtkhdf", n=2)
    writer = FieldsWriter.reopen(path, 2)
    with pytest.raises(InputError, match=message):
        writer.append(time, points, data)
    writer.append(0.5, *step(2))
    assert_reads_back(path, 3)


def test_parts_that_do_not_fit_are_refused(tmp_path):
    path = tmp_path / "f.vtkhdf"
    with pytest.raises(InputError, match="body or a slave"):
        FieldsWriter(path, [Part("a", "thing", 3, None)])
    with pytest.raises(InputError, match="0 to 2"):
        FieldsWriter(path, [Part("a", "body", 3, np.array([[0, 1, 3]]))])
    assert not path.exists()


def test_places_and_files_that_do_not_serve_are_refused(tmp_path):
    with pytest.raises(OutputError):
        FieldsWriter(tmp_path / "none" / "f.vtkhdf", PARTS)
    with pytest.raises(FileError, match="no such file"):
        read_fields(tmp_path / "none.vtkhdf")
    (tmp_path / "text.vtkhdf").write_text("text")
    with pytest.raises(FileError, match="HDF5"):
        read_fields(tmp_path / "text.vtkhdf")
    with h5py.File(tmp_path / "other.vtkhdf", "w") as file:
        file["x"] = 1
    with pytest.raises(FileError, match="not a fields file"):
        read_fields(tmp_path / "other.vtkhdf")
    series = read_fields(write(tmp_path / "f.vtkhdf", n=1))
    for ask in (
        lambda: series.points(1),
        lambda: series.data(0, "none"),
        lambda: series.rows("none"),
    ):
        with pytest.raises(InputError):
            ask()
