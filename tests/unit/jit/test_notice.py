"""The line that says that kernels are compiled: once, to those who read along."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from contiga.jit import notice

LOOKED_UP = "import contiga as cg; cg.shapes.arc(radius=1.0).evaluate([0.5]); cg.shapes.plane()"


class Terminal:
    """A stream that somebody reads."""

    def __init__(self, terminal: bool = True) -> None:
        self.text, self._terminal = "", terminal

    def write(self, text: str) -> None:
        self.text += text

    def flush(self) -> None: ...

    def isatty(self) -> bool:
        return self._terminal


class Notebook(Terminal):
    """The stream of a notebook, which says that it is no terminal."""


Notebook.__module__ = "ipykernel.iostream"


@pytest.fixture(autouse=True)
def _unsaid(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notice, "_is_notified", False)
    monkeypatch.delenv(notice.SWITCH, raising=False)


def said(monkeypatch: pytest.MonkeyPatch, stream: Terminal) -> str:
    monkeypatch.setattr(sys, "stderr", stream)
    notice.notify_once()
    notice.notify_once()
    return stream.text


@pytest.mark.parametrize("stream", [Terminal(), Notebook(terminal=False)])
def test_it_is_said_once_at_a_terminal_and_in_a_notebook(
    monkeypatch: pytest.MonkeyPatch, stream: Terminal
) -> None:
    text = said(monkeypatch, stream)
    assert text.startswith("contiga compiles kernels")
    assert notice.SWITCH in text
    assert text.count("\n") == 1


def test_it_is_not_said_where_nobody_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, Terminal(terminal=False)) == ""


def test_it_is_left_out_by_the_switch_and_by_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(notice.SWITCH, "1")
    assert said(monkeypatch, Terminal()) == ""
    monkeypatch.setenv(notice.SWITCH, "0")
    monkeypatch.setattr(notice, "_is_notified", False)
    notice.suppress_notice()
    assert said(monkeypatch, Terminal()) == ""


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_process_at_a_terminal_says_it_when_it_compiles_and_not_when_it_reads(
    tmp_path: Path,
) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "CONTIGA_KERNELS": "0"}
    texts = []
    for _ in range(2):
        ours, theirs = pty.openpty()
        subprocess.run(
            [sys.executable, "-c", LOOKED_UP], stderr=theirs, check=True, env=environment
        )
        os.write(theirs, b"end\n")
        os.close(theirs)
        texts.append(os.read(ours, 10_000).decode())
        os.close(ours)
    assert texts[0].startswith("contiga compiles kernels, once for all projects")
    assert texts[0].count("contiga compiles") == 1
    assert texts[1] == "end\r\n"
