"""Every case of the closed forms holds: each number, and the order of convergence."""

from __future__ import annotations

import pytest

from contiga_validation.closed_forms.case import Case
from contiga_validation.closed_forms.catalogue import cases
from contiga_validation.closed_forms.page import SIZE
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Picture

ONLY_IN_FULL = (
    *("roll-down", "block-slips", "winkler-deep", "matter-cook-volume", "matter-ball-on-membrane"),
    *("top-kept", "matter-hertz", "matter-catenary", "belt-capstan", "belt-running"),
)
"""Of those with others of their kind."""


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            case, marks=[pytest.mark.full] if case.key in ONLY_IN_FULL else [], id=case.key
        )
        for case in cases()
    ],
)
def test_case_holds(case: Case) -> None:
    answer = case.run()
    assert answer.checks
    broken = [f"{c.what}: {c.measured} {c.expected}" for c in answer.checks if not c.holds]
    assert broken == []
    if answer.order is not None:
        assert answer.order.holds, answer.order
    assert len(png(Picture(case.key, case.title, answer.draw, SIZE))) > 5000
