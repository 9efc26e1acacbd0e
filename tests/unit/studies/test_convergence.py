"""Order of convergence, of sequences that have one."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from contiga.studies.convergence import (
    line_in_words,
    lines_of,
    order_of,
    refined_variable,
    sizes_of,
)
from contiga.studies.row import DONE, Row

from .conftest import study_from

TEXT = """
base = "case.toml"
collect = ["max(force)"]
[[variable]]
name = "speed"
key = "body.ball.motion.velocity[2]"
values = [-1.0, -2.0]
[[variable]]
name = "n"
key = ["slave.sheet.points.grid.nu", "slave.sheet.points.grid.nv"]
values = [10, 20, 30, 60]
refines = true
"""


@pytest.mark.parametrize("order", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("sizes", [[1.0, 0.5, 0.25], [1.0, 0.6, 0.3], [4.0, 3.0, 1.0]])
def test_the_order_is_found(order: float, sizes: list[float]) -> None:
    values = [7.0 - 2.0 * size**order for size in sizes]
    assert order_of(values, sizes) == pytest.approx(order, rel=1e-9)


def test_there_is_no_order_where_nothing_is_approached() -> None:
    sizes = [1.0, 0.5, 0.25]
    for values in ([1.0, 2.0, 1.0], [1.0, 1.0, 1.0], [1.0, 2.0, math.nan]):
        assert math.isnan(order_of(values, sizes))
    assert math.isnan(order_of([1.0, 2.0], [1.0, 0.5]))


def test_a_line_for_each_choice_of_the_others(folder: Path) -> None:
    study = study_from(TEXT, folder)
    rows, levels = [], [10, 20, 30, 60]
    for speed in (-1.0, -2.0):
        for n, h in zip(levels, sizes_of([float(n) for n in levels]), strict=True):
            told = {"max(force)": -10.0 * speed + h**2}
            rows.append(Row(len(rows) + 1, DONE, "", {"speed": speed, "n": n}, told, 0.0))
    assert refined_variable(study).label == "n"
    lines = lines_of(study, rows, "max(force)")
    assert [line.label for line in lines] == ["speed -1.0", "speed -2.0"]
    assert [line.rows for line in lines] == [[1, 2, 3, 4], [5, 6, 7, 8]]
    assert all(line.order == pytest.approx(2.0, rel=1e-9) for line in lines)
    assert lines[0].errors[-1] == pytest.approx(1.0 / 9.0 - 1.0 / 36.0)
    assert "order 2" in line_in_words(lines[0])
    assert [line.label for line in lines_of(study, rows[:7], "max(force)")] == ["speed -1.0"]
