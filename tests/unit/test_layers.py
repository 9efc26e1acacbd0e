"""The rooms stand on one another: imports run downward, inside functions too, in no circle."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
Graph = dict[str, set[str]]


def modules_of(source: Path) -> dict[str, Path]:
    """The files below a folder by the name they are imported by."""
    values = {}
    for path in sorted(source.rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        values[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return values


def imports_of(source: Path, *, typed: bool = False) -> Graph:
    """What each module imports when it runs, at its top or inside a function.

    With `typed` what only type checkers read counts too.
    """
    modules = modules_of(source)
    return {n: set(_imported(path, modules, typed)) - {n} for n, path in modules.items()}


def _imported(path: Path, modules: dict[str, Path], typed: bool) -> Iterator[str]:
    for node in _below(ast.parse(path.read_text(encoding="utf-8")), typed):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in modules else node.module


def _below(node: ast.AST, typed: bool) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        if not typed and isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        yield child
        yield from _below(child, typed)


def circles_of(graph: Graph) -> list[list[str]]:
    """Sets of modules each of which leads to all the others (Tarjan, 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    circles = []

    def visit(name: str) -> None:
        index[name] = low[name] = len(index)
        stack.append(name)
        for other in sorted(graph[name]):
            if other not in index:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], index[other])
        if low[name] == index[name]:
            at = stack.index(name)
            if len(stack) - at > 1:
                circles.append(sorted(stack[at:]))
            del stack[at:]

    for name in graph:
        if name not in index:
            visit(name)
    return circles


def upward(graph: Graph, floors: list[list[str]]) -> list[str]:
    """Imports from a room into one above it, or into another on its own floor."""
    return [
        f"{name} -> {other}"
        for name, others in sorted(graph.items())
        for other in sorted(others)
        if not _allowed(name, other, floors)
    ]


def _allowed(name: str, other: str, floors: list[list[str]]) -> bool:
    here, there = _place(name, floors), _place(other, floors)
    return here is None or there is None or here == there or here[0] < there[0]


def _place(name: str, floors: list[list[str]]) -> tuple[int, int] | None:
    """Floor from the top and room of a module; none for the packages and their entry."""
    for floor, rooms in enumerate(floors):
        for k, room in enumerate(rooms):
            if name == room or name.startswith(f"{room}."):
                return floor, k
    return None


@pytest.fixture(scope="module")
def graph() -> Graph:
    return imports_of(ROOT / "src")


@pytest.fixture(scope="module")
def typed() -> Graph:
    """What type checkers read, too."""
    return imports_of(ROOT / "src", typed=True)


@pytest.fixture(scope="module")
def contract() -> dict[str, object]:
    with (ROOT / "pyproject.toml").open("rb") as file:
        data: dict[str, object] = tomllib.load(file)["tool"]["importlinter"]["contracts"][0]
    return data


@pytest.fixture(scope="module")
def floors(contract: dict[str, object]) -> list[list[str]]:
    layers = contract["layers"]
    assert isinstance(layers, list)
    return [layer.split(" | ") for layer in layers]


def test_no_module_imports_itself_in_a_circle(graph: Graph) -> None:
    assert circles_of(graph) == []


def test_no_module_needs_itself_in_a_circle_for_its_types(typed: Graph) -> None:
    """What a file reads of one above it stands in a Protocol below both."""
    # For type checkers it lists all public names.
    graph = {name: others for name, others in typed.items() if name != "contiga"}
    assert circles_of({name: others - {"contiga"} for name, others in graph.items()}) == []


def test_imports_run_downward_for_type_checkers_too(typed: Graph, floors: list[list[str]]) -> None:
    assert upward(typed, floors) == []


def test_every_module_has_a_floor(graph: Graph, floors: list[list[str]]) -> None:
    assert [m for m in graph if _place(m, floors) is None] == ["contiga", "contiga.__main__"]


def test_no_import_is_excused(contract: dict[str, object]) -> None:
    assert "ignore_imports" not in contract


def test_a_circle_and_a_way_up_are_seen_inside_functions_too(tmp_path: Path) -> None:
    for name, text in {
        "low": "def f():\n    from house.high import g\n    return g\n",
        "high": "from house import low\n\ndef g():\n    return low.f\n",
        "typed": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import house.high\n",
    }.items():
        (tmp_path / "house").mkdir(exist_ok=True)
        (tmp_path / "house" / f"{name}.py").write_text(text)
    (tmp_path / "house" / "__init__.py").write_text("")
    graph = imports_of(tmp_path)
    assert circles_of(graph) == [["house.high", "house.low"]]
    assert upward(graph, [["house.high"], ["house.low", "house.typed"]]) == [
        "house.low -> house.high"
    ]
    assert graph["house.typed"] == set()
    assert imports_of(tmp_path, typed=True)["house.typed"] == {"house.high"}
