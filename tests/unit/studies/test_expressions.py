"""Arithmetic of rules: what it comes to, and what it refuses."""

from __future__ import annotations

import math

import pytest

from contiga.errors import CaseError
from contiga.studies.expressions import Expression


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3 - 4 / 8", 6.5),
        ("-speed * sin(radians(angle))", -6.0 * math.sin(math.radians(65.0))),
        ("(speed - 1) ** 2 % 7", 4.0),
        ("hypot(3, 4) + min(1, 2) + max(1, 2) + abs(-1)", 9.0),
        ("2 * pi", math.tau),
        ("int(7.9)", 7),
    ],
)
def test_expressions_are_worked_out(text: str, value: float) -> None:
    assert Expression(text, "rule").value({"speed": 6.0, "angle": 65.0}) == pytest.approx(
        value, rel=1e-15
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("speed > 5 and angle <= 65", True),
        ("speed < 5 or not angle == 65", False),
        ("1 < speed < 7", True),
        ("1 < speed < 6", False),
        ("shape != 'torus'", True),
    ],
)
def test_requirements_are_told(text: str, told: bool) -> None:
    names = {"speed": 6.0, "angle": 65.0, "shape": "sphere"}
    assert Expression(text, "rule").value(names) is told


@pytest.mark.parametrize(
    "text",
    [
        *("", "1 +", "speed = 3", "[1, 2]", "x.real", "x[0]", "lambda: 1", "1 if x else 2"),
        *("open('x')", "__import__('os')", "(1).__class__", "min(key=1)", "x @ y", "1 << 9"),
        *("sin", "f'{x}'", "1 in x", "(y := 3)", "9" * 600),
    ],
)
def test_nothing_but_arithmetic_is_an_expression(text: str) -> None:
    if text == "sin":  # a function is no value
        with pytest.raises(CaseError, match="no variable is called 'sin'"):
            Expression(text, "rule").check_names(["speed"])
        return
    with pytest.raises(CaseError) as caught:
        Expression(text, "rule[0].value")
    assert "rule[0].value" in str(caught.value)


def test_an_unknown_name_is_told_with_the_closest() -> None:
    with pytest.raises(CaseError, match=r"no variable is called 'sped'.*Did you mean 'speed'"):
        Expression("2 * sped", "rule").check_names(["speed", "angle"])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1 / (speed - 6)", "division by zero"),
        ("sqrt(-speed)", "domain|negative"),
        ("name + 1", "str"),
        ("9.0 ** 9 ** 9", "too large|out of range"),
    ],
)
def test_what_cannot_be_worked_out_says_with_which_values(text: str, why: str) -> None:
    with pytest.raises(CaseError, match=why) as caught:
        Expression(text, "rule").value({"speed": 6.0, "name": "a"})
    assert text in str(caught.value)
