"""`[settle]` of a case and `contiga run --settle-only`."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from .conftest import NO_REPORT, Command, one_message

CLOTH = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.05, step = 0.01 }
world = { gravity = [0, 0, -0.01] }
settle = { tolerance = 0.01 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0, centre = [0, 0, -50] }
[[slave]]
name = "cloth"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 } }
[slave.motion]
kind = "deform"
material = { kind = "elastic", young = 1.0, compression = false }
density = 1.0e-3
thickness = 0.5
fixed = [{ plane = [[-10, 0, 0], [1, 0, 0]] }, { plane = [[10, 0, 0], [1, 0, 0]] }]
"""


def test_a_cloth_sags_before_the_run(command: Command, tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    path = tmp_path / "cloth.toml"
    path.write_text(CLOTH + NO_REPORT)
    code, out, _ = command("run", path, "-o", tmp_path / "out", "--settle-only")
    assert code == 0
    assert "settled in " in out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["steps"] == 0
    assert summary["settled"]["residual"] <= 0.01
    assert command("run", path, "-o", tmp_path / "out", "--resume", "--quiet")[0] == 0
    went_on = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert went_on["settled"] == summary["settled"]
    assert went_on["steps"] > 0
    assert "settles" in command("check", path)[1]


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        (
            '{ bodies = ["bal"] }',
            r"bodies\[0\]: no body of this name .* Did you mean 'ball'",
        ),
        ('{ bodies = ["ball"] }', "is not free"),
        ("{ tolerance = -1 }", "settle.tolerance"),
        ("{ tolerence = 1 }", "Did you mean 'tolerance'"),
    ],
)
def test_what_is_wrong_with_it_is_one_message(
    command: Command, tmp_path: Path, changed: str, text: str
) -> None:
    path = tmp_path / "cloth.toml"
    path.write_text(CLOTH.replace("{ tolerance = 0.01 }", changed))
    code, _, err = command("check", path)
    assert code == 2
    assert re.search(text, one_message(err))


def test_what_deforms_needs_neither_body_nor_contact(command: Command, tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    body, rest = CLOTH.split("[[body]]")[1].split("[[slave]]")
    path = tmp_path / "cloth.toml"
    path.write_text(CLOTH.replace(f"[[body]]{body}", "") + NO_REPORT)
    assert rest in path.read_text()
    code, out, _ = command("check", path)
    assert code == 0
    assert "warning" not in out
    assert command("run", path, "-o", tmp_path / "out", "--settle-only", "--quiet")[0] == 0
    assert command("run", path, "-o", tmp_path / "out", "--resume", "--quiet")[0] == 0
    path.write_text(CLOTH.split("[[body]]")[0].replace("settle = { tolerance = 0.01 }", ""))
    assert "body: is missing" in one_message(command("check", path)[2])
