"""The table: in the order of the cases, the same bytes whatever order they came in."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import h5py

from contiga.studies.row import DONE, FAILED, Row
from contiga.studies.table import CSV, HDF5, table_of

ROWS = [
    Row(1, DONE, "", {"speed": -1.0, "at": [1, 2]}, {"force": 0.1 + 0.2}, 9.0),
    Row(2, FAILED, 'a "wrong", thing', {"speed": -2.0, "at": [3, 4]}, {"force": math.nan}, 1.0),
    Row(3, DONE, "", {"speed": -3, "at": "x"}, {"force": 1e-300}, 2.0),
]


def read_table(path: Path) -> dict[str, list[Any]]:
    """Columns by name, in their order."""
    with h5py.File(path) as file:
        group = file["table"]
        return {name: _list(group[name]) for name in group.attrs["columns"]}


def _list(dataset: Any) -> list[Any]:
    is_text = h5py.check_string_dtype(dataset.dtype) is not None
    return list(dataset.asstr()[()]) if is_text else dataset[()].tolist()


def test_rows_are_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    written = []
    for name, rows in (("a", ROWS), ("b", ROWS[::-1])):
        (tmp_path / name).mkdir()
        table = table_of(rows, ["speed", "at"], ["force"])
        table.write(tmp_path / name)
        assert table.columns["case"] == [1, 2, 3]
        assert table.columns["at"] == ["[1, 2]", "[3, 4]", "x"]
        written.append([(tmp_path / name / file).read_bytes() for file in (HDF5, CSV)])
    assert written[0] == written[1]


def test_the_table_comes_back_from_its_files(tmp_path: Path) -> None:
    table_of(ROWS, ["speed", "at"], ["force"]).write(tmp_path)
    back = read_table(tmp_path / HDF5)
    assert list(back) == ["case", "speed", "at", "force", "status", "message"]
    assert back["case"] == [1, 2, 3]
    assert back["force"][0] == 0.1 + 0.2
    assert math.isnan(back["force"][1])
    assert back["force"][2] == 1e-300
    assert back["message"][1] == 'a "wrong", thing'
    with (tmp_path / CSV).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["force"]) == 0.1 + 0.2
    assert rows[1]["message"] == 'a "wrong", thing'


def test_columns_say_their_units(tmp_path: Path) -> None:
    units = {"speed": "m/s", "at": "", "force": "N"}
    table_of(ROWS, ["speed", "at"], ["force"], units).write(tmp_path)
    head = (tmp_path / CSV).read_text(encoding="utf-8").splitlines()[0]
    assert head == "case,speed [m/s],at,force [N],status,message"
    assert list(read_table(tmp_path / HDF5)) == [
        "case",
        "speed",
        "at",
        "force",
        "status",
        "message",
    ]
    with h5py.File(tmp_path / HDF5) as file:
        assert file["table/force"].attrs["unit"] == "N"


def test_the_table_is_one_of_pandas() -> None:
    frame = table_of(ROWS[:1], ["speed"], ["force"], {"force": "N"}).to_pandas()
    assert frame.attrs["units"] == {"force": "N"}
    assert frame.index.name == "case"
    assert frame.loc[1, "force"] == 0.1 + 0.2


def test_a_table_without_rows_can_be_written(tmp_path: Path) -> None:
    table_of([], ["speed"], ["force"]).write(tmp_path)
    assert read_table(tmp_path / HDF5)["speed"] == []
