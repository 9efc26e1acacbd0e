"""``contiga study``: what it prints, where it writes, what it says of wrong input."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import CASE, Command, one_message

STUDY = """
title = "Ball over sheet"
base = "case.toml"
collect = ["steps", "max(force)"]
set = { "output.report" = false, "output.formats" = ["csv"] }
[[variable]]
name = "step"
key = "time.step"
values = [0.5, 0.25]
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """The file of a small study."""
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    return path


def test_a_study_is_run_and_gone_on_with(study: Path, command: Command) -> None:
    code, out, _ = command("study", study, "--workers", "0")
    folder = study.parent / "study_out"
    assert code == 0
    assert out == f"2 cases, 0 failed\npage: {folder / 'study.html'}\n"
    (folder / "cases" / "0002" / "row.json").unlink()
    code, _, error = command("study", study, "--workers", "0")
    assert code == 2
    assert "holds a study already" in error
    code, out, _ = command("study", study, "--workers", "0", "--resume", "--quiet")
    assert (code, out) == (0, "")
    assert (folder / "cases" / "0002" / "row.json").is_file()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("time.step", "time.stp", "unknown key"),
        ("values", "vlues", "Did you mean 'values'"),
        ("max(force)", "max(fource)", "Did you mean 'force'"),
    ],
)
def test_wrong_input_is_one_message(
    old: str, new: str, said: str, study: Path, command: Command
) -> None:
    study.write_text(STUDY.replace(old, new), encoding="utf-8")
    code, out, error = command("study", study, "--workers", "0")
    assert (code, out) == (2, "")
    assert said in one_message(error)
    assert not (study.parent / "study_out").exists()
