"""The page: whole, self-contained and honest about what is missing."""

from __future__ import annotations

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import contiga.report.html as page_module
from contiga.report import write_report
from contiga.report.run_folder import read_run
from contiga.report.style import number
from contiga.simulation.model import OutputOptions

from .conftest import write_folder


class Page(HTMLParser):
    """Collects what the page refers to, its headings and its unclosed elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.open: list[str] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.references += [v or "" for k, v in attrs if k in ("src", "href", "srcset", "data")]
        if tag not in ("meta", "link", "img", "br", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words.append(data)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = write_folder(tmp_path_factory.mktemp("report") / "out")
    return folder, write_report(folder).read_text(encoding="utf-8")


def test_page_and_picture_are_in_the_folder_and_nothing_else(written: tuple[Path, str]) -> None:
    folder, _ = written
    names = {p.name for p in folder.iterdir()}
    read = {"history.csv", "fields.vtkhdf", "summary.json", "case.toml"}
    assert names == read | {"report.html", "peak.png"}


def test_page_refers_to_nothing_outside_itself(written: tuple[Path, str]) -> None:
    page = Page(written[1])
    assert page.references
    assert [r for r in page.references if not r.startswith("data:")] == []
    style = re.search(r"<style>(.*?)</style>", written[1], re.S)
    assert style is not None
    assert "url(" not in style[1]
    assert "@import" not in style[1]


def test_plotly_is_in_the_page_once(written: tuple[Path, str]) -> None:
    assert len(re.findall(r"plotly\.js v\d", written[1])) == 1


def test_elements_are_closed_in_order(written: tuple[Path, str]) -> None:
    assert Page(written[1]).open == []


def test_page_says_what_the_run_was(written: tuple[Path, str]) -> None:
    words = " ".join(Page(written[1]).words)
    for text in ("A ball & a <sheet>", "0.1.0", "Peak force", "t = 2 ms", "case.toml", "None."):
        assert text in words


def test_names_from_a_case_cannot_become_markup(written: tuple[Path, str]) -> None:
    assert "<sheet>" not in written[1]


def test_headings_are_those_of_what_there_is(written: tuple[Path, str], tmp_path: Path) -> None:
    assert not {"Energy", "Motion of free bodies", "Sensors"} & set(Page(written[1]).words)
    import contiga as cg

    ball = cg.Body([cg.shapes.sphere(radius=50.0, centre=(0.0, 0.0, 51.0))], name="ball")
    points = cg.clouds.sample(cg.shapes.plane(width=60.0, length=60.0), 13, 13)
    sheet = cg.Slave(points, area=np.full(169, 25.0), name="sheet")
    free = cg.motion.Free(ball.mass_properties(1e-3), velocity=[0.0, 0.0, -1.0])
    cg.Simulation(
        bodies={"ball": (ball, free)},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=cg.PenaltyLaw(1.0))],
        sensors=[cg.Sensor("top", "ball", at=[0, 0, 101.0], filter="CFC1000", criteria=["3ms"])],
        end=4.0,
        step=0.05,
        units=("mm", "g", "ms"),
        output=OutputOptions(every=10),
    ).run(tmp_path / "out")
    text = write_report(tmp_path / "out").read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    words = " ".join(page.words)
    assert {"Energy", "Motion of free bodies", "Sensors", "ball", "top"} <= set(page.words)
    assert re.search(r"at most \S+ % of the largest\s+energy", words)
    assert "CFC1000" in words
    assert "Energy of contact" not in text, "said of the whole system already"
    peak = read_run(tmp_path / "out")
    at = number(float(peak.times[np.argmax(peak.total("force"))]))
    assert f"t = {at} ms, the peak" in words, "though every tenth step is recorded"


def test_run_without_fields_says_so_in_place_of_pictures(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "out", fields=False)
    words = " ".join(Page(write_report(folder).read_text(encoding="utf-8")).words)
    assert "wrote no fields" in words
    assert not (folder / "peak.png").exists()


def test_warnings_of_the_run_are_listed(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "out", fields=False)
    summary = (folder / "summary.json").read_text(encoding="utf-8")
    summary = summary.replace('"warnings": []', '"warnings": ["3 points < lost"]')
    (folder / "summary.json").write_text(summary, encoding="utf-8")
    assert "<li>3 points &lt; lost</li>" in write_report(folder).read_text(encoding="utf-8")


def test_report_can_be_written_again_elsewhere(written: tuple[Path, str], tmp_path: Path) -> None:
    moved = tmp_path / "moved"
    shutil.copytree(written[0], moved)
    (moved / "report.html").unlink()
    assert write_report(moved) == moved / "report.html"


def test_page_that_fails_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_folder(tmp_path / "out", fields=False)
    (folder / "report.html").write_text("old", encoding="utf-8")

    monkeypatch.setattr(page_module, "page", lambda *_, **__: "half a page \ud800")
    with pytest.raises(UnicodeEncodeError):
        write_report(folder)
    assert (folder / "report.html").read_text(encoding="utf-8") == "old"
    assert len(list(folder.iterdir())) == 4


def test_page_of_a_run_with_regions_lets_choose_what_is_shown(tmp_path: Path) -> None:
    import contiga as cg

    example = Path(__file__).parents[3] / "examples" / "02_two_regions.toml"
    cg.run(cg.load_case(example), out=tmp_path / "two")
    text = (tmp_path / "two" / "report.html").read_text(encoding="utf-8")
    for name in ("penetration", "pressure", "cluster"):
        assert f'data-field="{name}"' in text
    assert re.search(r"It shows all \d+ recorded steps", text)
    assert 'aria-label="Recorded step"' in text
    assert "Colour is pressure [MPa]; lines go around the regions of contact." in text
    assert '"cluster 0"' in text
    assert '"cluster 1"' in text
