"""Cases of springs and loads alone: all that others have, and nothing about contacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contiga.io.out.history import read_history

from .conftest import Command

SWING = """
title = "A mass on a coil"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 12.0, step = 0.1 }
[[body]]
name = "mass"
geometry = { shape = "sphere", radius = 20.0 }
mass = { total = 1000.0, centre = [0, 0, 0], inertia = [1.6e5, 1.6e5, 1.6e5, 0, 0, 0] }
motion = { kind = "free", velocity = [0, 0, 2.0] }
[[spring]]
name = "coil"
between = ["mass", "ground"]
at = [[0, 0, 0], [0, 0, 200]]
curve = 250.0
[[sensor]]
name = "cg"
body = "mass"
"""


def test_springs_alone_need_no_contact(command: Command, tmp_path: Path) -> None:
    path, out = tmp_path / "swing.toml", tmp_path / "out"
    path.write_text(SWING, encoding="utf-8")
    assert command("check", path, "--strict")[0] == 0
    assert command("run", path, "-o", out, "--strict")[0] == 0
    history = read_history(out / "history.csv")
    np.testing.assert_allclose(
        history["coil.elongation"], -2.0 / 0.5 * np.sin(0.5 * history["time"]), atol=5e-3
    )
    assert (out / "fields.vtkhdf").is_file()
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Largest force" in page
    for word in ("Peak force", "Deepest penetration", "No point came into contact", "in contact."):
        assert word not in page
    assert command("run", path, "-o", out, "--resume", "--set", "time.end=14.0")[0] == 0
    assert len(read_history(out / "history.csv")["time"]) == 141


LOOP = """
title = "A four-bar in a plane, let go"
units = { length = "m", mass = "kg", time = "s" }
time = { end = 0.02, step = 1e-3 }
world = { gravity = [0, 0, -9.81] }
[[body]]
name = "crank"
geometry = { shape = "ellipsoid", axes = [0.05, 0.05, 0.5], centre = [0, 0, 0.5] }
mass = { total = 1.0 }
motion = { kind = "free" }
[[body]]
name = "coupler"
geometry = { shape = "ellipsoid", axes = [1.0, 0.05, 0.05], centre = [1, 0, 1] }
mass = { total = 2.0 }
motion = { kind = "free" }
[[body]]
name = "rocker"
geometry = { shape = "ellipsoid", axes = [0.05, 0.05, 0.5], centre = [2, 0, 0.5] }
mass = { total = 1.0 }
motion = { kind = "free" }
""" + "".join(
    f'[[joint]]\nkind = "revolute"\naxis = [0, 1, 0]\nbetween = {between}\nat = {at}\n'
    for between, at in (
        ('["ground", "crank"]', "[0, 0, 0]"),
        ('["crank", "coupler"]', "[0, 0, 1]"),
        ('["coupler", "rocker"]', "[2, 0, 1]"),
        ('["rocker", "ground"]', "[2, 0, 0]"),
    )
)


def test_a_planar_loop_of_revolute_joints_is_sound_and_has_a_note(
    command: Command, tmp_path: Path
) -> None:
    path, out = tmp_path / "loop.toml", tmp_path / "out"
    path.write_text(LOOP, encoding="utf-8")
    code, told, _ = command("check", path, "--strict")
    assert code == 0
    assert "note: joints ground-crank" in told
    assert "3 of their constraints" in told
    assert "warning" not in told
    assert command("run", path, "-o", out, "--strict")[0] == 0


def test_a_case_of_nothing_is_one_message(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "nothing.toml"
    path.write_text(SWING.replace('kind = "free", velocity = [0, 0, 2.0]', 'kind = "fixed"'))
    code, out, err = command("run", path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "contact: nothing can happen: there is no contact, and nothing that forces move" in err
