"""Settings of the command line over a case."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import CASE, Command, one_message


def test_settings_stand_over_the_case_and_in_its_copy(command: Command, case: Path) -> None:
    out = case.parent / "set"
    settings = ["--set", "time.end=1.5", "--set", "body.ball.geometry.radius=10.5"]
    code, text, _ = command("check", case, *settings)
    assert code == 0
    assert "3 steps" in text
    assert "radius = 10.5" in text
    options = [*settings, "--set", "output.report=false", "--quiet"]
    assert command("run", case, "-o", out, *options) == (0, "", "")
    copy = (out / "case.toml").read_text(encoding="utf-8")
    assert "end = 1.5" in copy
    assert "radius = 10.5" in copy
    assert case.read_text(encoding="utf-8") == CASE


@pytest.mark.parametrize("name", ["run", "check", "preview"])
def test_check_alone_goes_on_behind_wrong_tables(command: Command, case: Path, name: str) -> None:
    (case.parent / "ball.stl").write_text("solid nothing\n", encoding="utf-8")
    text = CASE.replace('shape = "sphere", radius = 10.0', 'mesh = "ball.stl"')
    case.write_text(
        text + "[[sensor]]\nname = 's'\nbody = 'ball'\naxis = 'body'\n", encoding="utf-8"
    )
    out = () if name == "check" else ("-o", case.parent / "out.png")
    code, _, err = command(name, case, *out)
    assert code == 2
    assert "sensor[0].axis: unknown key" in err
    assert ("body[0].geometry" in err) == (name == "check")


@pytest.mark.parametrize("name", ["run", "check"])
@pytest.mark.parametrize(
    ("setting", "piece"),
    [
        ("time.ende=3", "Did you mean 'end'?"),
        ("body.bal.name=x", "Did you mean 'ball'?"),
        ("time.end", "KEY=VALUE"),
    ],
)
def test_a_wrong_setting_is_one_message(
    command: Command, case: Path, name: str, setting: str, piece: str
) -> None:
    code, out, err = command(name, case, "--set", setting)
    assert (code, out) == (2, "")
    assert piece in one_message(err)
    assert list(case.parent.iterdir()) == [case]
