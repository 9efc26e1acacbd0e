"""The evidence is a user of the library: it imports public names of contiga, and a few tools."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import contiga

SOURCE = Path(contiga.__file__).resolve().parents[1] / "contiga_validation"
ROOMS = {
    name: room.__name__
    for name in contiga.__all__
    if isinstance(room := getattr(contiga, name), ModuleType)
}
TOOLS = {
    "contiga.arrays.threads: thread_count",
    "contiga.io.out: files",
    "contiga.report: style",
    "contiga.report.view: View",
    "contiga.simulation.clock: Clock",
}
"""What it draws, writes and times with, as reports and runs do; no result depends on it."""
MODULES = {name for name, home in ROOMS.items() if home == f"contiga.{name}"} | {"matter.iga"}
"""Public names that are modules under that very name; the others come ``from contiga``. Shells of
splines are a public room below one."""


def internals_in(path: Path) -> Iterator[str]:
    """What a file takes from inside of contiga, anywhere in it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    rooms = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
            yield from (n for n in names if n.startswith("contiga.") and n[8:] not in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.module == "contiga":
            given = {alias.name: alias.asname or alias.name for alias in node.names}
            yield from (f"contiga.{name}" for name in given.keys() - set(contiga.__all__))
            rooms |= {own for name, own in given.items() if name in ROOMS}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("contiga."):
            names = [alias.name for alias in node.names]
            if str(node.module)[8:] not in MODULES or any(name[0] == "_" for name in names):
                yield f"{node.module}: {', '.join(names)}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from re.findall(r"^contiga(?:\.\w+)+$", node.value)
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(value=ast.Name(id=name), attr=attribute):
                if name in rooms and attribute.startswith("_"):
                    yield f"{name}.{attribute}"


def test_the_evidence_takes_public_names_only() -> None:
    files = sorted(SOURCE.rglob("*.py"))
    actual = {path.name: [t for t in internals_in(path) if t not in TOOLS] for path in files}
    assert len(files) > 25
    assert {name: taken for name, taken in actual.items() if taken} == {}


def test_what_is_taken_from_inside_is_seen_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "suite.py"
    path.write_text(
        "import contiga\n"
        "import contiga.search.sweep.piece_lists\n"
        "from contiga import Body, records, motion as look\n"
        "from contiga.errors import InputError\n"
        "def f():\n"
        "    from contiga.area.hull import hull_of\n"
        "    look._secret(look.Free)\n"
        "    return import_module('contiga.rigid.frames'), 'contiga_validation.engine'\n"
    )
    assert sorted(internals_in(path)) == [
        *("contiga.area.hull: hull_of", "contiga.records", "contiga.rigid.frames"),
        *("contiga.search.sweep.piece_lists", "look._secret"),
    ]
