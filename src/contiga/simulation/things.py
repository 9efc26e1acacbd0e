"""Add laws, methods and what stands in them to a fingerprint: numbers, arrays and code.

Code is followed wherever it is the user's own: methods, constants of classes, slots, closures, and
the functions and constants of modules that it names, however far away. Of packages that are
installed the name and the version stand for their code, and of their objects that are only named
(a logger, a cache) the kind. What is left says nothing of itself, and is told to be `unknown`.
"""

from __future__ import annotations

import dis
import sys
import sysconfig
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from enum import IntEnum
from functools import cached_property
from itertools import chain
from numbers import Number
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CodeType,
    FunctionType,
    MappingProxyType,
    MethodType,
    ModuleType,
)
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.digest import Digest

# Arguments a function is tried at, beside its code: strains, penetrations and rates.
_TRIED = np.array([0.0, 1e-6, 1e-3, 0.03, 0.3])
# Objects inside objects, inside objects…: beyond this data tell their kind only.
_DEEPEST = 8
# Data of Python that hold others.
_PLAIN = (tuple, list, dict, set, frozenset, range, MappingProxyType)
_KNOWN = {*sys.stdlib_module_names, "contiga", "numpy", "numba", "scipy"}
_INSTALLED = {Path(sysconfig.get_path(kind)).resolve() for kind in ("purelib", "platlib")}
# What Python itself puts into a class beside what stands in it.
_OF_PYTHON = {
    *("__module__", "__doc__", "__dict__", "__weakref__", "__slots__", "__annotations__"),
    *("__firstlineno__", "__static_attributes__", "__annotate__", "__annotate_func__"),
    *("__abstractmethods__", "_abc_impl", "__parameters__", "__orig_bases__"),
}


class _Manner(IntEnum):
    """How something enters a fingerprint, the more narrowly the higher."""

    WHOLLY = 0
    UNCALLED = 1
    """Who knows what code does that nobody has called yet."""
    NAMED = 2
    """And what others' objects keep changes by itself: loggers, counters, caches."""


class _Met(NamedTuple):
    """A function or class, and how it enters."""

    value: Any
    manner: _Manner


class Things(Digest):
    """Adds laws and methods, with all that they refer to, to a fingerprint."""

    def __init__(self) -> None:
        super().__init__()
        self.unknown: set[str] = set()
        # Functions and classes in the order in which they were met: each is taken once.
        self._met: list[_Met] = []
        self._numbers: dict[int, int] = {}
        self._taken = 0
        self._manner = _Manner.WHOLLY

    def thing(self, value: Any) -> None:
        """Add a law, a method or what stands in one: numbers, arrays, functions, objects."""
        self._thing(value, 0)
        while self._taken < len(self._met):
            met, self._taken = self._met[self._taken], self._taken + 1
            with self._as(met.manner):
                if isinstance(met.value, type):
                    for name, value in sorted(vars(met.value).items()):
                        if name in _OF_PYTHON or _is_slot(value):
                            continue
                        self.text(name)
                        if isinstance(value, property):
                            self._only_named([value.fget, value.fset])
                        elif isinstance(value, cached_property):
                            self._only_named(value.func)
                        else:
                            self._only_named(getattr(value, "__func__", value))
                else:
                    self._code(met.value)

    def _thing(self, value: Any, depth: int) -> None:
        function = value if callable(value) else None
        for name in ("__func__", "py_func", "__wrapped__"):
            function = getattr(function, name, function)
        function = function if isinstance(function, FunctionType) else None
        if value is None or isinstance(value, bool | int | float | complex | str | bytes):
            self.text(f"{type(value).__name__} {value!r}")
        elif isinstance(value, np.ndarray | np.generic):
            self.arrays("array", np.asarray(value))
        elif isinstance(value, ModuleType):
            self._installed(value.__name__)
        elif isinstance(value, type):
            self._class(value)
        elif function is not None:  # of Python: itself, a method, what is wrapped or compiled
            self.text(_name_of(value))
            self._later(function)
            if isinstance(value, MethodType):
                self._thing(value.__self__, depth + 1)
            if self._manner == _Manner.WHOLLY:
                self.text(_tried(value))
        elif depth >= _DEEPEST or (self._manner == _Manner.NAMED and _is_others(value)):
            self.text(_name_of(value))
        elif isinstance(value, Mapping):
            self._things(chain.from_iterable(value.items()), depth)
        elif isinstance(value, Sequence | set | frozenset):
            ordered = value if isinstance(value, Sequence) else sorted(value, key=repr)
            self._things(ordered, depth)
        else:
            self._object(value, depth)

    def _things(self, values: Iterable[Any], depth: int) -> None:
        things = list(values)
        self.text(f"{len(things)} things")
        for value in things:
            self._thing(value, depth + 1)

    def _object(self, value: Any, depth: int) -> None:
        self.text(_name_of(value))
        if callable(value) and self._manner == _Manner.WHOLLY:
            self.text(_tried(value))
        kind = type(value)
        self._class(kind)
        names = {name for one in kind.__mro__ if one is not object for name in vars(one)}
        # Of others' objects some know best what of them is kept.
        knows = not _is_own(kind.__module__) and names & {"__reduce__", "__reduce_ex__"}
        if not knows and names & {"__dict__", "__slots__"}:  # all of it stands where Python sees it
            # Attributes and slots. What follows from the rest, and is there only once it was asked
            # for, tells nothing.
            kept = {
                name: inner
                for name, inner in getattr(value, "__dict__", {}).items()
                if not isinstance(getattr(kind, name, None), cached_property)
            }
            slots = (name for one in kind.__mro__ for name, m in vars(one).items() if _is_slot(m))
            kept |= {name: getattr(value, name) for name in slots if hasattr(value, name)}
            self._things(chain.from_iterable(sorted(kept.items())), depth)
        else:  # what is not seen in Python, as it would be kept in a file (PEP 307)
            try:
                reduced = value.__reduce_ex__(2)
            except Exception:
                reduced = None
            code = isinstance(value, BuiltinFunctionType) and value.__module__ is not None
            if reduced is None or (code and _top(value.__module__) not in _KNOWN):
                self.unknown.add(_name_of(value))
            with self._as(_Manner.UNCALLED):
                self._thing(reduced, depth + 1)

    def _class(self, kind: type) -> None:
        """Add a class and its bases."""
        for one in kind.__mro__:
            if _is_own(one.__module__):
                self.text(one.__qualname__)
                self._later(one)
            elif one is not object:
                self._installed(one.__module__)

    def _later(self, value: FunctionType | type) -> None:
        """Postpone a function or class; its number stands here for it."""
        number = self._numbers.setdefault(id(value), len(self._met))
        if number == len(self._met):
            self._met.append(_Met(value, self._manner))
        self.text(f"number {number}")

    def _code(self, function: FunctionType) -> None:
        """Add what a Python function does: its code, constants, defaults, closure and names."""
        cells = []
        for cell in function.__closure__ or ():
            with suppress(ValueError):  # what is named in it was not made yet
                cells.append(cell.cell_contents)
        for code in _codes(function.__code__):
            self.text(code.co_code.hex() + repr(code.co_names))
            self._things([c for c in code.co_consts if not isinstance(c, CodeType)], 0)
        self._things([function.__defaults__, function.__kwdefaults__, cells], 0)
        if _is_own(function.__module__):
            # What it names in its module, and in modules of the user's that it names.
            codes = list(_codes(function.__code__))
            names = {str(step.argval) for code in codes for step in dis.get_instructions(code)
                     if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")}  # fmt: skip
            inner = {name for code in codes for name in code.co_names}
            for name in sorted(names & set(function.__globals__)):
                value = function.__globals__[name]
                found = {name: value}
                if isinstance(value, ModuleType) and _is_own(value.__name__):
                    own = vars(value)
                    found = {f"{name}.{k}": own[k] for k in sorted(inner & set(own))}
                for inner_name, one in found.items():
                    self.text(inner_name)
                    self._only_named(one)

    def _only_named(self, value: Any) -> None:
        with self._as(_Manner.NAMED):
            self._thing(value, 0)

    @contextmanager
    def _as(self, manner: _Manner) -> Iterator[None]:
        before, self._manner = self._manner, max(manner, self._manner)
        yield
        self._manner = before

    def _installed(self, module: str) -> None:
        """Add a package by its name, and by its version where results may depend on it."""
        top = _top(module)
        version = "" if top in _KNOWN else getattr(sys.modules.get(top), "__version__", "")
        self.text(f"{module} {version}")


def _top(module: str | None) -> str:
    return str(module or "builtins").partition(".")[0]


def _name_of(value: Any) -> str:
    named = value if callable(value) and hasattr(value, "__qualname__") else type(value)
    return f"{named.__module__}.{named.__qualname__}"


def _is_others(value: Any) -> bool:
    """Return whether an object is Python's or an installed package's, and neither data nor code."""
    kind = type(value)
    data = kind in _PLAIN or isinstance(value, Number) or _top(kind.__module__) == "contiga"
    return not (data or callable(value) or _is_own(kind.__module__))


def _is_slot(member: Any) -> bool:
    return type(member).__name__ == "member_descriptor"


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and those of the functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _is_own(module: str | None) -> bool:
    """Return whether a module is the user's: none of Python, of contiga or of a package."""
    top = _top(module)
    if top in _KNOWN:
        return False
    file = getattr(sys.modules.get(top), "__file__", None)
    return file is None or not _INSTALLED & set(Path(file).resolve().parents)


def _tried(function: Callable[..., Any]) -> str:
    """Return what a function answers, or the name of the error where it takes other arguments."""
    try:
        with np.errstate(all="ignore"):
            return repr(np.asarray(function(_TRIED.copy()), dtype=np.float64).tobytes())
    except Exception as error:
        return type(error).__name__
