"""Measured curves as they come: of spreadsheets of any country, and of ISO-MME tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import ContigaError, FileError, InputError, UnitError
from contiga.io.measured import read_measured
from contiga.io.out.iso_mme import MmeChannel, write_mme

UNITS = ("mm", "g", "ms")
OVER_TIME = ("time", "force")


def saved(folder: Path, text: str, name: str = "test.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("t [s],F [kN]\n0,0\n0.001,1.5\n", "utf-8"),
        ("Zeit [s];Kraft [kN]\r\n0;0\r\n0,001;1,5\r\n", "cp1252"),
        ("Zeit;Kraft für Kopf\r\ns;kN\r\n0;0\r\n0,001;1,5\r\n", "cp1252"),
        ("Zeit\tKraft\n[ms]\t[N]\n0\t0\n1\t1500\n", "utf-16"),
        ("\ufeffZeit (ms);Kraft (N);\n0;0;\n1;1,5e3;\n", "utf-8"),
    ],
)
def test_a_spreadsheet_is_read_as_it_comes(tmp_path: Path, text: str, encoding: str) -> None:
    table = read_measured(saved(tmp_path, text, encoding=encoding), OVER_TIME, UNITS)
    np.testing.assert_allclose(table, [[0, 0], [1, 1500]], rtol=1e-12)


def test_units_may_be_said_beside_the_file(tmp_path: Path) -> None:
    path = saved(tmp_path, "t,F\n0,0\n1,2\n")
    table = read_measured(path, OVER_TIME, UNITS, units=("s", "kN"))
    np.testing.assert_allclose(table, [[0, 0], [1000, 2000]])


def test_a_corridor_has_two_values(tmp_path: Path) -> None:
    path = saved(tmp_path, "t [ms],low [N],high [N]\n0,-1,1\n2,3,5\n")
    table = read_measured(path, ("time", "force", "force"), UNITS)
    np.testing.assert_array_equal(table, [[0, -1, 1], [2, 3, 5]])


def test_over_a_depth_a_curve_may_go_back(tmp_path: Path) -> None:
    path = saved(tmp_path, "s [mm],F [N]\n0,0\n5,9\n3,1\n")
    assert read_measured(path, ("length", "force"), UNITS)[:, 0].tolist() == [0, 5, 3]


def test_channels_of_a_test_are_read_as_they_are_written(tmp_path: Path) -> None:
    force = MmeChannel(
        "10PAD0000000FO00", "pad force", "N", 0.002, 1e-4, np.array([1.0, -2.5, 7.0])
    )
    other = force._replace(code="10HEAD000000ACR0", unit="m/(s*s)", name="head a")
    folder = write_mme(tmp_path, "T1", [force, other], title="A test")
    for path, code in ((folder / "Channel" / "T1.001", None), (folder / "T1.mme", "10pad")):
        table = read_measured(path, OVER_TIME, UNITS, code=code)
        np.testing.assert_allclose(table, [[2.0, 1.0], [2.1, -2.5], [2.2, 7.0]], rtol=1e-12)
    table = read_measured(folder / "T1.mme", ("time", "acceleration"), UNITS, code="10HEAD")
    np.testing.assert_allclose(table[:, 1], 1e-3 * force.values)
    with pytest.raises(FileError, match=r"which channel is meant.*10PAD0000000FO00"):
        read_measured(folder / "T1.mme", OVER_TIME, UNITS)
    with pytest.raises(FileError, match="no such channel; found '10CHST'"):
        read_measured(folder / "T1.mme", OVER_TIME, UNITS, code="10CHST")
    with pytest.raises(UnitError, match="not a unit of force"):
        read_measured(folder / "Channel" / "T1.002", OVER_TIME, UNITS)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("t [ms],F\n0,0\n1,1\n", UnitError, r"no unit; found 'F'.*unit = …"),
        ("t,F [N]\n0,0\n1,1\n", UnitError, r"no unit; found 't'.*x_unit = …"),
        ("t [ms],F [mm]\n0,0\n1,1\n", UnitError, "not a unit of force; found 'mm'"),
        ("t [ms],F [N]\n0,0\n1,nan\n", FileError, r"test.csv:3: a number is not finite"),
        ("t [ms],F [N]\n0,0\n1,1\n1,2\n", FileError, r"test.csv:4: the times must increase"),
        ("t [ms],F [N]\n0,0\n", FileError, "two rows or more"),
        ("t [ms],F [N],G [N]\n0,0,0\n", FileError, "which columns are meant"),
        ("0,0\n1,1\n", FileError, "must name the columns"),
        ("t [ms];F [N]\n0;0,5\n1;1.5\n", FileError, "decimal commas and decimal points"),
    ],
)
def test_a_wrong_file_is_refused(
    tmp_path: Path, text: str, error: type[ContigaError], message: str
) -> None:
    with pytest.raises(error, match=message):
        read_measured(saved(tmp_path, text), OVER_TIME, UNITS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Unit :N\n1\n2\n", "no sampling interval"),
        ("Sampling interval :0\n1\n2\n", "above zero"),
        ("Sampling interval :1e-4\n1\nNOVALUE\n", "T.001:3: a sample is not a finite number"),
        ("Sampling interval :1e-4\nUnit :NOVALUE\n1\n2\n", "the channel has no unit"),
    ],
)
def test_a_wrong_channel_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_measured(saved(tmp_path, text, "T.001"), OVER_TIME, UNITS)
