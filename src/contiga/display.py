"""How objects print: one line, or a small table in a notebook."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from typing import TextIO, TypeVar

Class = TypeVar("Class", bound=type)
Facts = list[tuple[str, object]]
"""Printed properties of an object: (label, value), the most important first."""


def line_of(kind: str, facts: Facts, name: str = "") -> str:
    """Return one line: ``Slave('pad', points 300, active 280)``."""
    parts = [repr(name)] if name else []
    parts += [f"{label} {_text(value)}" for label, value in facts]
    return f"{kind}({', '.join(parts)})"


def table_of(kind: str, facts: Facts, name: str = "", picture: bytes | None = None) -> str:
    """Return an HTML table of facts under kind and name; a picture (PNG) is its first row."""
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
    """Return (name, count) for each name whose count is not zero."""
    return [(name, int(n)) for name, n in zip(names, counts, strict=False) if n]


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    return str(value)


def in_notebook(stream: object) -> bool:
    """Return whether the output of `stream` appears in a notebook."""
    return type(stream).__module__.startswith("ipykernel.")


def is_read_along(stream: TextIO | None) -> bool:
    """Return whether the output of `stream` is seen at once, in a terminal or a notebook.

    Programs without a console have no stream.
    """
    return stream is not None and (in_notebook(stream) or stream.isatty())


class Displayed:
    """Mixin: an object with `_facts` prints as one line, and as a table in a notebook."""

    __slots__ = ()

    def _facts(self) -> Facts:
        raise NotImplementedError

    def _picture(self) -> bytes | None:
        """Return a PNG of at most 150 kB that a notebook shows above the facts, or None."""
        return None

    def __repr__(self) -> str:
        return line_of(type(self).__name__, self._facts(), getattr(self, "name", ""))

    def _repr_html_(self) -> str:
        name = getattr(self, "name", "")
        return table_of(type(self).__name__, self._facts(), name, self._picture())


def displayed(tuple_class: Class) -> Class:
    """Add the methods of `Displayed` to a class of named tuples, which allows no mixin."""
    for name in ("__repr__", "_repr_html_", "_picture"):
        setattr(tuple_class, name, getattr(Displayed, name))
    return tuple_class
