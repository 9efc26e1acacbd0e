"""Record what users rely on in ``docs/public_surface.txt``: ``python docs/make_surface.py``.

Done at a release. Every public name with its signature, and how many lines of the topmost section
of CHANGELOG.md name it. A test compares: what differs from the record must stand in more lines than
it did then.
"""

from __future__ import annotations

import enum
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import contiga

RECORD = Path(__file__).with_name("public_surface.txt")
CHANGES = Path(__file__).parents[1] / "CHANGELOG.md"
SIMPLE = (bool, int, float, str, type(None))


def surface() -> dict[str, str]:
    """The signature of every public name, by its dotted name; of a constant its kind."""
    return dict(_of_names(contiga, [n for n in contiga.__all__ if n != "__version__"], ""))


def mentions(name: str, changes: str) -> int:
    """Lines of the topmost section of a change log that have the last part of a name as code."""
    section = changes.split("\n## ")[1]
    word = re.compile(rf"(?<!\w){re.escape(name.rpartition('.')[2])}(?!\w)")
    quoted = ("".join(re.findall(r"`[^`]*`", line)) for line in section.splitlines())
    return sum(bool(word.search(code)) for code in quoted)


def text(changes: str) -> str:
    """The record of now."""
    rows = (f"{mentions(n, changes):3d} {n}{s}" for n, s in sorted(surface().items()))
    return "".join(f"{row}\n" for row in rows)


def read(record: str) -> dict[str, tuple[str, int]]:
    """Of a record: signature and number of mentions, by name."""
    rows = re.findall(r"^ *(\d+) ([\w.]+)(.*)$", record, re.M)
    return {name: (signature, int(count)) for count, name, signature in rows}


def unsaid(now: dict[str, str], record: str, changes: str) -> list[str]:
    """What has come, gone or changed since the record without a new line in CHANGELOG."""
    before = read(record)
    differ = {n for n in now.keys() | before if now.get(n) != before.get(n, (None, 0))[0]}
    # Members go and come with their class: the line of the class is theirs.
    whole = {n for n in differ if (n in now) != (n in before)}
    asked = {n for n in differ if n.rpartition(".")[0] not in whole}
    return sorted(n for n in asked if mentions(n, changes) <= before.get(n, ("", 0))[1])


def _of_names(owner: Any, names: list[str], prefix: str) -> Iterator[tuple[str, str]]:
    for name in names:
        in_class = inspect.isclass(owner)  # where getattr would ask properties
        value = inspect.getattr_static(owner, name, None) if in_class else getattr(owner, name)
        if isinstance(value, (classmethod, staticmethod)):
            value = value.__func__
        yield prefix + name, _signature(value)
        if inspect.isclass(value) and value.__module__.startswith("contiga"):
            yield from _of_names(value, _members(value), f"{prefix}{name}.")
        elif isinstance(value, ModuleType):
            yield from _of_names(value, _public(value), f"{prefix}{name}.")


def _public(module: ModuleType) -> list[str]:
    """What a module is for: its `__all__`, or what is defined in it."""
    listed = getattr(module, "__all__", None)
    if listed is not None:
        return sorted(listed)
    return sorted(
        name
        for name, value in vars(module).items()
        if not name.startswith("_") and getattr(value, "__module__", None) == module.__name__
    )


def _members(kind: type) -> list[str]:
    """Public attributes that a class of ours gives, those of its parents of ours too."""
    names: set[str] = set()
    for parent in kind.__mro__:
        if parent.__module__.startswith("contiga"):
            names |= {*vars(parent), *inspect.get_annotations(parent)}
    return sorted(name for name in names if not name.startswith(("_", "model_")))


def _signature(value: Any) -> str:
    if inspect.isclass(value) and issubclass(value, enum.Enum):
        return " = " + ", ".join(f"{m.name}:{m.value}" for m in value)
    # How protocols and models of pydantic are called is not ours, and changes with Python and it.
    if getattr(value, "_is_protocol", False) or hasattr(value, "model_fields"):
        return ""
    if isinstance(value, property) or not callable(value):
        return ""
    try:
        given = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):
        return ""
    return f"({', '.join(_spelt(list(given)))})"


def _spelt(given: list[inspect.Parameter]) -> Iterator[str]:
    starred = False
    for one in given:
        if one.name in ("self", "cls"):
            continue
        if one.kind is one.VAR_POSITIONAL:
            starred = True
            yield f"*{one.name}"
            continue
        if one.kind is one.VAR_KEYWORD:
            yield f"**{one.name}"
            continue
        if one.kind is one.KEYWORD_ONLY and not starred:
            starred = True
            yield "*"
        simple = isinstance(one.default, SIMPLE) and not isinstance(one.default, enum.Enum)
        default = repr(one.default) if simple else "…"
        yield one.name if one.default is one.empty else f"{one.name}={default}"


if __name__ == "__main__":
    RECORD.write_text(text(CHANGES.read_text(encoding="utf-8")), encoding="utf-8")
    sys.exit(0)
