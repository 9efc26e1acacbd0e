"""The page of a study as a browser shows it, narrow and wide."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import image
from tests.browser import WIDTHS, browser, opened, outside_on_paper, too_wide
from tests.sample import full

from contiga.studies.maps import map_figure, map_of
from contiga.studies.page import page_data, page_of
from contiga.studies.row import DONE, Row
from contiga.studies.table import table_of

from .conftest import CASE, STUDY, base_in, study_from
from .test_maps import TEXT
from .test_page import data_of


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as on:
        yield on


@pytest.mark.parametrize("width", [WIDTHS[0], *full(*WIDTHS[1:])])
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


def test_all_rows_and_drawings_are_on_paper(chromium: Any, folder: Path, tmp_path: Path) -> None:
    path = folder / "study.html"
    path.write_text(data_of(STUDY, folder, 80)[1], encoding="utf-8")
    page, wrong = opened(chromium, path, 1400)
    page.wait_for_selector("#parallel canvas")
    page.evaluate(
        "addEventListener('beforeprint', () => { "
        "window.rows = document.querySelectorAll('#rows-body tr').length; })"
    )
    assert outside_on_paper(page, tmp_path, format="A4") == []
    assert page.evaluate("window.rows") == 80
    assert page.locator("#rows-body tr").count() < 80
    assert wrong == []
    page.close()


def page_with_a_map(folder: Path, shape: str) -> Path:
    """Impacts on a part: its page."""
    (folder / "targets.csv").write_text("x,y,z\n0,0,0\n", encoding="utf-8")
    old = 'shape = "sphere", radius = 10.0'
    (folder / "case.toml").write_text(CASE.replace(old, shape), encoding="utf-8")
    study, base = study_from(TEXT, folder), base_in(folder)
    around = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    at = np.column_stack([6.0 * np.cos(around), 6.0 * np.sin(around), np.full(12, 18.5)])
    rows = [
        Row(k, DONE, "", dict(zip("xyz", p, strict=True)), {"max(force)": 90.0 * k}, 0.5)
        for k, p in enumerate(at.tolist(), start=1)
    ]
    drawn = map_of(study, base, tuple(rows))
    assert drawn is not None
    table = table_of(rows, study.labels, ("max(force)",))
    data = page_data(study, base, table, rows) | {"between": drawn.between}
    data["map"] = map_figure(drawn, {row.number: k for k, row in enumerate(rows)})
    path = folder / "study.html"
    path.write_text(page_of(study, data, rows, b""), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("width", "shape"),
    [
        (500, 'shape = "ellipsoid", axes = [12.0, 40.0, 8.0]'),
        *full((1400, 'shape = "sphere", radius = 10.0')),
    ],
)
def test_all_of_the_map_is_seen_and_its_title_is_under_no_button(
    chromium: Any, folder: Path, width: int, shape: str
) -> None:
    page, wrong = opened(chromium, page_with_a_map(folder, shape), width)
    page.wait_for_selector("#map .gl-container canvas")
    page.wait_for_timeout(800)
    assert (wrong, too_wide(page)) == ([], [])
    buttons = page.locator("#map .modebar").bounding_box()
    title = page.locator("#map [class*=title] text, #map text[class*=title]").first.bounding_box()
    assert title["y"] > buttons["y"] + buttons["height"]
    page.locator("#map").screenshot(path=folder / "map.png")
    picture = image.imread(folder / "map.png")[:, :, :3]
    # The scene, without the bar: the part is there, and does not go to the border.
    scene = picture[40:-90] if width < 640 else picture[40:-5, :-90]
    coloured = np.ptp(scene, axis=2) > 0.25
    assert coloured.mean() > 0.02
    assert not coloured[:, [3, -3]].any()
    assert not coloured[[3, -3]].any()
    page.close()
