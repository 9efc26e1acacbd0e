"""How time goes on: equal steps, lists of times."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.dynamics.stepping import AutoSteps, EqualSteps, GivenTimes, Stepping
from contiga.errors import InputError


def walked(stepping: Stepping) -> list[float]:
    times = [stepping.start]
    while times[-1] < stepping.end:
        times.append(stepping.after(times[-1]))
    return times


@given(
    start=st.floats(-1e3, 1e3),
    length=st.floats(1e-6, 1e3),
    share=st.floats(1e-3, 1.0),
)
def test_equal_steps_walk_through_what_is_planned(
    start: float, length: float, share: float
) -> None:
    end = start + length
    stepping = EqualSteps(start, end, share * (end - start))
    planned = stepping.planned()
    assert walked(stepping) == planned.tolist()
    assert (np.diff(planned) > 0.0).all()
    assert (planned[0], planned[-1], len(planned)) == (start, end, stepping.count + 1)


def test_from_between_two_times_it_goes_to_the_next() -> None:
    stepping = EqualSteps(0.0, 1.0, 0.3)
    for time, after in ((0.1, 0.3), (0.3, 0.6), (0.89, 3 * 0.3), (0.95, 1.0), (-5.0, 0.0)):
        assert stepping.after(time) == after
    given_times = GivenTimes([0.0, 0.5, 2.0])
    for time, after in ((-1.0, 0.0), (0.0, 0.5), (0.4, 0.5), (0.5, 2.0), (2.0, 2.0), (9.0, 2.0)):
        assert given_times.after(time) == after


def test_a_list_is_walked_as_it_is_and_cannot_be_changed_from_outside() -> None:
    times = np.array([1.0, 1.5, 4.0])
    stepping = GivenTimes(times)
    times[1] = 9.0
    assert walked(stepping) == [1.0, 1.5, 4.0]
    assert walked(GivenTimes([3.0])) == [3.0]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, 0.0, 1.0), "after the start"),
        ((0.0, np.nan, 1.0), "after the start"),
        ((0.0, 1.0, 0.0), "positive"),
        ((0.0, 1.0, np.nan), "positive"),
        ((0.0, 1.0, 1.1), "longer than the whole"),
        ((1e16, 1e16 + 4.0, 1.0), "rounding"),
        ((0.0, 1.0, 1e-9), r"makes 1e\+09 steps"),
    ],
)
def test_steps_that_lead_nowhere_are_refused(
    values: tuple[float, float, float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        EqualSteps(*values)


def test_a_longest_step_that_makes_too_many_is_refused() -> None:
    """The list of times that it plans took all memory."""
    with pytest.raises(InputError, match=r"largest: makes 1e\+15 steps or more"):
        AutoSteps(0.0, 1e12, largest=1e-3)
    assert len(AutoSteps(0.0, 1e12).planned()) == 201


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.0], [0.0, np.inf], [[0.0, 1.0]]])
def test_lists_of_times_that_do_not_rise_are_refused(times: list[float]) -> None:
    with pytest.raises(InputError, match="times"):
        GivenTimes(times)
