"""Curves of straight pieces: in kernels and outside of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from contiga.errors import InputError
from contiga.matter.curves import as_table, at, max_slope, packed
from contiga.matter.kernels import curve_nb

TABLE = np.array([[0.0, 0.0], [0.1, 2.0], [0.5, 3.0], [0.6, 3.0], [0.9, 9.0]])


@njit
def asked(numbers: np.ndarray, n: int, x: np.ndarray, y: np.ndarray, w: np.ndarray) -> None:
    for k in range(len(x)):
        y[k], w[k] = curve_nb.curve_at(numbers, 1, n, x[k])


@pytest.mark.interpreted
def test_a_curve_and_its_integral() -> None:
    x = np.concatenate([np.linspace(0.0, 1.2, 25), TABLE[:, 0]])
    y, w = np.empty(len(x)), np.empty(len(x))
    asked(np.concatenate([[7.0], packed(TABLE)]), len(TABLE), x, y, w)
    np.testing.assert_allclose(y, at(TABLE, x), rtol=1e-13)
    expected = []
    for end in x:
        s = np.union1d(np.linspace(0.0, end, 2), TABLE[TABLE[:, 0] <= end, 0])
        expected.append(np.sum(0.5 * np.diff(s) * (at(TABLE, s[1:]) + at(TABLE, s[:-1]))))
    np.testing.assert_allclose(w, expected, rtol=1e-12, atol=1e-16)
    assert max_slope(TABLE) == pytest.approx(20.0)


def test_a_modulus_is_a_straight_line() -> None:
    np.testing.assert_array_equal(at(as_table(3.0, "loading"), np.array([0.5, 2.0])), [1.5, 6.0])


@pytest.mark.parametrize(
    ("curve", "says"),
    [
        ([[0, 0], [0.1, 2], [0.2, 1]], "stress falls at row 2"),
        ([[0, 0], [0.1, 2], [0.1, 3]], "strain does not rise at row 2"),
        ([[0.1, 0], [0.2, 2]], "begin at zero"),
        ([[0, 0]], "no table"),
        ([[0, 0], [0.1, np.nan]], "finite"),
        ([[0, 0], [0.1, 0]], "carries nothing"),
        (-1.0, "stress falls"),
        ("foam", "numbers"),
    ],
)
def test_a_wrong_curve_is_refused(curve: Any, says: str) -> None:
    with pytest.raises(InputError, match=says):
        as_table(curve, "loading")
