"""Arrays at the public door."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.layout import as_parameters, as_points, bytes_of, locked, read_only
from contiga.errors import InputError


def test_a_fitting_array_is_not_copied() -> None:
    points = np.zeros((4, 3))
    assert as_points(points) is points


def test_lists_integers_and_strides_become_contiguous_floats() -> None:
    for values in ([[1, 2, 3]], np.ones((3, 5), dtype=np.int32).T, np.ones((6, 6))[::2, ::2]):
        points = as_points(values)
        assert points.dtype == np.float64
        assert points.flags.c_contiguous


def test_a_single_point_becomes_one_row() -> None:
    assert as_points([1.0, 2.0, 3.0]).shape == (1, 3)
    assert as_parameters([0.5, 0.25]).shape == (1, 2)


def test_not_finite_points_pass() -> None:
    assert np.isnan(as_points([[np.nan, 0.0, np.inf]])[0, 0])


@pytest.mark.parametrize("values", [1.0, [], [1.0, 2.0], [[1.0, 2.0]], np.zeros((2, 3, 3))])
def test_points_of_another_shape_are_refused(values: object) -> None:
    with pytest.raises(InputError, match=r"cloud must have shape \(n, 3\)") as error:
        as_points(values, "cloud")  # type: ignore[arg-type]
    assert error.value.allowed == "(n, 3)"


@pytest.mark.parametrize("values", ["abc", [[1.0, 2.0, "x"]], [[1.0], [1.0, 2.0]], None])
def test_points_that_are_not_numbers_are_refused(values: object) -> None:
    with pytest.raises(InputError):
        as_points(values)  # type: ignore[arg-type]


@pytest.mark.parametrize("values", [1.0, [1.0], [[1.0, 2.0, 3.0]], [["a", "b"]]])
def test_parameters_of_another_shape_are_refused(values: object) -> None:
    with pytest.raises(InputError, match="uv"):
        as_parameters(values)  # type: ignore[arg-type]


def test_read_only_is_a_copy_that_cannot_be_written_to() -> None:
    values = np.zeros(3)
    copy = read_only(values)
    values[0] = 1.0
    assert copy[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        copy[0] = 2.0


def test_memory_is_that_of_the_arrays_in_a_record_at_any_depth() -> None:
    inner = (np.zeros((2, 3)), np.zeros(5, np.int8), "text", None)
    assert bytes_of(np.zeros(4, np.float32)) == 16
    assert bytes_of((inner, 7, np.zeros(1, np.int32))) == 48 + 5 + 4
    assert bytes_of([np.zeros(3)]) == 0


def test_what_is_locked_is_a_view_that_cannot_be_written_to():
    own = np.zeros(3)
    view = locked(own)
    own[1] = 2.0
    assert view.tolist() == [0.0, 2.0, 0.0]
    with pytest.raises(ValueError, match="read-only"):
        view[0] = 1.0
    assert own.flags.writeable
