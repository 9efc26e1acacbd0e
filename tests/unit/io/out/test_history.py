"""History tables come back as they were written."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.dynamics.pulse_files import read_pulse
from contiga.errors import FileError, InputError, OutputError
from contiga.io.out.history import read_history, write_history


@given(st.lists(st.floats(), min_size=1, max_size=20))
def test_every_double_comes_back_bit_by_bit(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("history") / "h.csv"
    array = np.array(values)
    write_history(path, {"a": array})
    again = read_history(path)["a"]
    assert again.dtype == np.float64
    nan = np.isnan(array)
    assert np.array_equal(nan, np.isnan(again))
    assert array[~nan].tobytes() == again[~nan].tobytes()


def test_integers_stay_integers_and_whole_floats_stay_floats(tmp_path):
    path = tmp_path / "h.csv"
    columns = {
        "n": np.array([0, -3, 2**62]),
        "small": np.array([1, 2, 3], dtype=np.int8),
        "time": np.array([0.0, 1.0, 2.0]),
        "single": np.array([0.1, 0.2, 0.3], dtype=np.float32),
        "flag": np.array([True, False, True]),
        'odd, "name"': [1.5, 2.5, -0.0],
    }
    write_history(path, columns)
    again = read_history(path)
    assert list(again) == list(columns)
    for name, values in columns.items():
        assert np.array_equal(again[name], np.asarray(values))
    assert [again[n].dtype.kind for n in columns] == ["i", "i", "f", "f", "i", "f"]
    header = path.read_text().splitlines()[0]
    assert header == 'n,small,time,single,flag,"odd, ""name"""'


def test_heads_say_units_and_columns_are_called_without_them(tmp_path):
    path = tmp_path / "h.csv"
    columns = {"time": [0.0], "n": [3], "a b.ax": [1.5], "area": [2.0], "m": [0.5]}
    units = {"time": "ms", "n": "", "a b.ax": "mm/ms²", "m": "N·mm", "other": "m"}
    write_history(path, columns, units)
    header = path.read_bytes().splitlines()[0]
    assert header == b"time [ms],n,a b.ax [mm/ms^2],area,m [N*mm]", "ASCII, for spreadsheets"
    assert {name: list(values) for name, values in read_history(path).items()} == columns


def test_a_history_is_a_pulse(tmp_path):
    path = tmp_path / "h.csv"
    columns = {"time": [0.0, 1.0], "sled.ax": [0.0, 2.0], "n": [0, 1]}
    write_history(path, columns, {"time": "ms", "sled.ax": "mm/ms²"})
    pulse = read_pulse(path, units=("m", "s"), columns=["time", "sled.ax"])
    np.testing.assert_allclose(pulse, [[0.0, 0.0], [1e-3, 2000.0]], rtol=1e-14)


def test_a_table_without_rows_keeps_its_names(tmp_path):
    write_history(tmp_path / "h.csv", {"a": [], "b": np.empty(0)})
    again = read_history(tmp_path / "h.csv")
    assert {name: len(values) for name, values in again.items()} == {"a": 0, "b": 0}


@pytest.mark.parametrize(
    "columns",
    [{}, {"a": [1, 2], "b": [1]}, {"a": np.zeros((2, 3))}, {"a": ["x"]}, {"a": 1.0}],
)
def test_what_is_no_table_is_refused_and_nothing_is_written(tmp_path, columns):
    with pytest.raises(InputError):
        write_history(tmp_path / "h.csv", columns)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(OutputError):
        write_history(tmp_path / "none" / "h.csv", {"a": [1]})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "cannot be read"),
        ("", "row of names"),
        ("a,b\n1\n", "row 2.*1 entries.*2"),
        ("a,a\n1,2\n", "must differ"),
        ("a,b\n1,x\n", "column 'b'.*not a number"),
    ],
)
def test_damaged_tables_are_refused(tmp_path, text, message):
    path = tmp_path / "h.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(FileError, match=message):
        read_history(path)
