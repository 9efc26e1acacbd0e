"""Meshes that are flawed, or of quadrilaterals and solids, as masters: what each command says."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.command import Command

CASE = """
title = "Crate"
units = { length = "m", mass = "kg", time = "s" }
time = { end = 1.0, step = 0.5 }
[[body]]
name = "crate"
geometry = { mesh = "crate.vtu" }
[[slave]]
name = "pad"
points = { coordinates = [[0.4, 0.3, 2.0]] }
area = 1.0
motion = { kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -1.2]] }
[[contact]]
master = "crate"
slave = "pad"
law = { kind = "penalty", stiffness = 1.0 }
[output]
report = false
formats = []
"""

CORNERS = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
QUADS = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
BOX = [t for a, b, c, d in QUADS for t in ([a, b, c], [a, c, d])]
FAR = [*CORNERS.tolist(), [0.5, 0.5, 5.0]]
CLOSED = "closed, volume 1"

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Run:
    """Runs a command in a folder with the case: exit code, output, errors; lines joined."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE, encoding="utf-8")

    contiga = Command(monkeypatch, capsys)

    def run(*arguments: str) -> tuple[int, str, str]:
        code, out, err = contiga(*arguments)
        return code, " ".join(out.split()), err

    return run


def write(points: object, **cells: object) -> None:
    """The mesh of the case."""
    made = {kind: np.array(rows) for kind, rows in cells.items()}
    meshio.write("crate.vtu", meshio.Mesh(np.array(points), made))


# Name: points, triangles, what `info` says, peak force of a pad that comes 0.2 deep.
SERVED = {
    "whole": (CORNERS, BOX, CLOSED, 0.2),
    "open": (CORNERS, BOX[1:], "open, 3 edges of one triangle", 0.2),
    "corners in a point": (CORNERS, [*BOX, [0, 1, 1]], "1 given twice or folded flat left", 0.2),
    "corners on a line": (
        [*CORNERS, [0.5, 0, 0]],
        [*BOX, [0, 8, 1]],
        "1 triangles without area take no part",
        0.2,
    ),
    "given twice": (CORNERS, [*BOX, BOX[2]], "1 given twice or folded flat left out", 0.2),
    "back to back": (CORNERS, [*BOX, BOX[2][::-1]], "1 given twice or folded flat left out", 0.2),
    "nodes of no triangle": (FAR, BOX, "1 nodes of no triangle take no part", 0.2),
    "not a manifold": (FAR, [*BOX, [4, 5, 8]], "1 edges of more than two triangles", 0.2),
    "inward": (CORNERS, [t[::-1] for t in BOX], "closed, volume -1 m³, normals inward", 0.0),
}


@pytest.mark.parametrize("name", SERVED)
def test_flaws_that_can_be_lived_with_are_said_and_served(command: Run, name: str) -> None:
    points, triangles, said, force = SERVED[name]
    write(points, triangle=triangles)
    code, out, err = command("info", "crate.vtu")
    assert (code, err) == (0, "")
    assert said.replace(" m³", "") in out  # the file says no unit
    code, out, err = command("check", "case.toml")
    assert (code, err) == (0, "")
    assert name == "nodes of no triangle" or said in out
    code, out, err = command("run", "case.toml", "-o", "out")
    assert (code, "error" in err) == (0, False)
    assert f"peak force {force:g} N at" in out


REFUSED = {
    "one inverted": (CORNERS, [BOX[0], BOX[1][::-1], *BOX[2:]], "opposite ways.*orient = true"),
    "all on a line": (2 * [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], "none of the triangles"),
    "all in a point": (CORNERS, [[0, 1, 1], [2, 3, 3]], "have no surface"),
    "not finite": ([[np.nan, 0, 0], *CORNERS[1:]], BOX, "not finite"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_meshes_without_sides_are_refused_with_one_message(command: Run, name: str) -> None:
    points, triangles, message = REFUSED[name]
    write(points, triangle=triangles)
    for arguments in (["check", "case.toml"], ["run", "case.toml", "-o", "out", "--quiet"]):
        code, out, err = command(*arguments)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert re.match(rf"contiga: error: case\.toml: body\[0\]\.geometry.*{message}", err)
    assert sorted(path.name for path in Path().iterdir()) == ["case.toml", "crate.vtu"]


def test_turned_triangles_are_told_by_info_and_mended_by_orient(command: Run) -> None:
    write(CORNERS, triangle=REFUSED["one inverted"][1])
    code, out, _ = command("info", "crate.vtu")
    assert code == 0
    assert "3 edges with triangles that face opposite ways: no master unless orient = true" in out
    case = CASE.replace('"crate.vtu"', '"crate.vtu", orient = true')
    Path("case.toml").write_text(case, encoding="utf-8")
    assert CLOSED in command("check", "case.toml")[1]


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        ({"quad": QUADS}, "12 of 6 quad split"),
        ({"hexahedron": [[0, 1, 3, 2, 4, 5, 7, 6]]}, "12 of 1 hexahedron skinned"),
        ({"quad": QUADS[1:], "triangle": BOX[:2]}, "12 of 5 quad split, 2 triangle"),
    ],
)
def test_quadrilaterals_are_split_and_solids_skinned_and_it_is_said(
    command: Run, cells: dict[str, object], said: str
) -> None:
    write(CORNERS, **cells)
    for arguments in (["info", "crate.vtu"], ["check", "case.toml"]):
        out = command(*arguments)[1]
        assert said in out
        assert CLOSED in out
    assert command("run", "case.toml", "-o", "out")[0] == 0
    summary = json.loads(Path("out/summary.json").read_text(encoding="utf-8"))
    assert said.endswith(summary["inputs"]["crate"]["source"])
