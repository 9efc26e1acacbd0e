"""The tutorial as a new user does it: its programs and commands, in an empty folder."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

TUTORIAL = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "draw_tutorial.py"))


def test_the_tutorial_leaves_the_files_and_numbers_that_it_tells_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = TUTORIAL["PAGE"].read_text(encoding="utf-8")
    first_run, _ = page.split("## 8. ")
    TUTORIAL["follow"](tmp_path, first_run)
    printed = re.sub("[\u202f\u2009\xa0]", " ", capsys.readouterr().out).splitlines()
    matches = re.findall(r"^print\(.*#\s*(.+)$", first_run, re.M)
    assert len(matches) == 3
    assert [line for line in printed if line in matches] == matches
    run = re.search(r"```text\n(.*?)```", first_run, re.S)
    assert run is not None
    steps, *answers = run.group(1).splitlines()
    assert steps.split(" in ")[0] in " ".join(printed)
    assert [line for line in answers if line not in printed] == []
    assert "impact.toml is ready to run" in printed
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")}
    named = set(re.findall(r"`(out/[\w.]+)`", first_run)) | {"force.png", "preview.png"}
    assert len(named) > 5
    assert named - left == set()
