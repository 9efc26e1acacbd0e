"""The command line, run in this process."""

from __future__ import annotations

import sys

import pytest

from contiga.cli import commands


class Command:
    """Runs ``contiga …``, with the words it is made with first."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *first: str
    ) -> None:
        self._patch, self._capture, self._first = monkeypatch, capsys, first
        monkeypatch.delenv("CONTIGA_DEBUG", raising=False)

    def __call__(self, *arguments: object) -> tuple[int, str, str]:
        """Exit code, standard output, error output."""
        words = map(str, (*self._first, *arguments))
        self._patch.setattr(sys, "argv", ["contiga", *words])
        code = 0
        try:
            commands.main()
        except SystemExit as left:
            code = int(left.code or 0)
        out, err = self._capture.readouterr()
        return code, out, err
