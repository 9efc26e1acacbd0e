"""Write the table of public names, ``docs/names.md``: ``python docs/make_names.py``.

Every name of `contiga`, and the methods and properties of its classes, with the first line of what
is said of it. Who changes it changes what users rely on, and gives the change a line in CHANGELOG.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import contiga

PAGE = Path(__file__).with_name("names.md")
HEAD = """# All names, a line each

*Made by `docs/make_names.py`. [Public names](api.rst) has all of each.*

| name | what it is |
|---|---|
"""


def page() -> str:
    """The page."""
    return HEAD + "".join(f"| `{name}` | {line} |\n" for name, line in _rows())


def _rows() -> Iterator[tuple[str, str]]:
    for name in sorted(contiga.__all__, key=str.lower):
        if name == "__version__":
            continue
        value = getattr(contiga, name)
        yield name, _first_line(value)
        if inspect.isclass(value) and value.__module__.startswith("contiga."):
            for member in sorted(set(_members(value))):
                yield f"{name}.{member}", _first_line(inspect.getattr_static(value, member))


def _members(kind: type) -> Iterator[str]:
    """Methods and properties that a class of ours gives, those of its parents of ours too.

    What pydantic has put into the classes of cases is left out: it begins with ``model_``.
    """
    fields = getattr(kind, "_fields", ())
    for parent in kind.__mro__:
        if parent.__module__.startswith("contiga."):
            for name, value in vars(parent).items():
                if not name.startswith(("_", "model_")) and name not in fields and _is_said(value):
                    yield name


def _is_said(value: Any) -> bool:
    return bool(_first_line(value)) and (callable(value) or hasattr(value, "__get__"))


def _first_line(value: Any) -> str:
    if isinstance(value, (classmethod, staticmethod)):
        value = value.__func__
    text = inspect.getdoc(value) or ""
    return text.partition("\n")[0].replace("|", r"\|")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.exit(0)
