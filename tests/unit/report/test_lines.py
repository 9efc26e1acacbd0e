"""Lines over time: all rows of short ones, the extremes of long ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.figures import checked

from contiga.report.figure import Figure
from contiga.report.lines import add_line, finish, largest, rows_drawn, vector_figure
from contiga.report.run_folder import read_run


def test_short_columns_are_drawn_whole() -> None:
    np.testing.assert_array_equal(rows_drawn(np.ones(7), max_rows=7), np.arange(7))


@pytest.mark.parametrize("n", [9, 1000, 12_345])
def test_long_columns_keep_their_ends_and_extremes(n: int) -> None:
    rng = np.random.default_rng(n)
    one, other = rng.normal(size=n), rng.normal(size=n)
    one[n // 3], other[n // 2] = 9.0, -9.0
    rows = rows_drawn(one, other, max_rows=8)
    assert len(rows) <= 8
    assert (np.diff(rows) > 0).all()
    assert {0, n // 3, n // 2, n - 1} <= set(rows.tolist())


def test_what_is_not_told_hides_no_extreme() -> None:
    values = np.full(100, np.nan)
    values[40], values[60] = 3.0, -2.0
    assert {40, 60} <= set(rows_drawn(values, max_rows=10).tolist())


def test_gaps_are_passed_over() -> None:
    figure = Figure()
    values = np.array([np.nan, 1.0, np.nan, 2.0])
    add_line(figure, np.arange(4.0), values, "a", "mm", color="#000000", width=2.0)
    (trace,) = checked(figure).data
    assert (trace.x.tolist(), trace.y.tolist()) == ([1.0, 3.0], [1.0, 2.0])
    assert "mm" in trace.hovertemplate
    add_line(figure, np.arange(4.0), np.full(4, np.nan), "b", "mm")
    assert len(checked(figure).data[1].x) == 0


def test_largest_is_of_what_is_finite() -> None:
    assert largest(np.array([1.0, -3.0, np.nan, np.inf])) == 3.0
    assert largest(None) == largest(np.zeros(0)) == 0.0


def test_components_that_would_lie_on_the_axis_are_left_out(run_folder: Path) -> None:
    run = read_run(run_folder)
    x = np.linspace(0.0, 3.0, 5)
    drawn = vector_figure(run, 2.0, {"x": x, "y": 1e-9 * x, "z": -4.0 * x / 3.0}, "Way", "mm")
    figure = checked(drawn)
    assert [trace.name for trace in figure.data] == ["along x", "along z", "resultant"]
    np.testing.assert_allclose(figure.data[2].y, 5.0 * x / 3.0, rtol=1e-12)
    assert figure.layout.yaxis.title.text == "Way [mm]"
    none = {axis: np.zeros(5) for axis in "xyz"}
    assert vector_figure(run, 2.0, none, "Way", "mm") is None


def test_upright_labels_are_in_lines_that_a_figure_has_room_for(run_folder: Path) -> None:
    run, label = read_run(run_folder), "Displacement of the centre of the body [mm]"
    figure = Figure()
    finish(figure, run, label, 2.0)
    layout = checked(figure).layout
    lines = layout.yaxis.title.text.split("<br>")
    assert " ".join(lines) == label
    assert max(map(len, lines)) <= 28
    assert [shape.name for shape in layout.shapes] == ["shown"]
