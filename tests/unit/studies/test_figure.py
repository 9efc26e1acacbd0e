"""`Study.plot`: quantities over the variable, or over the cases."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.studies.figure import plot_table
from contiga.studies.row import DONE, Row
from contiga.studies.table import Table, table_of


def table(*variables: str) -> Table:
    rows = [
        Row(k + 1, DONE, "", dict.fromkeys(variables, v), {"HIC": 10.0 * v, "a": -v}, 1.0)
        for k, v in enumerate((3.0, 1.0, 2.0))
    ]
    return table_of(rows, variables, ["HIC", "a"], {"speed": "mm/ms", "a": "g"})


def test_quantities_are_drawn_over_the_only_variable_in_its_order() -> None:
    figure = plot_table("a test", table("speed"))
    first, second = figure.axes
    assert (first.get_xlabel(), first.get_ylabel()) == ("speed [mm/ms]", "HIC")
    assert second.get_ylabel() == "a [g]"
    np.testing.assert_array_equal(
        first.lines[0].get_xydata(), [[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]]
    )


def test_of_several_variables_quantities_are_drawn_over_the_cases() -> None:
    figure = plot_table("a test", table("speed", "angle"), ["a"])
    (axes,) = figure.axes
    assert axes.get_xlabel() == "case"
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [-3.0, -1.0, -2.0])


def test_a_column_that_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(InputError, match=r"no such column of numbers.*'status'.*HIC"):
        plot_table("a test", table("speed"), ["status"])
