"""The pages: links that lead somewhere, cases that are valid, examples that run, true commands."""

from __future__ import annotations

import importlib
import pkgutil
import re
import runpy
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
import typer

import contiga as cg
import contiga.case
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
from contiga.cli.commands import app
from contiga.io.mesh.lsdyna_model import read_model
from contiga.io.units import derived_units
from contiga.studies.cases import cases_of
from contiga.studies.spec import (
    GoalSpec,
    MapSpec,
    RuleSpec,
    SampleSpec,
    StudySpec,
    VariableSpec,
    study_of,
)

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
RUN_ELSEWHERE = {"tutorial.md", "gallery.md"}
"""Their cases need files: tests/cases/test_tutorial.py and test_gallery.py do all they say."""
PAGES_OF_TABLES = {
    "material_spec": ("matter.md",),
    "deform_spec": ("matter.md",),
    "joint_spec": ("joints.md",),
    "belt_spec": ("belts.md",),
    "device_spec": ("belt-devices.md",),
    "gas_spec": ("loads.md",),
}
"""Pages beside case.md that have the keys of a module of `contiga.case`."""


def blocks(language: str) -> list[tuple[str, str]]:
    """``(page, text)`` of every fenced block in a language."""
    return [
        (page.name, text)
        for page in PAGES
        for text in re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
    ]


def test_links_lead_somewhere() -> None:
    assert runpy.run_path(str(ROOT / "docs" / "check_links.py"))["broken_links"]() == []


def test_every_page_is_in_the_site(tmp_path: Path) -> None:
    """A page that is called as one of Sphinx's own was there once, and nobody could read it."""
    lost = runpy.run_path(str(ROOT / "docs" / "check_links.py"))["lost_pages"]
    assert lost() == []
    (tmp_path / "index.rst").write_text(".. toctree::\n\n   search\n", encoding="utf-8")
    for name in ("search.md", "alone.md", "README.md"):
        (tmp_path / name).write_text("# A page\n", encoding="utf-8")
    assert [line.split(":")[0] for line in lost(tmp_path)] == ["alone.md", "search.md"]


@pytest.mark.parametrize(
    ("page", "text"), [block for block in blocks("toml") if block[0] not in RUN_ELSEWHERE]
)
def test_case_on_a_page_is_valid(page: str, text: str) -> None:
    data = tomllib.loads(text)
    if "collect" in data:
        assert cases_of(study_of(data, ROOT / "examples" / "study.toml"))
    else:
        assert parse_case(text, ROOT / page).contact


def test_pages_show_a_case_and_a_program() -> None:
    assert {"README.md", "case.md"} <= {page for page, _ in blocks("toml")}
    assert "README.md" in {page for page, _ in blocks("python")}


@pytest.mark.parametrize("page", sorted({page for page, _ in blocks("python")} - RUN_ELSEWHERE))
def test_programs_on_a_page_run(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    """One after the other, as a reader would: a later one may go on from those before it."""
    names: dict[str, object] = {}
    for text in (text for name, text in blocks("python") if name == page):
        exec(compile(text, page, "exec"), names)
        expected = re.findall(r"print\(.*#\s*(.+)$", text, re.M)
        assert capsys.readouterr().out.split("\n")[:-1] == expected


@pytest.mark.parametrize(
    "spec", [UnitsSpec, TimeSpec, BodySpec, SlaveSpec, ContactSpec, OutputSpec]
)
def test_every_key_of_a_case_is_on_its_page(spec: type[Spec]) -> None:
    page = (ROOT / "docs" / "case.md").read_text(encoding="utf-8")
    assert [key for key in spec.model_fields if f"`{key}`" not in page] == []


def specs_of_cases() -> dict[str, list[type[Spec]]]:
    """All tables of a case file, by the module of `contiga.case` that they are in."""
    for module in pkgutil.iter_modules(contiga.case.__path__):
        importlib.import_module(f"contiga.case.{module.name}")
    found: dict[str, list[type[Spec]]] = {}
    waiting = [Spec]
    for spec in waiting:
        waiting += spec.__subclasses__()
        if spec.__module__.startswith("contiga.case."):
            found.setdefault(spec.__module__.removeprefix("contiga.case."), []).append(spec)
    return found


def test_every_key_of_a_table_is_on_the_page_of_cases_or_of_its_subject() -> None:
    specs, missing = specs_of_cases(), []
    assert {"law_spec", "sensor_spec", *PAGES_OF_TABLES} <= set(specs)
    for module, group in specs.items():
        pages = ["case.md", *PAGES_OF_TABLES.get(module, ())]
        texts = [(ROOT / "docs" / page).read_text(encoding="utf-8") for page in pages]
        words = set(re.findall(r"\w+", " ".join(texts)))
        keys = {field.alias or key for spec in group for key, field in spec.model_fields.items()}
        missing += [f"{module}: {key} in {' or '.join(pages)}" for key in sorted(keys - words)]
    assert missing == []


@pytest.mark.parametrize("spec", [StudySpec, VariableSpec, SampleSpec, RuleSpec, GoalSpec, MapSpec])
def test_every_key_of_a_study_is_on_its_page(spec: type[Spec]) -> None:
    page = (ROOT / "docs" / "study.md").read_text(encoding="utf-8")
    matches = re.findall(r"[A-Za-z_]+", page)
    assert [key for key in spec.model_fields if key not in matches] == []


def test_the_table_of_public_names_is_current() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_names.py"))
    assert made["PAGE"].read_text(encoding="utf-8") == made["page"](), (
        "what users rely on has changed: run python docs/make_names.py, and say so in CHANGELOG.md"
    )


def test_the_page_of_conventions_is_current() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_conventions.py"))
    assert made["PAGE"].read_text(encoding="utf-8") == made["page"](), (
        "run python docs/make_conventions.py"
    )


def test_units_on_the_page_of_conventions_are_those_of_the_labels() -> None:
    page = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+), (\w+), (\w+) \| (\w+) \| (\w+) \|$", page, re.M)
    rows = [row for row in rows if row[0] != "length"]
    assert len(rows) == 4
    for length, mass, time, force, stress in rows:
        derived = derived_units(length, mass, time)
        assert (derived["force"], derived["stress"]) == (force, stress)


def quoted() -> list[tuple[str, str]]:
    """``(file, text)`` of every block that a page quotes from a file it names just before."""
    result = re.compile(r"`([\w/.]+)`:\n\n```py\n(.*?)```", re.S)
    return [match for page in PAGES for match in result.findall(page.read_text(encoding="utf-8"))]


def test_quoted_code_stands_in_its_file() -> None:
    assert len(quoted()) == len(blocks("py")) == 2
    for file, text in quoted():
        assert text in (ROOT / file).read_text(encoding="utf-8"), file


def test_tests_named_on_the_page_of_attacks_exist() -> None:
    tests = ROOT / "tests"
    named = re.findall(
        r"`([\w/]+\.py|test_\w+)`", (tests / "stress" / "README.md").read_text("utf-8")
    )
    files = [
        path.as_posix() for folder in (tests, ROOT / "benchmarks") for path in folder.rglob("*.py")
    ]
    defined = {
        name
        for path in tests.rglob("test_*.py")
        for name in re.findall(r"^def (test_\w+)", path.read_text("utf-8"), re.M)
    }
    there = [name in defined or any(file.endswith(f"/{name}") for file in files) for name in named]
    assert len(named) > 25
    assert [name for name, found in zip(named, there, strict=True) if not found] == []


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("add-a*.md")), ids=lambda p: p.stem)
def test_files_and_constants_named_in_a_guide_exist(page: Path) -> None:
    """A file is named by the end of its path, a constant or a private function by its own name."""
    sources = [path for folder in ("src", "tests") for path in (ROOT / folder).rglob("*.py")]
    files = [path.as_posix() for path in sources]
    words = set(re.findall(r"\w+", " ".join(path.read_text("utf-8") for path in sources)))
    text = page.read_text("utf-8")
    named, constants = (
        set(re.findall(pattern, text)) for pattern in (r"`([\w/]+\.py)`", r"`(_?[A-Z]\w+|_\w+)`")
    )
    assert len(named) > 0
    assert [name for name in named if not any(file.endswith(f"/{name}") for file in files)] == []
    assert constants - words == set()


def test_files_named_at_the_heads_of_rooms_exist() -> None:
    heads = [
        path for path in (ROOT / "src/contiga").rglob("__init__.py") if path.parts[-2] != "kernels"
    ]
    lost, total = [], 0
    for path in heads:
        room = importlib.import_module(".".join(path.parent.relative_to(ROOT / "src").parts))
        there = {file.stem for file in [*path.parent.rglob("*"), *path.parent.parent.iterdir()]}
        named = re.findall(r"`([a-z_]+)`", room.__doc__ or "")
        total += len(named)
        lost += [
            f"{path.parent.name}: {name}" for name in named if name not in {*there, *dir(room)}
        ]
    assert total > 200
    assert lost == []


def test_every_public_name_is_in_the_reference() -> None:
    reference = (ROOT / "docs" / "api.rst").read_text(encoding="utf-8")
    named = set(re.findall(r"^\.\. auto\w+:: ([\w.]+)$", reference, re.M))
    public = {name: getattr(cg, name) for name in cg.__all__ if name != "__version__"}
    for name, value in public.items():
        full = value.__name__ if not hasattr(value, "__qualname__") else f"contiga.{name}"
        assert full in named, name


def test_the_first_pages_stay_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120
    assert len((ROOT / "docs" / "performance.md").read_text(encoding="utf-8").split()) <= 1200


OLD_WORDS = re.compile(
    r"turn it about|goes? right\s+through|went right\s+through|is no share|in one way, how time"
    r"|misses one says which|followed is dear|\bstrand\b|\bskirt\b|\bdetours\b"
    r"|\bglance\b|by_reference|whole_scratch|house goes back|as far apart as they were"
    r"|met what is stiffer|swings on what|tries a step|says no format",
    re.I,
)


def test_words_that_puzzled_are_gone() -> None:
    sources = [path for path in (ROOT / "src").rglob("*") if path.suffix in (".py", ".js", ".css")]
    read = [*PAGES, ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", *sources]
    assert [p.name for p in read if OLD_WORDS.search(p.read_text(encoding="utf-8"))] == []


def test_the_glossary_has_each_word_once() -> None:
    page = (ROOT / "docs" / "development.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\*\*.+?) \| .+ \|$", page.split("## Glossary")[1], re.M)
    words = [word for row in rows for word in re.findall(r"\*\*(.+?)\*\*", row)]
    assert len(words) == len(set(words)) > 40


def test_cards_that_are_not_read_are_listed_by_convert(tmp_path: Path) -> None:
    """The page for users of crash codes says of each card of LS-DYNA whether it is read."""
    page = (ROOT / "docs" / "for-dyna-users.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.+?) \| .+ \| no \|$", page, re.M)
    cards = sorted({card for row in rows for card in re.findall(r"`(\*[A-Z_]{8,})`", row)})
    assert len(cards) > 6
    node = "*NODE\n       1             0.0             0.0             0.0\n"
    deck = tmp_path / "deck.k"
    deck.write_text("*KEYWORD\n" + node + "\n".join(cards) + "\n*END\n", encoding="utf-8")
    assert set(read_model(deck).unknown) >= set(cards)


FENCED = re.compile(r"^```(.*)\n((?:.|\n)*?)^```$", re.M)
COMMAND: Any = typer.main.get_command(app)


def synopsis() -> dict[str, str]:
    """Each command as the page of the command line shows it."""
    page = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    block = re.search(r"```\n(.*?)```", page, re.S)
    assert block is not None
    return dict(re.findall(r"^contiga (\w+)(.*)$", block.group(1), re.M))


def test_the_command_line_has_the_commands_of_its_page_and_no_others() -> None:
    assert set(synopsis()) == set(COMMAND.commands)


@pytest.mark.parametrize("name", sorted(COMMAND.commands))
def test_a_command_has_the_options_of_its_page_and_no_others(name: str) -> None:
    shown = set(re.findall(r"(?<![\w-])(--?[a-z][a-z-]*)", synopsis()[name]))
    options = [p for p in COMMAND.commands[name].params if p.param_type_name == "option"]
    for option in options:
        spelt = set(option.opts) & shown
        assert spelt, option.opts
        shown -= spelt
    assert shown == set()


def commands() -> list[tuple[str, str]]:
    """``(page, line)`` of the commands on all pages, with what they are given."""
    values = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        plain = [block for kind, block in FENCED.findall(text) if not kind]
        lines = re.findall(r"^contiga (.+?)(?:\s+#.*)?$", "\n".join(plain), re.M)
        lines += re.findall(r"`contiga (\w+ [^`]+)`", FENCED.sub("", text))
        values += [(page.name, line) for line in lines if "[" not in line and line[0] != "-"]
    return values


@pytest.mark.parametrize(("page", "line"), commands())
def test_a_command_on_a_page_is_understood(page: str, line: str) -> None:
    name, *arguments = shlex.split(line)
    command = COMMAND.commands[name]
    about_a_file = any(p.param_type_name == "argument" for p in command.params)
    if about_a_file and (not arguments or arguments[0].startswith("-")):
        arguments.insert(0, "FILE")  # sentences leave it out
    command.make_context(name, arguments)


def test_pages_show_commands() -> None:
    assert {page for page, _ in commands()} >= {"README.md", "reproduce.md", "command-line.md"}
