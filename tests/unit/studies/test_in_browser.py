"""The page of a study as a browser shows it, narrow and wide."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.browser import WIDTHS, browser, opened, too_wide

from .conftest import STUDY
from .test_page import data_of


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as on:
        yield on


@pytest.mark.parametrize("width", WIDTHS)
def test_the_table_sorts_and_nothing_is_wider_than_the_window(
    chromium: Any, folder: Path, width: int
) -> None:
    path = folder / "study.html"
    path.write_text(data_of(STUDY, folder, 12)[1], encoding="utf-8")
    page, wrong = opened(chromium, path, width)
    page.wait_for_selector("#rows tbody tr")
    assert (wrong, too_wide(page)) == ([], [])

    def column(k: int) -> list[str]:
        rows = "#rows tbody:not(.space) tr"
        return [str(text) for text in page.locator(f"{rows} td:nth-child({k})").all_inner_texts()]

    assert column(1)[:3] == ["1", "2", "3"]
    head = page.locator("#rows thead button", has_text="case")
    head.click()
    if column(1)[0] == "1":  # it was sorted so
        head.click()
    assert column(1)[:3] == ["12", "11", "10"]
    assert wrong == []
    page.close()
