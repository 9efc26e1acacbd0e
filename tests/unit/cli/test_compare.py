"""``contiga compare``: what it prints, and its page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .conftest import NO_REPORT, Command, one_message


def test_two_runs_are_set_beside_each_other(command: Command, case: Path, tmp_path: Path) -> None:
    case.write_text(case.read_text(encoding="utf-8") + NO_REPORT, encoding="utf-8")
    law = "contact[0].law.curve.1=[1, 20]"
    command("run", case, "-o", tmp_path / "a", "--quiet")
    command("run", case, "-o", tmp_path / "b", "--set", law, "--quiet")
    page = tmp_path / "both.html"
    code, out, err = command("compare", tmp_path / "a", tmp_path / "b", "-o", page)
    assert (code, err) == (0, "")
    assert (
        "contact[0].law.curve.points: [[0.0, 0.0], [1.0, 10.0]] → [[0.0, 0.0], [1.0, 20.0]]" in out
    )
    assert "ball-sheet.force: peak 10 → 20 N, largest difference 50 % at t = 1 ms" in out
    assert "steps: 4 → 4" in out
    assert f"page: {page}" in out
    assert page.is_file()
    code, out, _ = command("compare", tmp_path / "a", tmp_path / "a")
    assert code == 0
    assert "no setting differs" in out
    assert "largest difference none" in out


def test_criteria_have_their_units(command: Command, case: Path, tmp_path: Path) -> None:
    case.write_text(case.read_text(encoding="utf-8") + NO_REPORT, encoding="utf-8")
    command("run", case, "-o", tmp_path / "a", "--quiet")
    file = tmp_path / "a" / "summary.json"
    found = {"value": 19.5, "unit": "g", "start": 0.0, "end": 3.0}
    sensors = {"cg": {"criteria": {"3ms": found}}}
    summary = json.loads(file.read_text(encoding="utf-8")) | {"sensors": sensors}
    file.write_text(json.dumps(summary), encoding="utf-8")
    _, out, _ = command("compare", tmp_path / "a", tmp_path / "a")
    assert "cg: 3ms [g]: 19.5 → 19.5" in out.splitlines()


@pytest.mark.parametrize("name", ["nowhere", "empty"])
def test_a_wrong_folder_is_one_message(command: Command, tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    code, out, err = command("compare", tmp_path / name, tmp_path / name, "-o", tmp_path / "p.html")
    assert (code, out) == (2, "")
    assert name in one_message(err)
    assert not (tmp_path / "p.html").exists()


def test_a_wrong_number_of_runs_and_a_page_that_is_none_are_refused(
    command: Command, tmp_path: Path
) -> None:
    code, _, err = command("compare", tmp_path)
    assert code == 2
    assert "DIR: the wrong number of runs; found 1; allowed: 2 to 20" in one_message(err)
    code, out, err = command("compare", tmp_path, tmp_path, "-o", tmp_path / "p.png")
    assert (code, out) == (2, "")
    assert "p.png: the file has another suffix than its format" in one_message(err)
