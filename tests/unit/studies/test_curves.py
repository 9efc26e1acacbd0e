"""Curves of the cases of a study: a line a case, darker with the value of the first variable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.io.out.files import write_json
from contiga.io.out.history import write_history
from contiga.report.colours import channels
from contiga.studies.curves import curves_section
from contiga.studies.row import DONE, FAILED, Row

TIMES = np.linspace(0.0, 4.0, 9)


def rows_in(folder: Path, values: list[object]) -> list[Row]:
    """Rows whose cases have left a force over a depth; the last failed and left nothing."""
    rows = []
    for k, value in enumerate(values, 1):
        case = folder / "cases" / f"{k:04d}"
        case.mkdir(parents=True)
        columns = {"time": TIMES, "force": k * TIMES, "max_penetration": TIMES**2}
        write_history(case / "history.csv", columns)
        units = {"length": "mm", "mass": "g", "time": "ms"}
        write_json(case / "summary.json", {"units": units, "statuses": {"head-pad": {}}})
        rows.append(Row(k, DONE, "", {"v": value}, {}, 1.0))
    return [*rows, Row(len(values) + 1, FAILED, "no", {"v": 0.0}, {}, 1.0)]


@pytest.mark.parametrize("values", [[1.0, 3.0, 2.0], ["a", "c", "b"]])
def test_there_is_a_line_for_each_case_that_ran(tmp_path: Path, values: list[object]) -> None:
    html = curves_section(tmp_path, rows_in(tmp_path, values), "v")
    assert html.count('"type":"scatter"') == 3
    assert "head-pad.max_penetration\\u003cbr>[mm]" in html
    lines = [part.partition('"')[0] for part in html.split('"color":"')[1:] if part[0] == "#"]
    light = [float(channels(colour).sum()) for colour in lines[:3]]
    order = [1.0, 3.0, 2.0] if values[0] == 1.0 else [1.0, 2.0, 3.0]
    assert np.argsort(light)[::-1].tolist() == np.argsort(order).tolist(), "darker is greater"


def test_of_many_cases_some_are_drawn(tmp_path: Path) -> None:
    html = curves_section(tmp_path, rows_in(tmp_path, [float(k) for k in range(30)]), "v")
    assert html.count('"type":"scatter"') == 20
    assert "Lines are 20 cases" in html
    assert ">0001" in html
    assert ">0030" in html, "the first and the last among them"


def test_a_study_of_which_nothing_is_left_has_none(tmp_path: Path) -> None:
    assert curves_section(tmp_path, [Row(1, FAILED, "no", {"v": 1.0}, {}, 1.0)], "v") == ""
