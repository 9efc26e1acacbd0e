"""A run or a study as one zip: what is in it, that links lead somewhere, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from zipfile import ZipFile

import pytest

from contiga.errors import FileError, OutputError
from contiga.report.pack import pack


def filled(folder: Path, *names: str) -> Path:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"the content of {name}", encoding="utf-8")
    return folder


RUN = ("report.html", "peak.png", "history.csv", "summary.json", "case.toml")


def test_a_run_is_its_page_numbers_and_case(tmp_path: Path) -> None:
    out = filled(tmp_path / "out", *RUN, "fields.vtkhdf", "checkpoint.h5")
    assert pack(out, tmp_path / "x.zip") == 5
    with ZipFile(tmp_path / "x.zip") as archive:
        assert sorted(archive.namelist()) == sorted(f"out/{name}" for name in RUN)
        assert archive.read("out/case.toml") == b"the content of case.toml"
    assert pack(out, tmp_path / "x.zip", fields=True) == 6


def test_links_of_a_study_lead_to_the_reports_in_the_zip(tmp_path: Path) -> None:
    cases = [f"cases/000{k}/{name}" for k in (1, 2) for name in (*RUN, "row.json", "checkpoint.h5")]
    folder = filled(tmp_path / "st", "study.json", "table.csv", *cases)
    links = [f"cases/000{k}/report.html" for k in (1, 2)]
    (folder / "study.html").write_text(f'{{"links":["{links[0]}","{links[1]}"]}}')
    pack(folder, tmp_path / "x.zip")
    with ZipFile(tmp_path / "x.zip") as archive:
        archive.extractall(tmp_path / "there")
        assert not any("checkpoint" in name for name in archive.namelist())
    page = (tmp_path / "there" / "st" / "study.html").read_text()
    for link in re.findall(r"cases/\d+/report.html", page):
        assert (tmp_path / "there" / "st" / link).is_file()


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ((), "report.html is missing"),
        (RUN[1:], "contiga report .*out"),
        (("study.json",), "study.html"),
    ],
)
def test_what_has_no_page_is_refused(tmp_path: Path, files: tuple[str, ...], message: str) -> None:
    out = filled(tmp_path / "out", "other.txt", *files)
    with pytest.raises(FileError, match=message):
        pack(out, tmp_path / "x.zip")
    assert not (tmp_path / "x.zip").exists()


def test_a_file_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    out = filled(tmp_path / "out", *RUN)
    with pytest.raises(OutputError):
        pack(out, tmp_path / "none" / "x.zip")


def test_a_study_without_cases_is_its_page(tmp_path: Path) -> None:
    out = filled(tmp_path / "st", "study.json", "study.html")
    assert pack(out, tmp_path / "x.zip") == 2


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    out = filled(tmp_path / "out", *RUN)
    with pytest.raises(FileError, match=r"x.tar: .*found '.tar'; allowed: .zip"):
        pack(out, tmp_path / "x.tar")
    assert not (tmp_path / "x.tar").exists()
