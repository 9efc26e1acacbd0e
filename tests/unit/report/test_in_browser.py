"""The page as a browser shows it, narrow and wide."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.browser import WIDTHS, browser, opened, outside_on_paper, too_wide
from tests.sample import full

from contiga.report import write_report
from contiga.report.figure import Figure, embedded, plotly_script, side_by_side
from contiga.report.style import page as styled

from .conftest import write_folder


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as on:
        yield on


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(write_folder(tmp_path_factory.mktemp("report") / "out"))


@pytest.mark.parametrize("width", [WIDTHS[0], *full(*WIDTHS[1:])])
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


@pytest.mark.parametrize(
    ("width", "paper"),
    [
        (1400, {"format": "A4"}),
        *full((1400, {"format": "A4", "landscape": True}), (500, {"format": "Letter"})),
    ],
)
def test_all_drawings_are_in_their_cards_on_paper(
    chromium: Any, path: Path, tmp_path: Path, width: int, paper: dict[str, Any]
) -> None:
    page, wrong = opened(chromium, path, width)
    page.wait_for_selector("#view canvas")
    drawn = (
        "[...document.querySelectorAll('.main-svg')].map(one => one.getBoundingClientRect().width)"
    )
    before = page.evaluate(drawn)
    assert outside_on_paper(page, tmp_path, **paper) == []
    assert page.evaluate(drawn) == before
    assert page.locator(".main-svg[viewBox]").count() == 0
    page.set_viewport_size({"width": 3 * width // 4, "height": 900})
    page.wait_for_function(f"{drawn}[0] < {before[0]}")
    assert (wrong, too_wide(page)) == ([], [])
    page.close()


def test_a_canvas_keeps_what_it_shows(chromium: Any, path: Path) -> None:
    """Else paper has none of it."""
    page, _ = opened(chromium, path, 1400)
    page.wait_for_selector("#view canvas")
    asked = "document.querySelector('#view canvas').getContext('webgl').getContextAttributes()"
    assert page.evaluate(asked)["preserveDrawingBuffer"] is True
    page.close()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_last_drawing_of_an_odd_number_is_as_wide_as_its_card(
    chromium: Any, tmp_path: Path, count: int
) -> None:
    layout = {"height": 100, "margin": {"l": 0, "r": 0, "t": 0, "b": 0}}
    drawn = (
        embedded(Figure([{"y": [1, 2]}], layout), f"f{k}", {"responsive": True})
        for k in range(count)
    )
    path = tmp_path / "page.html"
    path.write_text(styled("t", side_by_side(drawn), script=plotly_script()), encoding="utf-8")
    page, wrong = opened(chromium, path, 1400)
    page.wait_for_selector(f"#f{count - 1} .main-svg")
    widths = page.evaluate(
        "[...document.querySelectorAll('.frame')].map(one => [one.clientWidth - 8, "
        "one.querySelector('.main-svg').getBoundingClientRect().width])"
    )
    assert wrong == []
    for card, drawing in widths:
        assert drawing == pytest.approx(card, abs=1.0)
    assert (widths[-1][0] > 900.0) is (count % 2 == 1)
    page.close()
