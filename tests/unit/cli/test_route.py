"""`contiga route`: paths over files and of cases, their picture, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.unit.case.test_belt_spec import case
from typer.testing import CliRunner

import contiga as cg
from contiga.cli.commands import app

ENDS = ("--from=-2,0,0", "--to=2,0,0", "--via=0,0,1.5")


def words(*arguments: object) -> tuple[int, str]:
    """Exit code and output of the command."""
    result = CliRunner().invoke(app, ["route", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    mesh = cg.Body([cg.shapes.sphere(radius=1.0)]).tessellate(1e-3)
    return cg.write_mesh(tmp_path / "ball.stl", mesh) or tmp_path / "ball.stl"


def test_length_and_wrap_of_a_path_over_a_file_are_printed(ball: Path) -> None:
    code, text = words(ball, *ENDS)
    assert code == 0
    length = float(text.split("length ")[1].split(",")[0])
    assert abs(length / (2.0 * np.sqrt(3.0) + np.pi / 3.0) - 1.0) < 2e-3
    assert "on ball" in text
    assert "turns by" in text


def test_belts_of_a_case_are_drawn(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(case())
    code, text = words(file, "-o", tmp_path / "belts.png")
    assert code == 0
    assert text.startswith("strap: length 451.1")
    assert "60°" in text
    assert (tmp_path / "belts.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--from=-2,0", "--to=2,0,0"), "--from"),
        (("--from=-2,0,0",), "--to"),
        ((*ENDS, "-o", "path.svg"), "a picture of paths"),
        (("--from=0,0,0", "--to=2,0,0"), "inside"),
    ],
)
def test_what_is_asked_wrongly_is_said(ball: Path, arguments: tuple[str, ...], said: str) -> None:
    with pytest.raises(cg.errors.InputError, match=said):
        words(ball, *arguments)


def test_a_case_without_belts_or_with_ends_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(case())
    with pytest.raises(cg.errors.InputError, match="says itself"):
        words(file, *ENDS)
    with pytest.raises(cg.errors.FileError, match="no such file"):
        words(tmp_path / "none.step", *ENDS)
