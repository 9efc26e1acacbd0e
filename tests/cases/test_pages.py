"""Every page in a browser: at three widths, on paper, where the system is light and where dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.browser import SCHEMES, WIDTHS, browser, faint, opened, outside_on_paper, too_wide
from tests.sample import FULL
from tests.unit.previewing.test_preview import scene
from tests.unit.report.conftest import write_folder
from tests.unit.report.test_comparison import COARSE, FINE, write_run
from tests.unit.studies.conftest import CASE, STUDY
from tests.unit.studies.test_in_browser import page_with_a_map
from tests.unit.studies.test_page import data_of

import contiga as cg
from contiga.io.out.history import read_history, write_history
from contiga.report import write_report
from contiga.report.comparison import compare
from contiga.report.comparison_page import write_comparison
from contiga.report.style import INK, PAPER, SLAVE, inverted
from contiga_validation.closed_forms.case import Answer, Case, Check
from contiga_validation.closed_forms.page import CaseResult
from contiga_validation.closed_forms.page import page as verified
from contiga_validation.engine.table_files import machine

ENERGIES = ("kinetic", "strain", "contact", "friction", "damping", "hysteresis", "gas", "error")
PAGES = ("report", "comparison", "preview", "study", "map", "verification")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as on:
        yield on


def report_with_energies(folder: Path) -> Path:
    """The page of a run whose system has all energies there are."""
    path = write_folder(folder / "out") / "history.csv"
    history = {name: np.array(column) for name, column in read_history(path).items()}
    for k, name in enumerate(ENERGIES, start=1):
        history[f"energy.{name}"] = k * history["time"]
    write_history(path, history)
    return write_report(path.parent)


def written(kind: str, folder: Path) -> Path:
    """A page of each kind with all that it can have, from made-up results."""
    if kind == "report":
        return report_with_energies(folder)
    if kind == "comparison":
        write_run(folder / "coarse", COARSE)
        write_run(folder / "fine", FINE, factor=1.5)
        pair = compare(folder / "coarse", folder / "fine")
        return write_comparison(pair, folder / "page.html")
    if kind == "preview":
        return cg.preview(scene()).save(folder / "page.html")
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    if kind == "map":
        return page_with_a_map(folder, 'shape = "sphere", radius = 10.0')
    path = folder / "page.html"
    text = data_of(STUDY, folder, 12)[1] if kind == "study" else verification()
    path.write_text(text, encoding="utf-8")
    return path


def verification() -> str:
    """The page of two cases, of which one does not hold."""
    shown = []
    for key, error in (("good", 0.0), ("bad", 1.0)):
        answer = Answer((Check("speed", 1.0 + error, 1.0, error, 1e-4),), lambda figure: None)
        case = Case(key, "Motion", f"A {key} case", "v = 1", "A scene.", no_answer)
        shown.append(CaseResult(case, answer, b"", 0.5))
    return verified(shown, machine())


def under_buttons(page: Any) -> list[str]:
    """Figures whose legend meets their buttons, by their names."""
    script = """() => [...document.querySelectorAll(".js-plotly-plot")].filter((plot) => {
      const boxes = [".legend", ".modebar-group"].map((one) => plot.querySelector(one));
      if (boxes.includes(null)) return false;
      const [names, buttons] = boxes.map((one) => one.getBoundingClientRect());
      return names.top < buttons.bottom && names.bottom > buttons.top
        && names.left < buttons.right && names.right > buttons.left;
    }).map((plot) => plot.id)"""
    return list(page.evaluate(script))


def cut(page: Any) -> list[str]:
    """Texts of figures that end outside of them."""
    script = """() => [...document.querySelectorAll(".js-plotly-plot")].flatMap((plot) => {
      const figure = plot.getBoundingClientRect();
      return [...plot.querySelectorAll(".main-svg text")].filter((text) => {
        const box = text.getBoundingClientRect();
        return box.width > 0 && (box.left < figure.left - 1 || box.right > figure.right + 1
          || box.top < figure.top - 1 || box.bottom > figure.bottom + 1);
      }).map((text) => `${plot.id}: ${text.textContent}`);
    })"""
    return list(page.evaluate(script))


def no_answer() -> Answer:
    """Stand for the run of a case: its answer is made up."""
    raise AssertionError


def drawn(page: Any) -> None:
    """Wait until all figures are drawn, with their scenes."""
    page.wait_for_function(
        "[...document.querySelectorAll('.plotly-graph-div, #map, #parallel, #response')]"
        ".every(one => one.querySelector('.main-svg'))"
    )
    page.wait_for_timeout(300)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("kind", PAGES)
def test_a_page_is_whole_and_its_texts_can_be_read(
    chromium: Any, tmp_path: Path, kind: str, scheme: str
) -> None:
    path = written(kind, tmp_path)
    for width in WIDTHS if FULL else WIDTHS[:1]:
        page, wrong = opened(chromium, path, width, scheme)
        drawn(page)
        assert (wrong, too_wide(page), faint(page)) == ([], [], [])
        assert (under_buttons(page), cut(page)) == ([], [])
        page.close()


@pytest.mark.parametrize("kind", PAGES)
def test_paper_is_light_and_all_is_on_it(chromium: Any, tmp_path: Path, kind: str) -> None:
    page, wrong = opened(chromium, written(kind, tmp_path), 1400, "dark")
    drawn(page)
    page.evaluate("""() => addEventListener("beforeprint", () => {
      window.plots = [...document.querySelectorAll(".js-plotly-plot")];
      window.papers = plots.map((plot) => plot._fullLayout.paper_bgcolor);
    })""")
    assert outside_on_paper(page, tmp_path, format="A4") == []
    assert set(page.evaluate("window.papers")) <= {PAPER}
    after = (
        "[...document.querySelectorAll('.js-plotly-plot')].map(p => p._fullLayout.paper_bgcolor)"
    )
    assert set(page.evaluate(after)) <= {inverted(PAPER)}
    assert wrong == []
    page.close()


def test_figures_follow_the_system_with_the_colours_of_the_page(
    chromium: Any, tmp_path: Path
) -> None:
    page, wrong = opened(chromium, report_with_energies(tmp_path), 1400, "light")
    drawn(page)

    def seen() -> list[Any]:
        return list(
            page.evaluate("""() => {
              const { paper_bgcolor, font, scene } = document.getElementById("view")._fullLayout;
              const body = getComputedStyle(document.body);
              const hex = (rgb) => "#" + rgb.match(/[0-9]+/g).map(
                (c) => Number(c).toString(16).padStart(2, "0")).join("");
              return [paper_bgcolor, hex(body.backgroundColor), font.color, hex(body.color),
                scene.camera.eye];
            }""")
        )

    def shown(colour: str) -> list[Any]:
        page.wait_for_function(f"{view}.layout.paper_bgcolor === '{colour}'")
        return seen()

    field, view = "data[1].colorscale[0][1]", "document.getElementById('view')"
    scale = f"{view}.data.flatMap((trace) => trace.colorscale || []).map((stop) => stop[1])"
    light, drawn_light = shown(PAPER), page.evaluate(scale)
    page.emulate_media(color_scheme="dark")
    dark = shown(inverted(PAPER))
    page.locator("#step").fill("4")  # what is drawn anew is dark, too
    assert page.evaluate(f"{view}.{field}") == inverted(SLAVE)
    page.emulate_media(color_scheme="light")
    assert shown(PAPER) == light == [PAPER, PAPER, INK, INK, light[-1]]
    paper, ink = inverted(PAPER), inverted(INK)
    assert dark == [paper, paper, ink, ink, light[-1]]
    assert page.evaluate(f"{view}.{field}") == SLAVE
    # Those of the darkest colours, too, a channel of which is cut off in the dark.
    assert page.evaluate(scale) == drawn_light
    assert drawn_light[-1] != inverted(inverted(drawn_light[-1]))
    assert wrong == []
    page.close()
