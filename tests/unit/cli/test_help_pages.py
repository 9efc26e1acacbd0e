"""The help of each command."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

from contiga.cli import commands
from contiga.cli.help_pages import _TEXTS

from .conftest import Command


@pytest.mark.parametrize("name", ["", *sorted(_TEXTS.keys() - {""})])
def test_help_shows_examples_that_are_understood_and_its_page(
    command: Command, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    code, out, err = command(*filter(None, [name]), "--help")
    assert (code, err) == (0, "")
    page, examples = _TEXTS[name]
    assert page in out
    assert (Path(__file__).parents[3] / "docs" / page).is_file()
    assert "bool" not in out.lower(), "flags take no value"
    program: Any = typer.main.get_command(commands.app)
    for line in examples:
        assert line in out
        _, which, *arguments = shlex.split(line)
        if which != "COMMAND":
            program.commands[which].make_context(which, arguments)


def test_every_command_has_a_text_under_its_help() -> None:
    assert set(_TEXTS) == {"", *typer.main.get_command(commands.app).commands}


def test_completion_is_offered(command: Command) -> None:
    assert "--install-completion" in command("--help")[1]
