"""The wheel of all kernels: with it a run compiles nothing and has the bits that it has without."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest
from tests.command import Command

from contiga.jit.prebuilt import SWITCH

ROOT = Path(__file__).resolve().parents[2]
SAID = re.compile(r"(\d+) kernels compiled, .* bits (\w+)\n")


def said(*installed: Path, **environment: str) -> tuple[int, str]:
    """How many kernels a process compiles for the README's ten lines, and the bits."""
    path = os.pathsep.join(map(str, (*installed, ROOT / "src")))
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "nothing_compiled.py")],
        env=os.environ | {"PYTHONPATH": path, SWITCH: str(len(installed))} | environment,
        capture_output=True,
        text=True,
    )
    found = SAID.search(done.stdout)
    assert found is not None, done.stderr
    assert done.returncode == (1 if int(found[1]) or not installed else 0)
    return int(found[1]), found[2]


@pytest.mark.full
def test_a_run_with_it_compiles_nothing_and_has_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = Command(monkeypatch, capsys)
    code, out, err = command("warmup", "--pack", tmp_path / "dist", "--quiet")
    assert (code, out, err) == (0, "", "")
    (wheel,) = (tmp_path / "dist").iterdir()
    with ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    compiled, bits = said(tmp_path / "site", NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    assert compiled == 0
    assert not list((tmp_path / "kept").rglob("*.nb?"))
    assert said()[1] == bits
