"""Plots and test curves of a case: read, converted, kept with it, and refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.case.describe import describe
from contiga.case.schema import Case, load_case, parse_case
from contiga.case.toml import resolved_toml

from .conftest import GOOD, refused

TEST = "t [s];F [N]\n0;0\n0,002;1000\n"


def with_reference(folder: Path, table: str, text: str = TEST) -> Case:
    """The good case (mm, kg, ms) with a test whose file holds `text`."""
    (folder / "test.csv").write_text(text, encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(f"{GOOD}[[reference]]\n{table}", encoding="utf-8")
    return load_case(path)


def test_a_test_is_read_into_the_case_in_its_units(tmp_path: Path) -> None:
    case = with_reference(tmp_path, 'file = "test.csv"\nchannel = "force"\ncorridor = 0.1\n')
    (reference,) = case.reference
    assert reference.points == [[0.0, 0.0], [2.0, 1.0]], "ms and kN"
    assert (reference.name, reference.x, reference.shift) == ("test.csv", "time", 0.0)
    told = dict(describe(case))
    assert told["test test.csv"] == "force over time, 2 points, 0 to 2, corridor of 10 %"
    again = parse_case(resolved_toml(case))
    assert again.reference == case.reference, "and needs its file no more"


def test_units_that_the_file_does_not_say_are_said_by_the_case(tmp_path: Path) -> None:
    table = 'file = "test.csv"\nchannel = "force"\nunit = "N"\nx_unit = "s"\n'
    case = with_reference(tmp_path, table, "t;F\n0;0\n0,002;1000\n")
    assert case.reference[0].points == [[0.0, 0.0], [2.0, 1.0]]


def test_a_corridor_may_be_a_second_file(tmp_path: Path) -> None:
    (tmp_path / "band.csv").write_text("t [ms],a [N],b [N]\n0,-10,10\n2,900,1100\n")
    table = 'file = "test.csv"\nchannel = "force"\ncorridor = "band.csv"\n'
    case = with_reference(tmp_path, table)
    assert case.reference[0].corridor == [[0.0, -0.01, 0.01], [2.0, 0.9, 1.1]]


def test_a_test_may_be_over_another_channel(tmp_path: Path) -> None:
    table = 'file = "test.csv"\nchannel = "force"\nx = "max_penetration"\n'
    case = with_reference(tmp_path, table, "s [cm],F [N]\n0,0\n2,5\n1,0\n")
    assert [row[0] for row in case.reference[0].points] == [0.0, 20.0, 10.0]


@pytest.mark.parametrize(
    ("table", "text", "pieces"),
    [
        ('file = "test.csv"\nchannel = "forse"\n', TEST, ("channel", "found 'forse'")),
        (
            'file = "test.csv"\nchannel = "head.a"\n',
            "t [s];a [g]\n0;0\n1;1\n",
            ("no such channel",),
        ),
        ('file = "test.csv"\n', TEST, ("channel: is missing",)),
        ('channel = "force"\n', TEST, ("file or points",)),
        ('file = "none.csv"\nchannel = "force"\n', TEST, ("no such file",)),
        ('file = "test.csv"\nchannel = "force"\n', "t [s];F\n0;0\n1;1\n", ("no unit", "unit = ")),
        (
            'file = "test.csv"\nchannel = "force"\n',
            "t [s];F [N]\n0;0\n1;nan\n",
            ("csv:3", "finite"),
        ),
        (
            'file = "test.csv"\nchannel = "force"\n',
            "t [s];F [N]\n0;0\n0;1\n",
            ("csv:3", "increase"),
        ),
        (
            'file = "test.csv"\nchannel = "force"\n',
            "t [s];F [N]\n1;0\n2;1\n",
            ("in common", "onset"),
        ),
        ('file = "test.csv"\nchannel = "force"\nshift = "onst"\n', TEST, ("shift", "'onset'")),
        ('file = "test.csv"\nchannel = "force"\nshift = 99.0\n', TEST, ("shift", "99 to 101")),
        ('file = "test.csv"\nchannel = "force"\ncorridor = -1\n', TEST, ("corridor", "above 0")),
        (
            'channel = "force"\npoints = [[0, 0], [1, 1]]\nunit = "N"\n',
            TEST,
            ("unit", "is a key of a file"),
        ),
        ('channel = "force"\npoints = [[0, 0], [0, 1]]\n', TEST, ("points", "increase")),
        (
            'channel = "force"\npoints = [[0, 0], [1, 1]]\ncorridor = [[0, 2, 1], [1, 1, 2]]\n',
            TEST,
            ("corridor", "above the upper"),
        ),
    ],
)
def test_a_wrong_test_is_refused_in_one_message(
    tmp_path: Path, table: str, text: str, pieces: tuple[str, ...]
) -> None:
    (tmp_path / "test.csv").write_text(text, encoding="utf-8")
    end = "[output]\nevery = 1\n"
    refused(tmp_path, end, f"{end}[[reference]]\n{table}", (*pieces, "reference[0]"), Exception)


@pytest.mark.parametrize(
    ("table", "pieces"),
    [
        ('x = "forc"\ny = "force"', ("plot[0].x", "found 'forc'", "Did you mean 'force'?")),
        ('y = ["force", "a.b"]', ("plot[0].y", "found 'a.b'")),
        ('y = ["force", "area"]', ("plot[0].y", "one unit")),
        ("y = []", ("plot[0].y",)),
        ('z = "force"', ("plot[0].z", "unknown key")),
    ],
)
def test_a_wrong_plot_is_refused(tmp_path: Path, table: str, pieces: tuple[str, ...]) -> None:
    end = "[output]\nevery = 1\n"
    refused(tmp_path, end, f"{end}[[plot]]\n{table}\n", pieces, Exception)


def test_channels_are_columns_and_what_follows_from_them() -> None:
    more = '[[plot]]\nx = "max_penetration"\ny = ["plate-cylinder.force", "force"]\n'
    (plot,) = parse_case(GOOD + more).plot
    assert plot.describe() == "plate-cylinder.force, force over max_penetration"
    assert plot.channels == ["plate-cylinder.force", "force"]
    assert parse_case(f'{GOOD}[[plot]]\ny = "force"\n').plot[0].x == "time"
