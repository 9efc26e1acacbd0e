"""Every command ends well in encodings that lack its signs, and writes plain ones for them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest
from tests.decks import CONTACT, END, FOAM, FULL, RIGID, deck

from contiga.cli import main
from contiga.cli.plain_signs import plain

from .test_study import STUDY

ENCODINGS = ("cp1252", "latin-1", "ascii")
CASE = """
title = "Ball über foam ² → ω"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.04, step = 0.004 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 20.0, centre = [0, 0, 19.9] }
mass = { density = 7.8e-3 }
motion = { kind = "free", velocity = [0.3, 0, -3.0] }
[[slave]]
name = "foam"
points = { grid = { shape = "plane", width = 80, length = 80, nu = 31, nv = 31 } }
thickness = 40.0
[[contact]]
master = "ball"
slave = "foam"
law = { kind = "stress", elastic = 1.0 }
[[sensor]]
name = "top"
body = "ball"
"""


def spoken(monkeypatch: pytest.MonkeyPatch, encoding: str, *words: object) -> tuple[int, str]:
    """Exit code of a command whose streams have an encoding, and all that it wrote."""
    written = BytesIO()
    with monkeypatch.context() as patch:
        for name in ("stdout", "stderr"):
            stream = TextIOWrapper(written, encoding=encoding, errors="strict", write_through=True)
            patch.setattr(sys, name, stream)
        patch.setattr(sys, "argv", ["contiga", *map(str, words)])
        patch.delenv("CONTIGA_DEBUG", raising=False)
        with pytest.raises(SystemExit) as left:
            main()
        return int(left.value.code or 0), written.getvalue().decode(encoding)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case, a study, decks and meshes with signs of all kinds in their names."""
    at = tmp_path_factory.mktemp("signs")
    (at / "fall ω.toml").write_text(CASE, encoding="utf-8")
    (at / "case.toml").write_text(CASE + "\n[output]\nreport = false\n", encoding="utf-8")
    (at / "study.toml").write_text(
        STUDY.replace("over", "über ω").replace("[0.5, 0.25]", "[0.004, 0.002]"), encoding="utf-8"
    )
    (at / "wrong.toml").write_text(CASE.replace("stress", "stréss ω"), encoding="utf-8")
    odd = deck(RIGID, FOAM, CONTACT, END, ["*CONTROL_HOURGLASS"])
    (at / "deck ω.k").write_text(odd, encoding="utf-8")
    (at / "full.k").write_text(FULL, encoding="utf-8")
    return at


COMMANDS: dict[str, Callable[[Path], tuple[object, ...]]] = {
    "help": lambda at: ("--help",),
    "help of a command": lambda at: ("study", "--help"),
    "run": lambda at: ("run", at / "fall ω.toml", "-o", at / "out ²"),
    "report": lambda at: ("report", at / "out ²"),
    "compare": lambda at: ("compare", at / "out ²", at / "out ²", "-o", at / "page ω.html"),
    "export": lambda at: ("export", at / "out ²", "-o", at / "mme", "--test", "T"),
    "check": lambda at: ("check", at / "fall ω.toml"),
    "preview": lambda at: ("preview", at / "fall ω.toml", "-o", at / "picture ω.html"),
    "info": lambda at: ("info", at / "deck ω.k"),
    "study": lambda at: ("study", at / "study.toml", "-o", at / "study ω", "--workers", "0"),
    "verify": lambda at: ("verify", "--only", "spring", "-o", at / "verified ω"),
    "convert": lambda at: (
        *("convert", at / "deck ω.k", "--units", "mm,kg,ms", "-o", at / "made ω.toml"),
    ),
}


@pytest.mark.parametrize(
    "encoding", ["cp1252", pytest.param("latin-1", marks=pytest.mark.full), "ascii"]
)
def test_every_command_ends_as_with_utf_8(
    encoding: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one go: later commands read what earlier ones wrote."""
    for name in folder.iterdir():
        (tmp_path / name.name).write_bytes(name.read_bytes())
    for name, words in COMMANDS.items():
        code, text = spoken(monkeypatch, encoding, *words(tmp_path))
        assert (name, code) == (name, 0), text
        assert text
        assert "Error" not in text


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_an_error_is_one_message(
    encoding: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code, text = spoken(monkeypatch, encoding, "check", folder / "wrong.toml")
    assert code == 2
    assert text.startswith("contiga: error: ")
    assert len(text.splitlines()) == 1
    assert "omega" in text
    assert ("stréss" in text) is (encoding != "ascii")
    assert (r"str\xe9ss" in text) is (encoding == "ascii")


def test_what_the_encoding_has_stays_as_it_is(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for encoding, said in (("utf-8", "über foam ² → ω"), ("latin-1", "über foam ² -> omega")):
        code, text = spoken(monkeypatch, encoding, "check", folder / "fall ω.toml")
        assert code == 0
        assert said in text


def test_a_process_with_such_streams_ends_well(folder: Path) -> None:
    env = os.environ | {"PYTHONIOENCODING": "ascii"}
    run = [sys.executable, "-m", "contiga", "check", str(folder / "wrong.toml")]
    done = subprocess.run(run, env=env, capture_output=True)
    assert done.returncode == 2
    assert done.stderr.startswith(b"contiga: error: ")
    assert b"omega" in done.stderr


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("12\N{NARROW NO-BREAK SPACE}345 kg·m²", "12 345 kg*m^2"),
        ("1\N{THIN SPACE}000\N{NO-BREAK SPACE}N", "1 000 N"),
        ("45°, −3 ± 1 µm → 2×10⁻⁷", "45 deg, -3 +/- 1 um -> 2x10-7"),
        ("x₁ – Δω…", "x1 - deltaomega..."),
        ("naïve \N{KISSING FACE}\udcff", r"na\xefve \U0001f617\udcff"),
    ],
)
def test_a_sign_is_written_as_a_reader_would(text: str, written: str) -> None:
    assert "".join(sign if sign.isascii() else plain(sign) for sign in text) == written
