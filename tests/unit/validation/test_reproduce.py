"""The folder of a reproduction: page, tables, pictures, and what wrong input does."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest
from tests.command import Command

from contiga.errors import FileError, InputError, OutputError, RunError
from contiga_validation.reproduce import broken_claims, reproduce

from .conftest import BROKEN, FAILING, GOOD


class _Links(HTMLParser):
    """Collects what a page refers to, its ids and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.ids: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("src", "href", "action", "data", "poster", "srcset"):
                self.links.append(value or "")
            elif name == "id":
                self.ids.append(value or "")

    def handle_data(self, data: str) -> None:
        self.text += data


def read_page(path: Path) -> _Links:
    page = _Links()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def test_page_has_every_experiment_and_reads_offline(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, BROKEN)
    page = read_page(reproduce(tmp_path / "out"))
    assert {GOOD.key, BROKEN.key} <= set(page.ids)
    for link in page.links:
        assert link.startswith(("data:", "#")), link
        assert not link.startswith("#") or link[1:] in page.ids
    assert "#" + GOOD.key in page.links
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\(", text)
    for said in ("All <well>", "It says so & so.", "Counts & areas <beside>", "One is <one>."):
        assert said in page.text
    assert "1 of 2 statements did not hold" in page.text


def test_tables_read_back_as_they_were(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, BROKEN)
    out = tmp_path / "out"
    reproduce(out)
    with (out / "tables.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["experiment", "table", "row", "column", "value"]
    assert ["5.1-good", "5.9", "1", "area", repr(0.1 + 0.2)] in rows
    assert ["5.1-good", "5.9", "1", "note", "a, b"] in rows
    assert ["5.1-good", "5.9", "2", "area", ""] in rows
    content = json.loads((out / "tables.json").read_text(encoding="utf-8"))
    assert content["threads"] >= 1
    assert content["version"]
    one, two = content["experiments"]
    assert one["tables"][0]["rows"] == [[1, 0.1 + 0.2, "a, b"], [2, None, None]]
    assert one["claims"][0]["holds"] is True
    assert two["claims"][0]["holds"] is False
    (picture,) = one["pictures"]
    assert (out / picture["file"]).read_bytes().startswith(b"\x89PNG")
    assert broken_claims(out) == ["6.1-broken: Pigs fly. (0 of 3 did)"]


def test_again_replaces_its_own_files_only(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, BROKEN)
    out = tmp_path / "out"
    reproduce(out)
    (out / "figures" / "mine.png").write_bytes(b"mine")
    catalogued(BROKEN)
    reproduce(out)
    assert {path.name for path in (out / "figures").iterdir()} == {"mine.png"}
    assert GOOD.key not in read_page(out / "report.html").ids
    assert {p.name for p in out.iterdir()} == {
        "figures", "report.html", "tables.csv", "tables.json",
    }  # fmt: skip


def test_experiment_that_fails_is_named_and_leaves_nothing(
    catalogued: Callable, tmp_path: Path
) -> None:
    catalogued(GOOD, FAILING)
    with pytest.raises(RunError, match=r"7\.1-failing: ZeroDivisionError: no way"):
        reproduce(tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_wrong_name_is_told_before_anything_is_made(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD)
    with pytest.raises(InputError, match="no experiment has this name"):
        reproduce(tmp_path / "out", only=["8.3"])
    assert list(tmp_path.iterdir()) == []


def test_folder_of_something_else_is_refused(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD)
    (tmp_path / "chapter1.txt").write_text("my work", encoding="utf-8")
    with pytest.raises(OutputError, match="not of a reproduction"):
        reproduce(tmp_path)
    with pytest.raises(OutputError, match="is a file"):
        reproduce(tmp_path / "chapter1.txt")
    with pytest.raises(OutputError, match="cannot be written"):
        reproduce(tmp_path / "chapter1.txt" / "below")
    assert [path.name for path in tmp_path.iterdir()] == ["chapter1.txt"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"experiments": [{"key": "a"}]}'])
def test_folder_without_tables_has_no_claims(tmp_path: Path, text: str) -> None:
    if text:
        (tmp_path / "tables.json").write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match="not the tables of a reproduction"):
        broken_claims(tmp_path)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(monkeypatch, capsys, "reproduce")


def test_command_says_where_the_page_is(
    catalogued: Callable, command: Command, tmp_path: Path
) -> None:
    catalogued(GOOD)
    code, out, err = command("-o", tmp_path / "out")
    assert code == 0
    assert out == f"report: {tmp_path / 'out' / 'report.html'}\n"
    assert "1/1" in err
    assert command("-o", tmp_path / "out", "--quiet") == (0, "", "")


def test_command_leaves_with_one_where_a_claim_breaks(
    catalogued: Callable, command: Command, tmp_path: Path
) -> None:
    catalogued(GOOD, BROKEN)
    code, _, err = command("-o", tmp_path / "out", "--quiet")
    assert code == 1
    assert err.strip().splitlines() == [
        "contiga: error: not every statement held: 6.1-broken: Pigs fly. (0 of 3 did)"
    ]
    assert (tmp_path / "out" / "report.html").is_file()
    assert command("-o", tmp_path / "out", "--quiet", "--only", "5.1")[0] == 0


@pytest.mark.parametrize("arguments", [["--only", "5.1,nine"], ["--only", ""], ["-o", "taken"]])
def test_command_with_wrong_input_is_one_message(
    catalogued: Callable,
    command: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
) -> None:
    catalogued(GOOD)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    code, out, err = command(*arguments)
    assert code == 2
    assert out == ""
    (line,) = err.strip().splitlines()
    assert line.startswith("contiga: error: ")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
