"""Curves of materials: a modulus or a table, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from contiga.errors import InputError
from contiga.matter.curves import as_table, max_slope

TABLE = [[0.0, 0.0], [0.1, 2.0], [0.5, 3.0], [0.6, 3.0], [0.9, 9.0]]


def test_a_table_and_its_largest_slope() -> None:
    table = as_table(TABLE, "loading")
    assert table.tolist() == TABLE
    assert max_slope(table) == pytest.approx(20.0)


def test_a_modulus_is_a_straight_line() -> None:
    assert as_table(3.0, "loading").tolist() == [[0.0, 0.0], [1.0, 3.0]]


@pytest.mark.parametrize(
    ("curve", "says"),
    [
        ([[0, 0], [0.1, 2], [0.2, 1]], "the stress falls at row 2"),
        ([[0, 0], [0.1, 2], [0.1, 3]], "the values of strain go back or repeat at row 2"),
        ([[0.1, 0], [0.2, 2]], "begin at zero"),
        ([[0, 0]], "at least 2 rows"),
        ([[0, 0], [0.1, float("nan")]], "finite"),
        ([[0, 0], [0.1, 0]], "carries nothing"),
        (-1.0, "stress falls"),
        ("foam", "numbers"),
    ],
)
def test_a_wrong_curve_is_refused(curve: Any, says: str) -> None:
    with pytest.raises(InputError, match=f"loading: .*{says}"):
        as_table(curve, "loading")
