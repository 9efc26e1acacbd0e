"""The pages: links that lead somewhere, cases that are valid, examples that run."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from contiga.case.contact_spec import ContactSpec
from contiga.case.schema import (
    BodySpec,
    OutputSpec,
    SlaveSpec,
    TimeSpec,
    UnitsSpec,
    parse_case,
)
from contiga.case.spec import Spec

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(language: str) -> list[tuple[str, str]]:
    """``(page, text)`` of every fenced block in a language."""
    return [
        (page.name, text)
        for page in PAGES
        for text in re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
    ]


def test_links_lead_somewhere() -> None:
    assert runpy.run_path(str(ROOT / "docs" / "check_links.py"))["broken_links"]() == []


@pytest.mark.parametrize(("page", "text"), blocks("toml"))
def test_case_on_a_page_is_valid(page: str, text: str) -> None:
    assert parse_case(text, ROOT / page).contact


def test_pages_show_a_case_and_a_program() -> None:
    assert {"README.md", "case.md"} <= {page for page, _ in blocks("toml")}
    assert "README.md" in {page for page, _ in blocks("python")}


@pytest.mark.parametrize(("page", "text"), blocks("python"))
def test_program_on_a_page_runs(page: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(text, page, "exec"), {})
    expected = re.findall(r"print\(.*#\s*(.+)$", text, re.M)
    assert capsys.readouterr().out.split("\n")[:-1] == expected


@pytest.mark.parametrize(
    "spec", [UnitsSpec, TimeSpec, BodySpec, SlaveSpec, ContactSpec, OutputSpec]
)
def test_every_key_of_a_case_is_on_its_page(spec: type[Spec]) -> None:
    page = (ROOT / "docs" / "case.md").read_text(encoding="utf-8")
    assert [key for key in spec.model_fields if f"`{key}`" not in page] == []
