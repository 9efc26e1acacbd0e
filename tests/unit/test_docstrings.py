"""Docstrings of functions describe all parameters, and none that a function does not have."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

SOURCES = Path(__file__).resolve().parents[2] / "src" / "contiga"
_SECTION = re.compile(r"^Parameters\n-{10}\n(.*?)(?=\n\n\S|\Z)", re.M | re.S)
_ENTRY = re.compile(r"^([*\w]+(?:, [*\w]+)*) : \S", re.M)


class Described(NamedTuple):
    """A function and the parameters that its docstring describes."""

    place: str
    parameters: list[str]
    optional: set[str]
    described: list[str]


def described_in(source: str, place: str) -> Iterator[Described]:
    """Yield the functions whose docstrings have a section of parameters."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
            continue
        section = _SECTION.search(ast.get_docstring(node) or "")
        if section is None:
            continue
        entries = _ENTRY.findall(section.group(1))
        described = [name.lstrip("*") for entry in entries for name in entry.split(", ")]
        arguments = node.args
        names = [
            one.arg for one in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
        ]
        rest = {one.arg for one in (arguments.vararg, arguments.kwarg) if one is not None}
        required = [name for name in names if name not in ("self", "cls") or name in described]
        yield Described(f"{place}:{node.lineno} {node.name}", required, rest, described)


def test_each_parameter_is_described_once() -> None:
    found = [
        one
        for path in sorted(SOURCES.rglob("*.py"))
        if "kernels" not in path.parts
        for one in described_in(path.read_text(encoding="utf-8"), str(path.relative_to(SOURCES)))
    ]
    assert len(found) > 150
    wrong = {
        one.place: (one.parameters, one.described)
        for one in found
        if sorted(one.parameters) != sorted(set(one.described) - one.optional)
        or len(set(one.described)) != len(one.described)
    }
    assert not wrong


@pytest.mark.parametrize(
    ("signature", "section", "right"),
    [
        ("a, b", "a : one\n    b : two", True),
        ("a, b", "a, b : both", True),
        ("a, b", "a : one", False),
        ("a", "a : one\n    b : two", False),
        ("a, *rest", "a : one", True),
        ("a, *rest", "a : one\n    *rest : more\n        lines", True),
    ],
)
def test_a_missing_and_a_stale_description_are_found(
    signature: str, section: str, right: bool
) -> None:
    head = "Parameters\n    ----------\n"
    source = f'def f({signature}):\n    """Sum.\n\n    {head}    {section}\n    """'
    (one,) = described_in(source, "here")
    assert (sorted(one.parameters) == sorted(set(one.described) - one.optional)) is right
