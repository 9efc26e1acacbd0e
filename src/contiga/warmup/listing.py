"""The list of kernels: `kernels.json`, which ``python -m tests.kernels`` writes.

A kernel is listed behind all those that it is built of, in the order in which a run comes to need
them. One that is not listed, or with other arguments, is compiled where it is needed. A type of
arguments is its name, as ``float64``, or a list that begins with what it is; other types in it are
rows of types above it::

    ["array", type of the numbers, dimensions, layout, whether it may be written]
    ["nested", type of the numbers, shape...], an array in a record
    ["tuple", types...]
    ["named", "module:class of the tuple", types...]
    ["reference", a named tuple]
    ["record", [[name, kind of number, shape, offset], ...], bytes, whether it is aligned]
"""

from __future__ import annotations

import json
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import from_dtype
from numba.core import types as numba_types

from contiga.jit.reference import Reference

types: Any = numba_types
FILE = Path(__file__).parent / "kernels.json"
Row = int
"""Of the list's types, or of its kernels."""


class Listed(NamedTuple):
    """A kernel of the list."""

    module: str
    name: str
    arguments: tuple[Row, ...]
    """Their types."""
    parts: tuple[Row, ...]
    """Kernels that it is built of; all stand before it."""


class Listing:
    """All kernels, and the types of their arguments.

    Parameters
    ----------
    content : of the file
    """

    def __init__(self, content: dict[str, Any]) -> None:
        self._types = content["types"]
        self._made: dict[Row, Any] = {}
        self.kernels = [
            Listed(m, n, tuple(arguments), tuple(of)) for m, n, arguments, of in content["kernels"]
        ]
        self._rows: dict[tuple[str, str], list[Row]] = {}
        for row, kernel in enumerate(self.kernels):
            self._rows.setdefault((kernel.module, kernel.name), []).append(row)

    def find(self, module: str, name: str, arguments: tuple[Any, ...]) -> Row | None:
        """The row of a kernel that takes these types; none where there is none.

        Types that cannot be made of today's sources are those of an older list.
        """
        for row in self._rows.get((module, name), ()):
            with suppress(AttributeError, ImportError, ValueError):
                if self.arguments(row) == arguments:
                    return row
        return None

    def compile(self, row: Row) -> Any:
        """The kernel of a row, with its version compiled, or read.

        Raises what compiling raises, and AttributeError or ImportError where the list is not that
        of the sources.
        """
        kernel = self.kernels[row]
        function = getattr(import_module(kernel.module), kernel.name)
        function.compile(self.arguments(row))
        return function

    def arguments(self, row: Row) -> tuple[Any, ...]:
        """Types of numba's that a kernel takes."""
        return tuple(map(self._type, self.kernels[row].arguments))

    def _type(self, row: Row) -> Any:
        if row not in self._made:
            self._made[row] = self._make(self._types[row])
        return self._made[row]

    def _make(self, code: Any) -> Any:
        if isinstance(code, str):
            return types.boolean if code == "bool" else getattr(types, code)
        what, first, *rest = code
        if what == "array":
            ndim, layout, mutable = rest
            return types.Array(self._type(first), ndim, layout, readonly=not mutable)
        if what == "reference":
            return Reference(self._type(first))
        if what == "nested":
            return types.NestedArray(self._type(first), tuple(rest))
        if what == "record":
            return _record(first, *rest)
        if what == "tuple":
            return types.BaseTuple.from_types([self._type(part) for part in (first, *rest)])
        module, _, name = first.partition(":")
        parts = [self._type(part) for part in rest]
        return types.BaseTuple.from_types(parts, getattr(import_module(module), name))


def _record(fields: list[Any], size: int, aligned: bool) -> Any:
    names, kinds, shapes, offsets = zip(*fields, strict=True)
    formats = [(kind, tuple(shape)) for kind, shape in zip(kinds, shapes, strict=True)]
    description: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": size}
    return from_dtype(np.dtype(description, align=aligned))


@cache
def listing() -> Listing:
    """The list of the package."""
    return Listing(json.loads(FILE.read_text(encoding="utf-8")))
