"""Tables as users hand them over: what is refused, and in which words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contiga.curves.tables import as_times, check_never_falls, table_of
from contiga.errors import InputError

ROWS = r"allowed: rows \[x, y\], x strictly increasing"


def test_a_table_is_a_copy_of_its_rows() -> None:
    rows = np.array([[0.0, 1.0], [2.0, 3.0]])
    table = table_of(rows, ("x", "y"))
    rows[:] = 7.0
    assert table.tolist() == [[0.0, 1.0], [2.0, 3.0]]


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ("steel", f"all of the same length; found 'steel'; {ROWS}"),
        ([[0, 1], [1]], "all of the same length"),
        ([[0, 1, 2], [1, 2, 3]], r"2 columns and at least 2 rows; found \(2, 3\)"),
        ([[0, 1]], r"2 columns and at least 2 rows; found \(1, 2\)"),
        ([], "2 columns and at least 2 rows"),
        ([[0, 1], [1, np.nan]], "row 1 is not finite"),
        ([[0, 1], [2, 1], [2, 0]], r"values of x go back or repeat at row 2; found \[2.0, 2.0\]"),
    ],
)
def test_rows_that_are_no_table_are_refused(rows: Any, says: str) -> None:
    with pytest.raises(InputError, match=f"curve: .*{says}"):
        table_of(rows, ("x", "y"), where="curve", at_least=2)


def test_what_falls_or_begins_below_zero_is_refused() -> None:
    check_never_falls(np.array([[0.0, 0.0], [1.0, 2.0], [2.0, 2.0]]), ("t", "force"), "pull")
    for rows, says in (
        ([[0.0, 1.0], [1.0, 2.0], [2.0, 1.5]], r"the force falls at row 2; found \[2.0, 1.5\]"),
        ([[0.0, -1.0], [1.0, 2.0]], "must not be negative; found -1.0"),
    ):
        with pytest.raises(InputError, match=f"pull: {says}"):
            check_never_falls(np.array(rows), ("t", "force"), "pull")


def test_times_are_as_many_as_their_rows_and_rise() -> None:
    assert as_times([0.0, 1.0], 2).tolist() == [0.0, 1.0]
    for times, says in (([0.0], "one finite time for each row"), ([1.0, 0.0], "times go back")):
        with pytest.raises(InputError, match=says):
            as_times(times, 2)
