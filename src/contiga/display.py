"""How objects print: one line, or a small table in a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TypeVar

Class = TypeVar("Class", bound=type)
Facts = list[tuple[str, object]]
"""What an object prints of itself: (label, value), the most important first."""


def line_of(kind: str, facts: Facts, name: str = "") -> str:
    """One line: ``Slave('pad', points 300, active 280)``."""
    first = [repr(name)] if name else []
    return f"{kind}({', '.join(first + [f'{label} {_text(value)}' for label, value in facts])})"


def table_of(kind: str, facts: Facts, name: str = "") -> str:
    """The same as a table of HTML."""
    head = escape(f"{kind} {name}".strip())
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(label)}</th><td>{escape(_text(value))}</td></tr>"
        for label, value in facts
    )
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


class Displayed:
    """Mixed in: an object with `_facts` prints as one line, and as a table in a notebook."""

    __slots__ = ()

    def _facts(self) -> Facts:
        raise NotImplementedError

    def __repr__(self) -> str:
        return line_of(type(self).__name__, self._facts(), getattr(self, "name", ""))

    def _repr_html_(self) -> str:
        return table_of(type(self).__name__, self._facts(), getattr(self, "name", ""))


def displayed(tuple_class: Class) -> Class:
    """The same of a class of named tuples, which nothing can be mixed into; a decorator."""
    for name in ("__repr__", "_repr_html_"):
        setattr(tuple_class, name, getattr(Displayed, name))
    return tuple_class
