"""The tables of the report."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.report.html_tables import (
    inputs_table,
    key_figures,
    status_table,
    timings_table,
)
from contiga.report.run_folder import Run, read_run

from .conftest import write_folder


@pytest.fixture
def run(tmp_path: Path) -> Run:
    return read_run(write_folder(tmp_path / "out", fields=False))


def test_key_figures_are_the_extremes_of_the_history(run: Run) -> None:
    tiles = key_figures(run)
    for text in ("90 <small>N", "3 <small>mm", "45 <small>mm²", "45 <small>", "at t = 2 ms"):
        assert text in tiles


def test_criteria_are_key_figures(run: Run) -> None:
    values = {
        "HIC15": {"value": 1012.0, "start": 5.0, "end": 11.0},
        "3ms": {"value": 127.9, "unit": "g", "start": 8.0, "end": 11.0},
    }
    told = {
        "sensors": {
            "head": {"criteria": values},
            **{f"s{k}": {"criteria": values} for k in range(9)},
        }
    }
    tiles = key_figures(run._replace(summary=told))
    for text in ("HIC15 of head", "t = 5 to 11 ms", "127.9 <small>g", "3ms of s1"):
        assert text in tiles
    assert "of s2" not in tiles  # a table has all


def test_timings_tell_compiling_apart(run: Run) -> None:
    table = timings_table(run)
    assert '<tr class="apart"><td>Compiling' in table
    assert "4 s without compiling" in table
    assert "width:60.00%" in table
    assert "Everything else" in table


def test_statuses_have_a_row_each_and_a_column_a_contact(run: Run) -> None:
    table = status_table(run)
    assert table.count("<tr>") == 3
    assert ">press</th>" in table
    assert '<td>free</td><td class="number">169</td><td></td>' in table


def test_a_status_that_was_counted_says_what_it_means(run: Run) -> None:
    told = {"statuses": {"a": {"LOST": 2}, "b": {"LOST": 0}}, "advice": {"LOST": "Steps < 1."}}
    table = status_table(run._replace(summary=told))
    cells = '<td class="number">2</td><td class="number">0</td><td>Steps &lt; 1.</td>'
    assert f"<td>lost</td>{cells}" in table


def test_inputs_name_bodies_and_slaves(run: Run) -> None:
    table = inputs_table(run)
    assert "<td>ball</td><td>body</td><td>patches 1 · size 34.64 mm</td>" in table
    assert "<td>sheet</td><td>slave</td><td>points 169</td>" in table


def test_tables_of_an_empty_summary_are_left_out(run: Run) -> None:
    bare = run._replace(summary={})
    assert status_table(bare) == timings_table(bare) == inputs_table(bare) == ""
