"""A small case, and the command line run in this process."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command import Command as Command

CASE = """
title = "Ball and sheet"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 2.0, step = 0.5 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0 }
motion = { kind = "translate", table = [[0, 0, 0, 11], [1, 0, 0, 9], [2, 0, 0, 11]] }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 9, nv = 9 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "force", curve = [[0, 0], [1, 10]] }
"""

NO_REPORT = "\n[output]\nreport = false\n"


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "press.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(monkeypatch, capsys)


def one_message(err: str) -> str:
    """The error message, which must be the only line and no traceback."""
    lines = err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("contiga: error: ")
    return lines[0]
