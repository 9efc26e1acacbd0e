"""A series of mesh files as a motion."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from contiga.errors import FileError, MeshError
from contiga.io.mesh import series
from contiga.io.mesh.read_mesh import read_mesh
from contiga.io.mesh.series import MeshSeries, find_files

START = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], float)


@pytest.fixture
def files(tmp_path):
    """Twelve meshes, the k-th moved by k² along x."""
    for k in range(12):
        points = START + np.array([k**2, 0.0, 0.0])
        meshio.Mesh(points, [("triangle", np.array([[0, 1, 2]]))]).write(tmp_path / f"s_{k}.vtu")
    return find_files("s_*.vtu", tmp_path)


def test_files_are_sorted_by_their_numbers(files):
    assert [path.stem for path in files] == [f"s_{k}" for k in range(12)]


def test_natural_order_takes_every_run_of_digits(tmp_path):
    names = ["a1_2.csv", "a1_10.csv", "a2_1.csv", "a10_1.csv", "b.csv"]
    for name in reversed(names):
        (tmp_path / name).write_text("0,0,0\n")
    assert [path.name for path in find_files("*.csv", tmp_path)] == names
    assert [path.name for path in find_files(tmp_path / "a1_*.csv")] == names[:2]
    assert [path.name for path in find_files("**/a1_*.csv", tmp_path.parent)] == names[:2]


def test_each_instant_gives_its_file_exactly(files):
    motion = MeshSeries(files, 0.1 * np.arange(12))
    for k, time in enumerate(motion.times):
        assert np.array_equal(motion.points(time), read_mesh(files[k]).points)


def test_between_instants_nodes_move_on_straight_lines(files):
    motion = MeshSeries(files, times=np.arange(12) * 2.0)
    assert motion.points(5.0)[0] == pytest.approx([(4 + 9) / 2, 0, 0])
    assert motion.points(4.5)[0] == pytest.approx([4 + 0.25 * 5, 0, 0])


def test_before_the_first_and_after_the_last_nodes_rest(files):
    motion = MeshSeries(files, range(12))
    assert np.array_equal(motion.points(-1.0), motion.points(0.0))
    assert np.array_equal(motion.points(99.0), motion.points(11.0))


def test_a_series_too_large_to_keep_reads_again(files, monkeypatch):
    kept = MeshSeries(files, range(12))
    monkeypatch.setattr(series, "_MAX_CACHED_BYTES", 0)
    read = MeshSeries(files, range(12))
    for time in (0.5, 3.25, 11.0, 7.75, 0.0):
        assert np.array_equal(read.points(time), kept.points(time))
    assert len(read._frames) <= 2


def test_what_a_series_gives_may_be_written_to(files):
    motion = MeshSeries(files, range(12))
    motion.points(0.0)[:] = 7.0
    assert np.array_equal(motion.points(0.0), START)


def test_one_file_is_a_series_at_rest(files):
    assert np.array_equal(MeshSeries(files[:1], [0.0]).points(3.0), START)


def test_a_change_of_unit_scales_the_points(files):
    assert MeshSeries(files, range(12), factor=1000.0).points(1.0)[0] == pytest.approx(
        [1000.0, 0, 0]
    )


def test_bad_series_are_refused_before_they_run(files, tmp_path):
    (tmp_path / "more.csv").write_text("0,0,0\n1,1,1\n")
    with pytest.raises(MeshError, match=r"more\.csv.*found '2 nodes'.*3 as in"):
        MeshSeries([files[0], tmp_path / "more.csv"], [0.0, 1.0])
    (tmp_path / "nan.csv").write_text("0,0,0\n1,1,1\n1,nan,1\n")
    with pytest.raises(MeshError, match="first row 2"):
        MeshSeries([files[0], tmp_path / "nan.csv"], [0.0, 1.0])
    (tmp_path / "unit.csv").write_text("x [mm],y [mm],z [mm]\n0,0,0\n1,1,1\n1,2,1\n")
    with pytest.raises(MeshError, match=r"unit\.csv: a file of a series says its unit.*'mm'"):
        MeshSeries([files[0], tmp_path / "unit.csv"], [0.0, 1.0])
    with pytest.raises(FileError, match="no such file"):
        MeshSeries([files[0], tmp_path / "none.vtu"], [0.0, 1.0])
    with pytest.raises(FileError, match="no file fits"):
        find_files("none_*.vtu", tmp_path)
    with pytest.raises(MeshError, match="at least one"):
        MeshSeries([], [])
    for times in ([0.0, 1.0], np.zeros(12), np.arange(12)[::-1], np.full(12, np.nan)):
        with pytest.raises(MeshError, match="series"):
            MeshSeries(files, times=times)
