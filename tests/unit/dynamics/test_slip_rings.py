"""Slip rings by themselves: which way webbing slips, and how far."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from contiga.belts import SlipRing
from contiga.curves.curve_records import Response
from contiga.dynamics.slip_rings import slip
from contiga.dynamics.spring_law import SLACK
from contiga.errors import InputError


def segment(stiffness: float, stretch: float) -> Callable[[float], Response]:
    """Tension of webbing that is slack below its rest length, over the length fed in."""

    def tension(fed: float) -> Response:
        x = stretch - fed
        return Response(stiffness * x, stiffness, 0.0, 0.0) if x > 0.0 else SLACK

    return tension


@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0])
def test_webbing_slips_to_the_larger_tension_until_the_ratio_is_that_of_the_ring(ratio) -> None:  # type: ignore[no-untyped-def]
    first, second = segment(100.0, 1.0), segment(300.0, 3.0)
    slipped = slip(first, second, ratio)
    # 300 (3 − s) = ratio · 100 (1 + s)
    np.testing.assert_allclose(slipped, (900 - 100 * ratio) / (300 + 100 * ratio), rtol=1e-14)
    assert slip(second, first, ratio) == -slipped


def test_webbing_sticks_within_the_ratio() -> None:
    assert slip(segment(100.0, 1.0), segment(300.0, 0.5), 1.51) == 0.0
    assert slip(segment(100.0, -1.0), segment(300.0, -2.0), 1.0) == 0.0


def test_slack_on_one_side_is_taken_up_first() -> None:
    slipped = slip(segment(100.0, -2.0), segment(300.0, 3.0), 1.5)
    np.testing.assert_allclose(slipped, (900 + 300) / (300 + 150), rtol=1e-14)
    # More slack than stretch: both end without tension.
    assert slip(segment(100.0, -9.0), segment(300.0, 3.0), 1.5) == 3.0


def test_the_ratio_is_the_capstan_formula() -> None:
    assert SlipRing(("a", "b"), friction=0.3).ratio(math.pi) == math.exp(0.3 * math.pi)


@pytest.mark.parametrize(
    ("between", "friction", "told"),
    [
        (("a", "b"), -0.1, "friction: must not be negative"),
        (("a", "a"), 0.1, "between: must be two segments"),
        ("ab", 0.1, "between: must be two segments"),
        (("a",), 0.1, "between: must be two segments"),
    ],
)
def test_rings_that_make_no_sense_are_refused(between, friction, told) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=told):
        SlipRing(between, friction=friction)
