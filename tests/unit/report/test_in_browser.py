"""The page as a browser shows it, narrow and wide."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.browser import WIDTHS, browser, opened, too_wide
from tests.sample import slow

from contiga.report import write_report

from .conftest import write_folder


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as on:
        yield on


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(write_folder(tmp_path_factory.mktemp("report") / "out"))


@pytest.mark.parametrize("width", [WIDTHS[0], *slow(WIDTHS[1])])
def test_nothing_is_wrong_and_nothing_wider_than_the_window(
    chromium: Any, path: Path, width: int
) -> None:
    page, wrong = opened(chromium, path, width)
    page.wait_for_selector("#history-0 .main-svg")
    assert (wrong, too_wide(page)) == ([], [])
    first, second = (page.locator(".halves img").nth(k).bounding_box() for k in range(2))
    assert (second["y"] >= first["y"] + first["height"]) == (width < 640)
    # An upright label is as long as its figure is high, at most.
    for label in page.locator(".ytitle").all():
        figure = label.locator("xpath=ancestor::*[contains(@class, 'js-plotly-plot')]")
        inner, outer = label.bounding_box(), figure.bounding_box()
        assert outer["y"] <= inner["y"]
        assert inner["y"] + inner["height"] <= outer["y"] + outer["height"]
    page.close()


def test_the_dotted_line_follows_the_slider_and_buttons_change_what_is_drawn(
    chromium: Any, path: Path
) -> None:
    page, wrong = opened(chromium, path, 1400)
    page.wait_for_selector("#history-0 .main-svg")
    lines = "document.getElementById('history-0').layout.shapes.map(one => [one.x0, one.x1])"
    assert page.evaluate(lines) == [[2, 2]]
    page.locator("#step").fill("4")
    assert page.evaluate(lines) == [[4, 4]]
    assert page.locator("#step-time").inner_text() == "t = 4 ms"
    page.locator("#play").click()
    page.wait_for_function("document.getElementById('play').textContent === 'Pause'")
    page.locator("#play").click()
    assert page.locator("#play").inner_text() == "Play"
    page.get_by_role("button", name="Hidden").click()
    assert page.evaluate("document.getElementById('view').data[0].visible") is False
    page.get_by_role("button", name="Solid body").click()
    assert page.evaluate("document.getElementById('view').data[0].opacity") == 1
    assert wrong == []
    page.close()
