"""A small case, and the command line run in this process."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from contiga.cli import commands

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


class Command:
    """Runs ``contiga …`` in this process."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        self._patch, self._capture = monkeypatch, capsys

    def __call__(self, *arguments: object) -> tuple[int, str, str]:
        """Exit code, standard output, error output."""
        self._patch.setattr(sys, "argv", ["contiga", *map(str, arguments)])
        code = 0
        try:
            commands.main()
        except SystemExit as left:
            code = int(left.code or 0)
        out, err = self._capture.readouterr()
        return code, out, err


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    monkeypatch.delenv("CONTIGA_DEBUG", raising=False)
    return Command(monkeypatch, capsys)


def one_message(err: str) -> str:
    """The error message, which must be the only line and no traceback."""
    lines = err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("contiga: error: ")
    return lines[0]
