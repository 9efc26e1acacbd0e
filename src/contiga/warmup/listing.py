"""The list of kernels: `kernels.json`, which ``python -m tests.kernels`` writes.

A kernel is listed after all kernels that it calls, in the order in which a run needs them. A kernel
that is not listed, or with other arguments, is compiled when it is needed. A type of arguments is
its name, as ``float64``, or a list that begins with its kind; other types in it are rows of types
above it::

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
"""Row of the list's types, or of its kernels."""


class Listed(NamedTuple):
    """A kernel of the list."""

    module: str
    name: str
    arguments: tuple[Row, ...]
    """Types of its arguments."""
    parts: tuple[Row, ...]
    """Kernels that it calls; all stand before it."""


class Listing:
    """All kernels, and the types of their arguments.

    Parameters
    ----------
    content : content of the file
    """

    def __init__(self, content: dict[str, Any]) -> None:
        self._codes = content["types"]
        self._types: dict[Row, Any] = {}
        self.kernels = [
            Listed(module, name, tuple(arguments), tuple(parts))
            for module, name, arguments, parts in content["kernels"]
        ]
        self._rows: dict[tuple[str, str], list[Row]] = {}
        for row, kernel in enumerate(self.kernels):
            self._rows.setdefault((kernel.module, kernel.name), []).append(row)

    def find(self, module: str, name: str, arguments: tuple[Any, ...]) -> Row | None:
        """Return the row of a kernel that takes these types; None if it is not listed.

        Types that cannot be made from the current sources belong to an older list.
        """
        for row in self._rows.get((module, name), ()):
            with suppress(AttributeError, ImportError, ValueError):
                if self.arguments(row) == arguments:
                    return row
        return None

    def compile(self, row: Row) -> Any:
        """Return the kernel of a row, compiled or read from the cache.

        Raises the errors of compiling, and AttributeError or ImportError if the list does not
        belong to the sources.
        """
        kernel = self.kernels[row]
        function = getattr(import_module(kernel.module), kernel.name)
        function.compile(self.arguments(row))
        return function

    def arguments(self, row: Row) -> tuple[Any, ...]:
        """Return the numba types of a kernel's arguments."""
        return tuple(map(self._type, self.kernels[row].arguments))

    def _type(self, row: Row) -> Any:
        """Return the numba type of a row, made when it is first asked for."""
        if row not in self._types:
            self._types[row] = self._type_of(self._codes[row])
        return self._types[row]

    def _type_of(self, code: Any) -> Any:
        """Return the numba type of a code of the list, as the module describes it.

        Raises AttributeError, ImportError or ValueError if the sources have no such type any more.
        """
        if isinstance(code, str):
            return types.boolean if code == "bool" else getattr(types, code)
        kind, first, *others = code
        if kind == "array":
            ndim, layout, mutable = others
            return types.Array(self._type(first), ndim, layout, readonly=not mutable)
        if kind == "reference":
            return Reference(self._type(first))
        if kind == "nested":
            return types.NestedArray(self._type(first), tuple(others))
        if kind == "record":
            size, aligned = others
            names, kinds, shapes, offsets = zip(*first, strict=True)
            formats = [(kind, tuple(shape)) for kind, shape in zip(kinds, shapes, strict=True)]
            fields: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": size}
            return from_dtype(np.dtype(fields, align=aligned))
        if kind == "tuple":
            return types.BaseTuple.from_types([self._type(part) for part in (first, *others)])
        module, _, name = first.partition(":")
        parts = [self._type(part) for part in others]
        return types.BaseTuple.from_types(parts, getattr(import_module(module), name))


@cache
def listing() -> Listing:
    """Return the list of the package, which a process reads once."""
    return Listing(json.loads(FILE.read_text(encoding="utf-8")))
