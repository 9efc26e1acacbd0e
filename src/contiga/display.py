"""How objects print: one line, or a small table in a notebook."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from typing import TextIO, TypeVar

Class = TypeVar("Class", bound=type)
Facts = list[tuple[str, object]]
"""What an object prints of itself: (label, value), the most important first."""


def line_of(kind: str, facts: Facts, name: str = "") -> str:
    """One line: ``Slave('pad', points 300, active 280)``."""
    first = [repr(name)] if name else []
    return f"{kind}({', '.join(first + [f'{label} {_text(value)}' for label, value in facts])})"


def table_of(kind: str, facts: Facts, name: str = "", picture: bytes | None = None) -> str:
    """Return the facts as a table of HTML; a picture (PNG) is its first row."""
    head = escape(f"{kind} {name}".strip())
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(label)}</th><td>{escape(_text(value))}</td></tr>"
        for label, value in facts
    )
    if picture is not None:
        source = f"data:image/png;base64,{b64encode(picture).decode('ascii')}"
        rows = f"<tr><td colspan='2'><img alt='{head}' src='{source}'></td></tr>{rows}"
    return f"<table><caption>{head}</caption>{rows}</table>"


def counted(names: Iterable[str], counts: Iterable[int]) -> Facts:
    """How many there are of each kind that occurs."""
    return [(name, int(n)) for name, n in zip(names, counts, strict=False) if n]


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    return str(value)


def in_notebook(stream: object) -> bool:
    """Whether what is written to `stream` appears in a notebook."""
    return type(stream).__module__.startswith("ipykernel.")


def is_read_along(stream: TextIO | None) -> bool:
    """Whether somebody sees what is written to `stream` at once: in a terminal or a notebook.

    Programs without a console have no stream.
    """
    return stream is not None and (in_notebook(stream) or stream.isatty())


class Displayed:
    """Mixed in: an object with `_facts` prints as one line, and as a table in a notebook."""

    __slots__ = ()

    def _facts(self) -> Facts:
        raise NotImplementedError

    def _picture(self) -> bytes | None:
        """A PNG of at most 150 kB that a notebook shows over the facts, if there is one."""
        return None

    def __repr__(self) -> str:
        return line_of(type(self).__name__, self._facts(), getattr(self, "name", ""))

    def _repr_html_(self) -> str:
        name = getattr(self, "name", "")
        return table_of(type(self).__name__, self._facts(), name, self._picture())


def displayed(tuple_class: Class) -> Class:
    """The same of a class of named tuples, which nothing can be mixed into; a decorator."""
    for name in ("__repr__", "_repr_html_", "_picture"):
        setattr(tuple_class, name, getattr(Displayed, name))
    return tuple_class
