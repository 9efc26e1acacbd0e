"""Settings over a case: keys that lead to their place, and one message for those that do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.case.schema import load_case, parse_case
from contiga.case.settings import parse_settings, with_settings
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError, InputError

from .conftest import GOOD


def test_settings_reach_tables_lists_and_names(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(GOOD, encoding="utf-8")
    case = load_case(
        path,
        set={
            "time.end": 10,
            "slave.cylinder.motion.table[1]": np.array([13.0, 0.0, 0.0, -2.0]),
            "contact.plate-cylinder.law.curve.1.1": np.float64(0.75),
            "contact[0].area.value": 0.2,
            "world.gravity": (0, 0, -1),
            "body.0.geometry.waves": 2,
        },
    )
    assert case.time.end == 10.0
    assert case.slave[0].motion.table[1] == [13.0, 0.0, 0.0, -2.0]
    assert case.contact[0].law.curve.points == [[0.0, 0.0], [1.0, 0.75]]
    assert case.contact[0].area.value == 0.2
    assert case.world.gravity == [0.0, 0.0, -1.0]
    assert case.body[0].geometry.model_extra["waves"] == 2
    text = resolved_toml(case)
    assert "end = 10.0" in text
    assert resolved_toml(parse_case(text)) == text, "the copy of the case says what was set"
    assert load_case(path).time.end == 13.0


def test_the_case_itself_stays_as_it_is() -> None:
    data = {"time": {"end": 1.0}, "body": [{"name": "a", "motion": {"table": [[0, 1]]}}]}
    changed = with_settings(data, {"body.a.motion.table[0][1]": 5, "output.every": 3})
    assert changed["body"][0]["motion"]["table"] == [[0, 5]]
    assert changed["output"] == {"every": 3}
    assert data == {"time": {"end": 1.0}, "body": [{"name": "a", "motion": {"table": [[0, 1]]}}]}


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("time.end=20", "time.end", 20),
        (" a = [1, 2.5] ", "a", [1, 2.5]),
        ("a=true", "a", True),
        ('a="x = y"', "a", "x = y"),
        ("a={ kind = 'fixed' }", "a", {"kind": "fixed"}),
        ("time.step=auto", "time.step", "auto"),
        ("a.file=parts/head-2.step", "a.file", "parts/head-2.step"),
    ],
)
def test_values_are_those_of_toml_or_words(text: str, key: str, value: object) -> None:
    assert parse_settings([text]) == {key: value}


@pytest.mark.parametrize(
    ("texts", "pieces"),
    [
        (["time.end"], ("--set", "KEY=VALUE", "'time.end'")),
        (["=3"], ("KEY=VALUE",)),
        (["a=1,5"], ("--set a", "not a value of TOML", "'1,5'")),
        (["a=[1, 2"], ("--set a", "not a value of TOML")),
        (["a=1\nb=2"], ("--set a", "single value")),
        (["a=1", "a=2"], ("--set a", "set twice")),
    ],
)
def test_texts_that_are_no_settings(texts: list[str], pieces: tuple[str, ...]) -> None:
    with pytest.raises(CaseError) as caught:
        parse_settings(texts)
    for piece in pieces:
        assert piece in str(caught.value)


@pytest.mark.parametrize(
    ("key", "value", "pieces"),
    [
        ("time.ende", 3, ("time.ende: unknown key", "Did you mean 'end'?")),
        ("tme.end", 3, ("tme: unknown key", "Did you mean 'time'?")),
        ("body.plat.motion.kind", "fixed", ("'plat'", "plate, body[0]", "Did you mean 'plate'?")),
        ("body[1].name", "x", ("no such entry of body", "found '1'", "body[0]")),
        ("time.end.x", 3, ("not a table", "time.end", "13.0")),
        ("time.end", "late", ("time.end", "number", "'late'")),
        ("contact[0].law.curve.5", [2, 3], ("no such entry", "'5'", "curve[0] to ")),
        ("body..x", 3, ("not a key of a case", "'body..x'")),
        ("", 3, ("not a key of a case",)),
    ],
)
def test_keys_that_lead_nowhere(key: str, value: object, pieces: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        parse_case(GOOD, set={key: value})
    for piece in pieces:
        assert piece in str(caught.value)
    assert caught.value.exit_code == 2
