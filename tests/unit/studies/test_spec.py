"""The study file: what is wrong with it is said in one message, with key and remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.errors import CaseError, FileError, InputError
from contiga.studies.spec import load_study

from .conftest import STUDY, study_from

STEP = 'key = "time.step"\nvalues = [0.5, 0.25]'
GOAL = 'goal = { minimise = "max(force)", trials = 3 }\n'


def test_the_study_is_read(folder: Path) -> None:
    study = load_study(folder / "study.toml")
    assert study.labels == ["speed", "step"]
    assert list(study.quantities) == ["max(force)", "at(ball.vz, 2)", "cg.HIC15"]
    assert study.base == (folder / "case.toml").resolve().as_posix()


def test_quantities_may_have_names_and_the_goal_brings_its_own(folder: Path) -> None:
    text = STUDY.replace('["max(force)", "at(ball.vz, 2)", "cg.HIC15"]', '{ F = "max(force)" }')
    text = 'goal = { maximise = "steps", subject_to = ["max(force) <= 1e3"] }\n' + text
    study = study_from(text, folder)
    assert {name: q.text for name, q in study.quantities.items()} == {
        "F": "max(force)",
        "steps": "steps",
        "max(force)": "max(force)",
    }
    assert study.goal is not None
    (limit,) = study.goal.limits
    assert (limit.quantity, limit.is_upper, limit.bound) == ("max(force)", True, 1000.0)
    assert (limit.excess(1200.0), limit.excess(900.0)) == (200.0, -100.0)


@pytest.mark.parametrize(
    ("old", "new", "pieces"),
    [
        ("collect", "colect", ["colect", "unknown key", "Did you mean 'collect'"]),
        ("values = [-1", "value = [-1", ["variable[0].value", "unknown key", "'values'"]),
        ('base = "case.toml"', 'base = "cas.toml"', ["base", "no such file"]),
        ('base = "case.toml"', "", ["base", "is missing"]),
        ('"max(force)", ', '"maxi(force)", ', ["cannot be collected", "'max'"]),
        ('["max(force)", "at(ball.vz, 2)", "cg.HIC15"]', "[]", ["collect"]),
        (STEP, 'key = "time.step"', ["step", "exactly one way", "none"]),
        (STEP, f"{STEP}\nlow = 0.1\nhigh = 0.5", ["exactly one way", "values, low and high"]),
        (STEP, 'key = "time.step"\nlow = 0.5', ["must go from low to high"]),
        (STEP, 'key = "time.step"\nlow = 0.5\nhigh = 0.5\ncount = 3', ["from low to high"]),
        (STEP, 'key = "time.step"\nlow = 0.1\nhigh = 0.5', ["sampled", "count = …"]),
        (STEP, 'key = "a"\nlow = -1.0\nhigh = 1.0\ncount = 3\nscale = "log"', ["above zero"]),
        (STEP, f"{STEP}\ncount = 3", ["for low and high"]),
        (STEP, 'key = "time.step"\ncolumn = "a"', ["table", "is missing"]),
        (STEP, "values = [1]", ["no key and no rule uses this variable", "'step'"]),
        ('name = "step"', 'name = "speed"', ["two columns", "'speed'"]),
        ('name = "step"', 'name = "status"', ["two columns", "'status'"]),
        ('name = "step"', 'name = "time step"', ["is not a name"]),
        ("[[variable]]", 'sample = { kind = "sobol", count = 4 }\n[[variable]]', ["sample"]),
        (STEP, 'key = "a"\nlow = 0.1\nhigh = 1.0\ncount = 1000000000', ["count: is too large"]),
        (
            STEP,
            'key = "a"\nlow = 0.1\nhigh = 1.0\n[sample]\nkind = "sobol"\ncount = 1000000000',
            ["sample.count: is too large", "<= 1e+06"],
        ),
        ("[[variable]]", "retries = -1\n[[variable]]", ["retries", "too small"]),
        (STEP, f'{STEP}\n[[rule]]\nkey = "a"', ["rule[0]", "sets a key, or requires"]),
        (STEP, f'{STEP}\n[[rule]]\nrequire = "stepp > 1"', ["rule[0].require", "'step'"]),
        (
            STEP,
            f'{STEP}\n[[rule]]\nrequire = "import os"',
            ["rule[0].require", "not an expression"],
        ),
        ("base", 'map = { body = "b", at = ["speed", "step", "z"] }\nbase', ["map.at", "'z'"]),
        ("base", f'{GOAL}sample = {{ kind = "sobol", count = 4 }}\nbase', ["optimiser chooses"]),
        ("base", "goal = { trials = 3 }\nbase", ["goal", "one quantity"]),
        (
            "base",
            GOAL.replace("}", ', subject_to = ["max(force) = 3"] }') + "base",
            ["not a limit"],
        ),
        ("base", "= 3", ["is not valid TOML"]),
    ],
)
def test_what_is_wrong_is_told(old: str, new: str, pieces: list[str], folder: Path) -> None:
    assert old in STUDY
    path = folder / "study.toml"
    path.write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_study(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    for piece in pieces:
        assert piece in message
    assert "pydantic" not in message
    assert caught.value.exit_code == 2


def test_a_goal_leaves_no_case_out(folder: Path) -> None:
    with pytest.raises(CaseError, match="none can be left out"):
        study_from(GOAL + STUDY + '[[rule]]\nrequire = "speed < 0"\n', folder)


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        load_study(tmp_path / "gone.toml")
    with pytest.raises(FileError, match="cannot be read"):
        load_study(tmp_path)


def test_a_case_is_no_study(folder: Path) -> None:
    with pytest.raises(CaseError, match=r'is a case, not a study.*base = "case.toml".*contiga run'):
        load_study(folder / "case.toml")
