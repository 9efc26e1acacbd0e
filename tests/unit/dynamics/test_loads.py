"""Loads: constant, over time, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from contiga.dynamics.loads import Load
from contiga.errors import InputError


def test_a_constant_load_is_the_same_at_all_times() -> None:
    load = Load("head", force=[1, 2, 3], moment=[0, 0, 4], at=[5, 6, 7], follow=True)
    for t in (-1.0, 0.0, 1e9):
        np.testing.assert_array_equal(load.force_at(t), [1, 2, 3])
        np.testing.assert_array_equal(load.moment_at(t), [0, 0, 4])
    assert load.span is None
    assert load.follow
    assert load.at is not None
    np.testing.assert_array_equal(load.at, [5, 6, 7])


def test_a_load_over_time_is_linear_between_its_rows_and_zero_outside() -> None:
    load = Load("head", moment=[[1, 0, 0, 8], [3, 4, 0, 0], [4, 4, 0, 2]])
    assert load.span == (1.0, 4.0)
    assert load.at is None
    for t, moment in (
        (0.999, [0, 0, 0]),
        (1.0, [0, 0, 8]),
        (1.5, [1, 0, 6]),
        (3.5, [4, 0, 1]),
        (4.0, [4, 0, 2]),
        (4.001, [0, 0, 0]),
    ):
        np.testing.assert_allclose(load.moment_at(t), moment, rtol=1e-15)
        assert not load.force_at(t).any()


def test_the_span_is_that_of_both_tables() -> None:
    force = [[0, 1, 0, 0], [5, 1, 0, 0]]
    moment = [[1, 1, 0, 0], [9, 1, 0, 0]]
    assert Load("head", force=force, moment=moment).span == (1.0, 5.0)
    assert Load("head", force=force, moment=[1, 0, 0]).span == (0.0, 5.0)


def test_smooth_loads_are_monotone_cubics() -> None:
    rows = np.array([[0, 0, 5, 0], [1, 0, 4, 1], [2, 3, 0, 1], [4, 3, 1, 0]], dtype=float)
    load, curve = Load("a", force=rows, smooth=True), PchipInterpolator(rows[:, 0], rows[:, 1:])
    for t in np.linspace(0.0, 4.0, 23):
        np.testing.assert_allclose(load.force_at(t), curve(t), atol=1e-14)


def test_a_load_handed_out_cannot_be_changed_by_its_reader() -> None:
    load = Load("a", force=[1, 2, 3])
    with pytest.raises(ValueError, match="read-only"):
        load.force_at(0.0)[0] = 9.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "force: a load needs a force or a moment; found 'neither'"),
        ({"at": [0, 0, 0]}, "a load needs a force or a moment"),
        ({"moment": [1, 0, 0], "at": [0, 0, 0]}, "at: a moment has no point"),
        ({"force": [1, 0]}, "force: must be three finite numbers"),
        ({"force": 3.0}, "force: a table must have 4 columns"),
        ({"moment": [[0, 1, 2], [1, 1, 2]]}, "moment: .*4 columns.*Mx, My, Mz"),
        ({"force": [[0, 1, 2, 3]]}, "force: .*at least 2 rows"),
        ({"force": [[0, 1, 2, 3], [1, 2]]}, "force: .*all of the same length"),
        ({"force": [[1, 1, 2, 3], [0, 1, 2, 3]]}, "force: the times go back"),
        ({"force": [np.nan, 0, 0]}, "force: must be three finite numbers"),
        ({"force": [1, 0, 0], "at": [0, 0]}, "at: must be three finite numbers"),
        ({"force": [1, 0, 0], "smooth": True}, "smooth: there are no rows"),
    ],
)
def test_a_wrong_load_is_refused_with_its_rule(given, message) -> None:
    with pytest.raises(InputError, match=message):
        Load("head", **given)


@pytest.mark.parametrize("body", ["", 3])
def test_a_load_needs_a_body(body) -> None:
    with pytest.raises(InputError, match="body: must name a body"):
        Load(body, force=[1, 0, 0])
