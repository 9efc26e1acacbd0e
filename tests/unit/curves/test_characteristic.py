"""Characteristics: tables, lines, callables, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError, RunError

TABLE = [[0.0, 0.0], [1.0, 2.0], [3.0, 3.0]]


def test_a_table_is_linear_between_its_points_and_exact_at_them() -> None:
    curve = Characteristic(TABLE)
    np.testing.assert_array_equal(curve([0.0, 0.5, 1.0, 2.0, 3.0]), [0.0, 1.0, 2.0, 2.5, 3.0])


def test_linear_extrapolation_continues_the_first_and_last_segment() -> None:
    np.testing.assert_allclose(Characteristic(TABLE)([-1.0, 5.0]), [-2.0, 4.0], rtol=1e-15)


def test_linear_is_the_default_extrapolation() -> None:
    assert Characteristic(TABLE).extrapolation == "linear"


def test_constant_extrapolation_holds_the_ends() -> None:
    curve = Characteristic([[1.0, 2.0], [3.0, 3.0]], extrapolation="constant")
    np.testing.assert_array_equal(curve([0.0, 9.0]), [2.0, 3.0])


def test_error_extrapolation_stops_with_the_value_asked_for_and_the_range() -> None:
    curve = Characteristic(TABLE, extrapolation="error", name="elastic")
    np.testing.assert_array_equal(curve([0.0, 3.0]), [0.0, 3.0])
    with pytest.raises(RunError, match=r"elastic: .*4\.5, outside its table \[0, 3\]"):
        curve([1.0, 4.5])


def test_a_number_is_a_line_through_the_origin_on_both_sides() -> None:
    np.testing.assert_array_equal(Characteristic(0.5)([-2.0, 0.0, 8.0]), [-1.0, 0.0, 4.0])
    np.testing.assert_array_equal(Characteristic(np.float32(2.0))([3.0]), [6.0])


def test_a_callable_is_used_as_it_is() -> None:
    np.testing.assert_array_equal(Characteristic(np.square)([1.0, 3.0]), [1.0, 9.0])


def test_a_characteristic_of_a_characteristic_is_the_same_curve() -> None:
    inner = Characteristic(TABLE, extrapolation="constant")
    np.testing.assert_array_equal(Characteristic(inner)([9.0]), [3.0])


def test_the_answer_has_the_shape_of_the_question() -> None:
    curve = Characteristic(TABLE)
    assert curve(0.5).shape == ()
    assert curve(np.zeros((2, 3))).shape == (2, 3)
    assert curve(np.zeros(0)).shape == (0,)


def test_the_table_is_a_copy_that_cannot_be_written() -> None:
    table = np.array(TABLE)
    curve = Characteristic(table)
    table[:] = 7.0
    assert curve(1.0) == 2.0
    with pytest.raises(ValueError, match="read-only"):
        curve.y[0] = 1.0


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        ([[0, 0], [2, 1], [1, 2]], r"values of x go back or repeat at row 2; found \[2.0, 1.0\]"),
        ([[0, 0], [0, 1]], "values of x go back or repeat at row 1"),
        ([[0, 0]], r"at least 2 rows; found \(1, 2\)"),
        ([[0, 0], [1, np.nan]], "row 1 is not finite"),
        ([[0, 0], [np.inf, 1]], "row 1 is not finite"),
        ([[0, 0, 0], [1, 1, 1]], "2 columns"),
        ([0, 1], "2 columns"),
        ([], "2 columns"),
        ("steel", "rows of numbers.* found 'steel'; allowed: a number, a callable, or rows"),
        (True, "2 columns"),
        ([[0, 0], [1]], "all of the same length"),
        (np.inf, "must be finite"),
        (lambda x: float(x) if x > 0 else 0.0, "fails when called with an array"),
        (lambda x: 1.0, "same shape"),
        (lambda x: x[:-1], "same shape"),
        (lambda x: np.full_like(x, np.nan), "not finite"),
    ],
)
def test_a_wrong_curve_is_refused_with_its_rule(curve: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Characteristic(curve)


def test_a_callable_that_turns_infinite_later_is_found_when_it_does() -> None:
    with np.errstate(divide="ignore"):
        curve = Characteristic(lambda x: 1.0 / (2.0 - x))
        with pytest.raises(InputError, match="value at 2 is not finite"):
            curve([1.0, 2.0])


def test_an_unknown_extrapolation_names_the_known_ones() -> None:
    with pytest.raises(InputError, match="'linear', 'constant', 'error'"):
        Characteristic(TABLE, extrapolation="cubic")


CURVES = {
    "line": Characteristic(3.0),
    "table": Characteristic([[0.0, 0.0], [1.0, 2.0], [2.0, 8.0]]),
    "preloaded": Characteristic([[-1.0, 4.0], [1.0, 2.0]]),
    "late": Characteristic([[0.5, -1.0], [1.0, 1.0], [1.5, 1.0]]),
    "falls below zero": Characteristic([[0.0, 1.0], [0.7, -1.0], [1.1, 3.0], [1.2, 2.9]]),
    "held": Characteristic([[0.2, 1.0], [0.6, 5.0]], extrapolation="constant"),
    "all below": Characteristic([[0.0, -2.0], [1.0, -1.0]]),
    "function": Characteristic(lambda x: x**3 + 0.5 * np.sin(3.0 * x)),
}


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_energy_is_the_integral_of_what_pushes(curve: Characteristic) -> None:
    """Against a fine sum; and its slope is the curve."""
    x = np.array([0.0, 0.3, 0.5, 0.9, 1.0, 1.15, 2.5])
    for end, found in zip(x, curve.energy(x), strict=True):
        middles = (np.arange(200_000) + 0.5) * end / 200_000
        fine = np.maximum(curve(middles), 0.0).sum() * end / 200_000
        assert found == pytest.approx(fine, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_slope_is_that_to_the_right(curve: Characteristic) -> None:
    x = np.array([0.0, 0.3, 0.5, 0.9, 1.0, 1.15, 2.5])
    step = 1e-7
    np.testing.assert_allclose(
        curve.slope(x), (curve(x + step) - curve(x)) / step, rtol=2e-6, atol=1e-6
    )


def test_a_table_that_ends_in_an_error_stores_up_to_its_end() -> None:
    curve = Characteristic([[0.5, 1.0], [1.0, 3.0]], extrapolation="error")
    np.testing.assert_allclose(curve.energy([0.2, 0.5, 0.75, 1.0]), [0.0, 0.0, 0.375, 1.0])
    with pytest.raises(RunError):
        curve.energy([1.1])
