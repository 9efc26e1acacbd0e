"""What is collected, beside the same by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga.errors import CaseError
from contiga.studies.quantities import quantity_of

T = np.array([0.0, 1.0, 2.0, 4.0])
HISTORY = {
    "time": T,
    "force": np.array([0.0, 5.0, 2.0, 0.0]),
    "head.vz": np.array([-4.0, -1.0, 1.0, 3.0]),
    "area": np.array([np.nan, 7.0, np.nan, 1.0]),
    "none": np.full(4, np.nan),
}
SUMMARY = {
    "steps": 4,
    "warnings": ["a", "b"],
    "energy": {"relative": 0.25},
    "sensors": {"cg": {"criteria": {"HIC15": {"value": 812.5, "start": 0.0, "end": 1.0}}}},
}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("max(force)", 5.0),
        ("max(head-pad.force)", 5.0),
        ("min(head.vz)", -4.0),
        ("peak(head.vz)", -4.0),
        ("start(head.vz)", -4.0),
        ("end(head.vz)", 3.0),
        ("mean(force)", (2.5 + 3.5 + 2.0) / 4.0),
        ("time_of_max(force)", 1.0),
        ("time_of_min(head.vz)", 0.0),
        ("time_of_peak(head.vz)", 0.0),
        ("at(head.vz, 3.0)", 2.0),
        ("at( head.vz , 1e0 )", -1.0),
        ("max(area)", 7.0),
        ("at(area, 2.5)", 4.0),
        ("cg.HIC15", 812.5),
        ("energy_error", 0.25),
        ("steps", 4.0),
        ("warnings", 2.0),
    ],
)
def test_quantities_are_those_of_the_history(text: str, value: float) -> None:
    assert quantity_of(text).value(HISTORY, SUMMARY) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(force)", "N"),
        ("max(head-pad.force)", "N"),
        ("at(head.vz, 3.0)", "mm/ms"),
        ("time_of_max(force)", "ms"),
        ("cg.HIC15", ""),
        ("cg.3ms", "g"),
        ("steps", ""),
        ("max(n_contact)", ""),
    ],
)
def test_quantities_say_their_units(text: str, unit: str) -> None:
    assert quantity_of(text).unit(("mm", "g", "ms")) == unit
    assert quantity_of("max(force)").unit(("", "", "")) == ""


@pytest.mark.parametrize("text", ["max(none)", "end(gone)", "cg.3ms", "tail.HIC15"])
def test_what_a_case_has_not_is_no_number(text: str) -> None:
    assert math.isnan(quantity_of(text).value(HISTORY, SUMMARY))
    assert math.isnan(quantity_of("energy_error").value(HISTORY, {"energy": {}}))


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        *((text, "") for text in ("force", "max()", "max(force, 3)", "at(force)", ".HIC15", "")),
        ("maxx(force)", "Did you mean 'max'"),
    ],
)
def test_what_is_no_quantity_is_refused(text: str, remedy: str) -> None:
    with pytest.raises(CaseError, match="cannot be collected") as caught:
        quantity_of(text)
    assert remedy in str(caught.value)


def test_what_cases_will_not_have_is_refused_before_they_run() -> None:
    columns, criteria = ["force", "head.vz"], ["head_cg.HIC15"]
    for text in ("max(force)", "head_cg.HIC15", "at(head.vz, 9)", "steps"):
        quantity_of(text).check(columns, criteria, 10.0)
    with pytest.raises(CaseError, match=r"no such column .*Did you mean 'force'"):
        quantity_of("max(forse)").check(columns, criteria, 10.0)
    with pytest.raises(CaseError, match=r"no such criterion .*Did you mean 'head_cg.HIC15'"):
        quantity_of("head_cg.HIC36").check(columns, criteria, 10.0)
    with pytest.raises(CaseError, match=r"after the end of the cases.*up to 10"):
        quantity_of("at(force, 11)").check(columns, criteria, 10.0)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(force)", "N"),
        ("at(ball.vz, 2)", "mm/ms"),
        ("time_of_max(force)", "ms"),
        ("cg.3ms", "g"),
        ("cg.HIC15", ""),
        ("energy_error", ""),
        ("steps", ""),
        ("max(pad.max_penetration)", "mm"),
    ],
)
def test_quantities_have_units(text: str, unit: str) -> None:
    assert quantity_of(text).unit(("mm", "g", "ms")) == unit
    assert quantity_of(text).unit(("", "", "")) == ("g" if unit == "g" else "")
