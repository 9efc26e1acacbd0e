"""The folder of a verification: page, numbers, and what wrong input does."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from tests.command import Command

from contiga.errors import FileError, InputError, OutputError, RunError
from contiga_validation.closed_forms import catalogue
from contiga_validation.closed_forms.case import (
    LEAST_ORDER,
    Answer,
    Case,
    Check,
    Order,
    absolute,
    order_of,
    relative,
)
from contiga_validation.closed_forms.page import worst
from contiga_validation.verify import broken_cases, verify


def _draw(figure) -> None:
    figure.subplots().plot([0.0, 1.0], [1.0, 0.0])


def good() -> Answer:
    order = Order("way <at> the end", (0.2, 0.1, 0.05), (4e-4, 1e-4, 2.5e-5))
    checks = relative("way & speed", 2.00001, 2.0), absolute("nothing", 0.0, 0.0, 0.0)
    return Answer(checks, _draw, order)


def far_off() -> Answer:
    depth, time = np.array([1.1, 1.0])
    return Answer((relative("depth", depth, 1.0), absolute("time", time, 1.0, 0.0)), _draw)


def too_slow() -> Answer:
    order = Order("way", (0.2, 0.1, 0.05), (4e-4, 2e-4, 1e-4))
    return Answer((relative("way", 1.0, 1.0),), _draw, order)


def failing() -> Answer:
    raise ZeroDivisionError("no way")


GOOD = Case("mass-good", "Masses", "All <well>", "m = ρ V & so", "A scene.", good)
OFF = Case("mass-off", "Masses", "Not so well", "d = 1", "A scene.", far_off)
SLOW = Case("slow", "Steps", "First order", "x = 1", "A scene.", too_slow)
FAILING = Case("failing", "Steps", "Not at all", "x = 1", "A scene.", failing)


@pytest.fixture
def catalogued(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Puts cases in the place of those of the suite."""

    def put(*cases: Case) -> None:
        monkeypatch.setattr(catalogue, "cases", lambda: cases)

    return put


class _Page(HTMLParser):
    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.ids: list[str] = []
        self.text = ""
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]
        self.ids += [value or "" for name, value in attrs if name == "id"]

    def handle_data(self, data: str) -> None:
        self.text += data


def test_page_has_every_case_and_reads_offline(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, OFF, SLOW)
    path = verify(tmp_path / "out")
    page = _Page(path)
    assert page.ids == ["mass-good", "mass-off", "slow"]
    assert all(link.startswith(("data:", "#")) for link in page.links)
    assert {link[1:] for link in page.links if link.startswith("#")} == set(page.ids)
    assert sum(link.startswith("data:image/png") for link in page.links) == 3
    assert not re.search(r"https?://|@import|url\(", path.read_text(encoding="utf-8"))
    for said in ("All <well>", "m = ρ V & so", "way & speed", "way <at> the end", "2.000"):
        assert said in page.text
    assert "2 of 3 cases do not hold" in page.text


def test_page_says_where_all_hold(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD)
    assert "All 1 cases hold" in _Page(verify(tmp_path / "out")).text


def test_numbers_read_back_as_they_were(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, OFF, SLOW)
    verify(tmp_path / "out")
    content = json.loads((tmp_path / "out" / "verification.json").read_text(encoding="utf-8"))
    assert content["version"]
    first, off, slow = content["cases"]
    assert [case["holds"] for case in content["cases"]] == [True, False, False]
    assert first["checks"][0]["measured"] == 2.00001
    assert first["checks"][0]["error"] == pytest.approx(5e-6)
    assert first["order"]["observed"] == pytest.approx(2.0)
    assert off["order"] is None
    assert [check["holds"] for check in off["checks"]] == [False, True]
    assert slow["order"]["errors"] == [4e-4, 2e-4, 1e-4]
    assert slow["order"]["holds"] is False
    depth, order = broken_cases(tmp_path / "out")
    assert depth.startswith("mass-off (depth 0.1")
    assert order.startswith("slow (order 1.0")


def test_a_number_that_is_none_does_not_hold() -> None:
    assert not relative("depth", math.nan, 1.0).holds
    assert not absolute("depth", math.inf, 0.0, 1.0).holds
    nothing = Order("way", (0.2, 0.1), (0.0, 0.0))
    assert math.isnan(nothing.observed)
    assert not nothing.holds
    assert not Answer((relative("way", 1.0, 1.0),), _draw, nothing).holds


def test_errors_are_relative_to_what_is_expected() -> None:
    assert relative("way", 202.0, 200.0).error == pytest.approx(0.01)
    assert relative("way", 2.0, 0.0, scale=100.0).error == pytest.approx(0.02)
    assert absolute("way", -2.0, 1.0, 5.0) == Check("way", -2.0, 1.0, 3.0, 5.0)


@pytest.mark.parametrize("power", [1.0, 1.8, 2.0, 3.0])
def test_order_is_the_power_of_the_error(power: float) -> None:
    order = order_of("error", 0.3, lambda step: 7.0 * step**power)
    assert order.steps == (0.3, 0.15, 0.075)
    assert order.observed == pytest.approx(power)
    assert order.holds == (power >= LEAST_ORDER)
    stricter = order_of("error", 0.3, lambda step: 7.0 * step**power, least=2.5)
    assert stricter.holds == (power >= 2.5)


def test_the_worst_check_is_the_nearest_to_its_tolerance() -> None:
    near, far = absolute("near", 0.9, 0.0, 1.0), absolute("far", 5.0, 0.0, 50.0)
    none, zero = absolute("none", math.nan, 0.0, 1.0), absolute("zero", 0.0, 0.0, 0.0)
    assert worst(Answer((far, near, zero), _draw)) is near
    assert worst(Answer((far, none, near), _draw)) is none


def test_case_that_fails_is_named_and_leaves_nothing(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, FAILING)
    with pytest.raises(RunError, match="case failing: ZeroDivisionError: no way"):
        verify(tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_first_word_stands_for_its_cases(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD, OFF, SLOW)
    assert _Page(verify(tmp_path / "out", only=["mass"])).ids == ["mass-good", "mass-off"]
    assert _Page(verify(tmp_path / "out", only=[" slow"])).ids == ["slow"]


@pytest.mark.parametrize("only", [["9"], ["mass-"], ["mas"], [""], []])
def test_wrong_name_is_told_before_anything_is_made(
    catalogued: Callable, tmp_path: Path, only: list[str]
) -> None:
    catalogued(GOOD)
    with pytest.raises(InputError, match="no case has this name") as caught:
        verify(tmp_path / "out", only=only)
    assert "mass-good" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_folder_of_something_else_is_refused(catalogued: Callable, tmp_path: Path) -> None:
    catalogued(GOOD)
    (tmp_path / "mine.txt").write_text("my work", encoding="utf-8")
    with pytest.raises(OutputError, match="not of a verification"):
        verify(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"cases": [{"key": "a"}]}'])
def test_folder_without_numbers_has_no_cases(tmp_path: Path, text: str) -> None:
    if text:
        (tmp_path / "verification.json").write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match="not the numbers of a verification"):
        broken_cases(tmp_path)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(monkeypatch, capsys, "verify")


def test_command_says_where_the_page_is(
    catalogued: Callable, command: Command, tmp_path: Path
) -> None:
    catalogued(GOOD)
    code, out, err = command("-o", tmp_path / "out")
    assert code == 0
    assert out == f"report: {tmp_path / 'out' / 'verification.html'}\n"
    assert "1/1" in err
    assert command("-o", tmp_path / "out", "--quiet") == (0, "", "")


def test_command_leaves_with_one_where_a_case_does_not_hold(
    catalogued: Callable, command: Command, tmp_path: Path
) -> None:
    catalogued(GOOD, SLOW)
    code, _, err = command("-o", tmp_path / "out", "--quiet")
    assert code == 1
    (line,) = err.strip().splitlines()
    assert line.startswith("contiga: error: not every case holds: slow (order 1.0")
    assert (tmp_path / "out" / "verification.html").is_file()
    assert command("-o", tmp_path / "out", "--quiet", "--only", "mass")[0] == 0


@pytest.mark.parametrize("arguments", [["--only", "mass,nine"], ["--only", ""], ["-o", "taken"]])
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


def test_keys_of_the_suite_are_unique_and_words() -> None:
    keys = [case.key for case in catalogue.cases()]
    assert len(set(keys)) == len(keys) >= 25
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", key) for key in keys)
    # Cases of one group stand together, as the page has them.
    groups = [case.group for case in catalogue.cases()]
    assert sum(a != b for a, b in pairwise(groups)) == len(set(groups)) - 1


def test_every_case_says_what_it_compares() -> None:
    for case in catalogue.cases():
        assert case.title
        assert case.formula, case.key
        assert case.scene.endswith("."), case.key
