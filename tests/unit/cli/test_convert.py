"""``contiga convert``: what it writes and prints."""

from __future__ import annotations

from pathlib import Path

from tests.decks import CONTACT, END, FOAM, FULL, RIGID, deck

from .conftest import Command, one_message


def test_a_deck_becomes_a_case_that_is_ready_to_run(command: Command, tmp_path: Path) -> None:
    (tmp_path / "deck.k").write_text(
        deck(RIGID, FOAM, CONTACT, END, ["*CONTROL_HOURGLASS"]), encoding="utf-8"
    )
    out = tmp_path / "case.toml"
    code, text, err = command("convert", tmp_path / "deck.k", "--units", "mm,kg,ms", "-o", out)
    assert (code, err) == (0, "")
    assert f"{out}: 1 bodies, 1 contacts" in text
    assert "not understood: 1 *CONTROL_HOURGLASS, line " in text
    code, text, _ = command("check", out)
    assert code == 0
    assert "ready to run" in text


def test_a_case_that_is_there_is_not_written_over(command: Command, tmp_path: Path) -> None:
    (tmp_path / "deck.k").write_text(FULL, encoding="utf-8")
    out = tmp_path / "case.toml"
    out.write_text("mine", encoding="utf-8")
    code, _, err = command("convert", tmp_path / "deck.k", "--units", "mm,kg,ms", "-o", out)
    assert code == 2
    assert "there is such a file already" in one_message(err)
    assert out.read_text(encoding="utf-8") == "mine"


def test_a_deck_that_is_none_leaves_nothing(command: Command, tmp_path: Path) -> None:
    out = tmp_path / "case.toml"
    for name in ("nowhere.k", "."):
        code, _, err = command("convert", tmp_path / name, "--units", "mm,kg,ms", "-o", out)
        assert code == 2
        assert "cannot be read" in one_message(err)
    assert not out.exists()
