"""``contiga export``: channels of a run as files of ISO-MME, and bands of its criteria."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import Command, one_message

CASE = """
units = { length = "mm", mass = "kg", time = "ms" }
time = { end = 40.0, step = 0.1 }
output = { formats = ["csv"], report = false }
[[body]]
name = "head"
geometry = { shape = "sphere", radius = 10.0 }
motion = { kind = "acceleration", direction = "x", table = [[0, 0], [20, 0.4], [40, 0]] }
[[slave]]
name = "far"
points = { coordinates = [[0, 15, 0]] }
area = 1.0
[[contact]]
master = "head"
slave = "far"
law = { kind = "penalty", stiffness = 1.0 }
[[sensor]]
name = "head_cg"
body = "head"
measures = ["acceleration"]
filter = "CFC1000"
criteria = ["HIC15"]
bands = { HIC15 = { limits = [1.0, 1000.0], names = ["green", "yellow", "red"] } }
code = "11HEAD0000H3"
"""


@pytest.fixture
def run(command: Command, tmp_path: Path) -> tuple[Path, str]:
    (tmp_path / "sled.toml").write_text(CASE, encoding="utf-8")
    code, out, err = command("run", tmp_path / "sled.toml", "-o", tmp_path / "T17")
    assert code == 0, err
    return tmp_path / "T17", out


def test_channels_of_a_run(command: Command, run: tuple[Path, str], tmp_path: Path) -> None:
    folder, said = run
    assert "(yellow), t = " in said
    assert " ms" in next(line for line in said.splitlines() if "HIC15" in line)
    code, out, _ = command("export", folder, "-o", tmp_path / "tests")
    assert (code, out.split()[-2:]) == (0, ["8", "channels"])
    text = (tmp_path / "tests" / "T17" / "Channel" / "T17.001").read_text(encoding="utf-8")
    assert "Channel code                :11HEAD0000H3ACX0" in text
    # 0.4 mm/ms² is 400 m/s².
    assert max(float(line) for line in text.splitlines() if ":" not in line) == pytest.approx(400.0)
    listed = (tmp_path / "tests" / "T17" / "Channel" / "T17.chn").read_text(encoding="utf-8")
    assert "11HEAD0000H3ACXA / head_cg filtered_ax" in listed
    assert command("export", folder)[0] == 0
    assert (folder / "iso_mme" / "T17" / "T17.mme").is_file()
    code, _, err = command("export", folder, "-o", tmp_path / "tests")
    assert code == 2
    assert "a new folder" in one_message(err)


def test_a_folder_without_a_run_is_one_message(command: Command, tmp_path: Path) -> None:
    code, out, err = command("export", tmp_path)
    assert (code, out) == (2, "")
    one_message(err)


def test_wrong_bands_name_their_key(command: Command, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE.replace("1000.0]", "0.5]"), encoding="utf-8")
    code, _, err = command("check", case)
    assert code == 2
    assert "sensor[0].bands.HIC15.limits: must rise" in one_message(err)
