"""``contiga film``: where the film is, and one message where there is none."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from .conftest import NO_REPORT, Command, one_message


def test_a_film_of_a_run_is_written_and_said(command: Command, case: Path, tmp_path: Path) -> None:
    case.write_text(case.read_text(encoding="utf-8") + NO_REPORT, encoding="utf-8")
    command("run", case, "-o", tmp_path / "out", "--quiet")
    film = tmp_path / "film.gif"
    code, out, _ = command("film", tmp_path / "out", "-o", film, "--seconds", "0.2")
    assert (code, out) == (0, f"film: {film}\n")
    assert film.read_bytes().startswith(b"GIF89a")


def test_without_an_encoder_one_message_says_what_to_install(
    command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    code, out, err = command("film", tmp_path, "--quiet")
    assert (code, out) == (2, "")
    assert "contiga[film]" in one_message(err)
    assert list(tmp_path.iterdir()) == []
