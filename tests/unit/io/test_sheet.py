"""One table in all the ways that programs write it, and heads that say what is no unit."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.errors import FileError, InputError, UnitError
from contiga.io.sheet import read_sheet

CASE = ("mm", "kg", "ms")
TIMES = [0.0, 0.02, 0.04]
WANTED = [[0.0, 0.0], [20.0, 0.196133], [40.0, -0.0098066500]]
"""In ms and mm/ms²: 0, 20 and −1 g at 0, 20 and 40 ms."""


def rows(mark: str, decimal: str = ".", quote: str = "") -> str:
    lines = (("0", "0"), ("0.02", "20"), ("0.04", "-1.0"))
    cells = [[quote + cell.replace(".", decimal) + quote for cell in line] for line in lines]
    return "".join(mark.join(line) + "\n" for line in cells)


def read(path: Path) -> np.ndarray:
    sheet = read_sheet(path, "t [s], a [g]")
    sheet.check_header("t [s], a [g]")
    return sheet.numbers(sheet.order(None, (2,), "two"), ("time", "acceleration"), CASE).table


@pytest.mark.parametrize(
    "data",
    [
        f"time [s],acc [g]\n{rows(',')}",
        f'"time [s]","acc [g]"\n{rows(",")}',  # R's write.csv without names of rows
        f'"time [s]","acc [g]"\n{rows(",", quote=chr(34))}',  # csv.QUOTE_ALL
        f'"time [s]", "acc [g]"\n{rows(", ")}',
        f"'time [s]','acc [g]'\n{rows(',')}",
        f'"Zeit, gemessen [s]";"acc [g]"\n{rows(";", ",")}',
        f"Zeit, gemessen [s];acc [g]\n{rows(';')}",
        f"time [s];acc [g];;\n{rows(';', ',')};;;\n",  # empty columns, an empty row
        f"time [s]\tacc [g]\n{rows(chr(9), ',')}",
        f"Zeit, gemessen [s]\tacc [g]\n{rows(chr(9))}",
        f'"time [s]" "acc [g]"\n{rows(" ")}',  # R's write.table
        f"  time [s]   acc [g]\n{rows('   ')}",
        f"time [s]\t acc (g)\n{rows(' ' + chr(9) + ' ')}",
        f"time (s),acc (m/(s²))\n0,0\n0.02,{20 * 9.80665}\n0.04,-9.80665\n",
        f'"time\n[s]","acc\n[g]"\n{rows(",")}',  # broken in a cell of a spreadsheet
        f"\n\ntime [s],acc [g]\n\n{rows(',')}\n",
        f"\ufefftime [s],acc [g]\n{rows(',')}",
        f"time [s],acc [g]\n{rows(',')}".replace("\n", "\r\n"),
        f"time [s],acc [g]\n{rows(',')}".replace("\n", "\r"),
        f"time [s],acc [g]\n{rows(',')}".encode("utf-16"),
        f"Zeit (s);Verz\xf6gerung (m/s\xb2)\n0;0\n0,02;{20 * 9.80665}\n0,04;-9.80665\n".replace(
            ".", ","
        ).encode("cp1252"),
    ],
)
def test_one_table_in_all_the_ways_that_it_is_written(tmp_path: Path, data: str | bytes) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    np.testing.assert_allclose(read(path), WANTED, rtol=1e-14)


@pytest.mark.parametrize(
    ("head", "kind", "message"),
    [
        (
            "acc [filtered]",
            UnitError,
            r"a\.csv:1: acc \[filtered\]: not a known unit of acceleration",
        ),
        ("acc (filtered)", UnitError, r"acc \(filtered\): .*found 'filtered'"),
        ("acc (CFC60)", UnitError, "found 'CFC60'"),
        ("acc [g] (raw)", UnitError, "found 'raw'"),
        ("'acc [kN]'", UnitError, "found 'kN'"),
        (
            "acc [g] raw",
            FileError,
            r"the unit of a column stands at the end .*found 'acc \[g\] raw",
        ),
        ("acc []", UnitError, "found ''"),
    ],
)
@pytest.mark.parametrize("quote", ["", '"'])
def test_heads_that_look_like_a_unit_and_have_none_are_named(
    tmp_path: Path, head: str, kind: type, message: str, quote: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{quote}time [s]{quote},{quote}{head}{quote}\n{rows(',')}")
    with pytest.raises(kind, match=message):
        read(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t;a\n0,5;1.5\n", r"a\.csv:2: decimal commas and decimal points in one table"),
        ("t;a\n0,5;1\n1;1.5\n", r"a\.csv:3: decimal commas and decimal points"),
        ("t;a\n0,5;1\n1;1.234,5\n", r"a\.csv:3: a row does not have a number"),
        ("t;a\n0;1\n1;1,234,5\n", r"a\.csv:3: a row does not have a number"),
        ('t,a\n"0,5","1"\n', r"a\.csv:2: a row does not have a number"),
        ("t,a\n0,5,1,5\n", r"a\.csv:2: a row has 4 cells.*where semicolons part the columns"),
        ('t,a\n0,"1\n1,2\n', r"a\.csv:3: a row cannot be read \(unexpected end of data"),
        ("t a\n0 1\n1\n", r"a\.csv:3: a row has 1 cells under a header of 2"),
        ("t,a\n0,1\n1,\n", r"a\.csv:3: a row does not have a number"),
        ("t,a\n0,1\n1,inf\n", r"a\.csv:3: a number is not finite"),
        ("t [s],a [g]\n0,1\n1e306,1\n", r"a\.csv:3: a number is not finite"),
        ("0;1,5\n", "the first line must name the columns; found '0;1,5'"),
        ("PK\x03\x04\0\0x,y\n", "the file is not text"),
        (b"t,a\n0,1\n\x81\x8d,1\n", r"a\.csv: the file cannot be read"),
    ],
)
def test_cells_that_are_not_clear_are_refused_with_their_line(
    tmp_path: Path, text: str | bytes, message: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=message):
        read(path)


def test_a_head_with_a_unit_and_nothing_to_convert_to_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t [s]\n0\n")
    with pytest.raises(UnitError, match=r"a\.csv:1: t \[s\]: the header says a unit, and none"):
        read_sheet(path, "t").numbers([0], ("time",), None)


def test_a_place_in_a_list_is_no_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("body.ball.motion.velocity[2],elastic[1],n [1]\n1,2,3\n")
    assert [head.unit for head in read_sheet(path, "").heads] == [None, "1", "1"]
    assert read_sheet(path, "").column("body.ball.motion.velocity[2]") == 0


NUMBERS = st.lists(st.tuples(*[st.floats(-1e300, 1e300)] * 3), min_size=1, max_size=4)


@given(
    NUMBERS,
    st.sampled_from([";", ",", "\t", " "]),
    st.sampled_from([csv.QUOTE_ALL, csv.QUOTE_MINIMAL, csv.QUOTE_NONNUMERIC]),
    st.booleans(),
)
def test_every_number_comes_back_whatever_parts_the_columns(
    tmp_path_factory, table: list[tuple[float, ...]], mark: str, quoting: int, comma: bool
) -> None:
    text = StringIO()
    writer = csv.writer(text, delimiter=mark, quoting=quoting)
    writer.writerow(["x [m]", "y one [mm]", "z (cm)"])
    shown = [[repr(value) for value in row] for row in table]
    decimals = any("." in cell for row in shown for cell in row)
    if comma and mark != "," and decimals:
        shown = [[cell.replace(".", ",") for cell in row] for row in shown]
    writer.writerows(shown)
    path = tmp_path_factory.mktemp("sheet") / "a.csv"
    path.write_text(text.getvalue(), encoding="utf-8")
    sheet = read_sheet(path, "")
    if mark == " " and quoting == csv.QUOTE_MINIMAL:
        assert [head.name for head in sheet.heads] == ["x", "y one", "z"]
    actual = sheet.numbers([0, 1, 2], ["length"] * 3, ("mm", "kg", "ms")).table
    np.testing.assert_array_equal(actual, np.array(table) * [1000.0, 1.0, 10.0])


def test_a_table_is_what_pandas_makes_of_it(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "a.csv"
    frame = pandas.DataFrame({"time [s]": TIMES, "acc [g]": [0.0, 20.5, -1.0], "note": list("äö,")})
    for how in (
        {"quoting": csv.QUOTE_NONNUMERIC},
        {"sep": ";", "decimal": ",", "encoding": "cp1252"},
        {"sep": "\t", "encoding": "utf-16"},
        {"sep": ";", "decimal": ",", "encoding": "utf-8-sig", "quoting": csv.QUOTE_ALL},
    ):
        frame.to_csv(path, index=False, **how)
        sheet = read_sheet(path, "")
        order = [sheet.column("time"), sheet.column("acc")]
        actual = sheet.numbers(order, ("time", "acceleration"), ("m", "kg", "s"))
        np.testing.assert_array_equal(actual.table[:, 0], TIMES)
        np.testing.assert_allclose(actual.table[:, 1], frame["acc [g]"] * 9.80665, rtol=1e-15)
        assert actual.lines == [2, 3, 4]


def test_rows_of_numbers_with_an_empty_end_are_no_heads(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1.0, 2.0,\n4,5,\n7,8,\n")
    sheet = read_sheet(path, "")
    assert sheet.heads == []
    assert [row.cells for row in sheet.rows] == [["1.0", "2.0"], ["4", "5"], ["7", "8"]]


def test_one_row_of_numbers_parted_by_blanks_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("1  2  3\n")
    assert [row.cells for row in read_sheet(path, "").rows] == [["1", "2", "3"]]
