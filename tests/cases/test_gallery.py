"""The gallery: every run with its case, its picture and its numbers, which the case still gives."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest
from tests.sample import full

ROOT = Path(__file__).resolve().parents[2]
MADE: dict[str, Any] = runpy.run_path(str(ROOT / "docs" / "draw_gallery.py"))
ENTRIES = {entry.name: entry for entry in MADE["ENTRIES"]}
QUICK = ("bumps",)


def rows(section: str) -> list[tuple[str, str]]:
    """The numbers of a section."""
    matches = re.findall(r"^\| (.+?) \| (.+?) \|$", section, re.M)
    return [(label, value) for label, value in matches]


def test_there_are_a_dozen_runs_and_each_shows_its_case_as_it_is() -> None:
    sections = MADE["sections"]()
    assert len(ENTRIES) >= 12
    assert list(sections) == list(ENTRIES)
    for name, entry in ENTRIES.items():
        assert sections[name].strip() == MADE["section"](entry, rows(sections[name])).strip()


@pytest.mark.parametrize("name", ENTRIES)
def test_pictures_are_small(name: str) -> None:
    picture = ROOT / "docs" / "images" / f"gallery_{name}.png"
    assert 5_000 < picture.stat().st_size < MADE["LARGEST"]


@pytest.mark.parametrize("name", [*QUICK, *full(*sorted(ENTRIES.keys() - QUICK))])
def test_a_run_still_has_the_numbers_of_the_page(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(MADE["run"].__globals__, "IMAGES", tmp_path)
    again = dict(MADE["run"](ENTRIES[name], tmp_path / "out"))
    page = dict(rows(MADE["sections"]()[name]))
    assert set(again) == set(page)
    for label, value in page.items():
        if label != "energy balance error":
            assert _number(again[label]) == pytest.approx(_number(value), rel=0.02), label


def _number(text: str) -> float:
    return float(text.replace("\N{NARROW NO-BREAK SPACE}", "").split()[0])
