"""The progress of a run as a line of text in a notebook."""

from __future__ import annotations

import io
import sys

import pytest

from contiga.running import progress
from contiga.running.progress import progress_bar


class Notebook(io.StringIO):
    """The stream of a notebook."""


Notebook.__module__ = "ipykernel.iostream"


def test_a_notebook_gets_a_line_that_is_written_over_and_needs_no_package(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = Notebook()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setitem(sys.modules, "rich", None)
    monkeypatch.setattr(progress, "_PAUSE", 0.0)
    with progress_bar("Ball", quiet=False) as show:
        show(1, 4, "a long text about it")
        show(4, 4, "12 in contact")
    text = stream.getvalue()
    assert text.startswith("\rBall: 1/4, 25 %, ")
    assert "a long text about it" in text.split("\r")[1]
    assert text.splitlines()[-1].rstrip().endswith("Ball: 4/4, 100 %, 12 in contact")
    assert text.endswith("\n")
    assert text.count("\n") == 1
    first, second = text.split("\r")[1:3]
    assert len(second) == len(first)  # nothing of the longer text stays


def test_nothing_is_written_before_the_first_part_or_quietly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = Notebook()
    monkeypatch.setattr(sys, "stderr", stream)
    with progress_bar("Ball", quiet=False):
        pass
    with progress_bar("Ball", quiet=True) as show:
        show(1, 2, "")
    assert stream.getvalue() == ""
