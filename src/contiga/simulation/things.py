"""Add laws and methods, with all that they refer to, to a fingerprint: numbers, arrays and code.

User code is followed everywhere: methods, constants of classes, slots, closures, and the functions
and constants of modules that it names. An installed package enters by its name and version, and an
object of it that is only named (a logger, a cache) by its type. Anything else cannot be read, and
is listed as `unknown`.
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

# Arguments of a trial call of a function: strains, penetrations and rates.
_TRIAL_VALUES = np.array([0.0, 1e-6, 1e-3, 0.03, 0.3])
# Nesting depth of objects beyond which only types are added.
_MAX_DEPTH = 8
# Containers of Python.
_CONTAINERS = (tuple, list, dict, set, frozenset, range, MappingProxyType)
_KNOWN_PACKAGES = {*sys.stdlib_module_names, "contiga", "numpy", "numba", "scipy"}
_SITE_FOLDERS = {Path(sysconfig.get_path(kind)).resolve() for kind in ("purelib", "platlib")}
# Members that Python itself adds to a class.
_PYTHON_MEMBERS = {
    *("__module__", "__doc__", "__dict__", "__weakref__", "__slots__", "__annotations__"),
    *("__firstlineno__", "__static_attributes__", "__annotate__", "__annotate_func__"),
    *("__abstractmethods__", "_abc_impl", "__parameters__", "__orig_bases__"),
}


class _Scope(IntEnum):
    """How fully an object enters a fingerprint; higher values include less."""

    FULL = 0
    UNCALLED = 1
    """Code is not called: it may have effects that no run has."""
    NAMED = 2
    """Objects of packages enter by type only: loggers, counters and caches change by themselves."""


class _Pending(NamedTuple):
    """A function or class that is still to be added."""

    value: Any
    scope: _Scope


class Things(Digest):
    """Adds laws and methods, with all that they refer to, to a fingerprint."""

    def __init__(self) -> None:
        super().__init__()
        self.unknown: set[str] = set()
        # Functions and classes in order of appearance; each is added once.
        self._pending: list[_Pending] = []
        self._numbers: dict[int, int] = {}
        self._n_added = 0
        self._scope = _Scope.FULL

    def add_value(self, value: Any) -> None:
        """Add a law or a method with its contents: numbers, arrays, functions, objects.

        Functions and classes that it refers to follow in order of appearance, each once.
        """
        self._add(value, 0)
        while self._n_added < len(self._pending):
            pending, self._n_added = self._pending[self._n_added], self._n_added + 1
            with self._in_scope(pending.scope):
                if isinstance(pending.value, type):
                    for name, value in sorted(vars(pending.value).items()):
                        if name in _PYTHON_MEMBERS or _is_slot(value):
                            continue
                        self.text(name)
                        if isinstance(value, property):
                            self._add_named([value.fget, value.fset])
                        elif isinstance(value, cached_property):
                            self._add_named(value.func)
                        else:
                            self._add_named(getattr(value, "__func__", value))
                else:
                    self._add_code(pending.value)

    def _add(self, value: Any, depth: int) -> None:
        """Add a value by its kind, with what it contains down to `_MAX_DEPTH`.

        Code is added when its turn comes in `add_value`. In the scope `FULL` a function is also
        called once, and its result added.
        """
        function = value if callable(value) else None
        for name in ("__func__", "py_func", "__wrapped__"):
            function = getattr(function, name, function)
        match value:
            case None | bool() | int() | float() | complex() | str() | bytes():
                self.text(f"{type(value).__name__} {value!r}")
            case np.ndarray() | np.generic():
                self.arrays("array", np.asarray(value))
            case ModuleType():
                self._add_package(value.__name__)
            case type():
                self._add_class(value)
            case _ if isinstance(function, FunctionType):  # also of a method, wrapped or compiled
                self.text(_qualified_name(value))
                self._postpone(function)
                if isinstance(value, MethodType):
                    self._add(value.__self__, depth + 1)
                if self._scope == _Scope.FULL:
                    self.text(_trial_result(value))
            case _ if depth >= _MAX_DEPTH:
                self.text(_qualified_name(value))
            case _ if self._scope == _Scope.NAMED and _is_foreign_object(value):
                self.text(_qualified_name(value))
            case Mapping():
                self._add_all(chain.from_iterable(value.items()), depth)
            case Sequence():
                self._add_all(value, depth)
            case set() | frozenset():
                self._add_all(sorted(value, key=repr), depth)
            case _:
                self._add_object(value, depth)

    def _add_all(self, values: Iterable[Any], depth: int) -> None:
        items = list(values)
        self.text(f"{len(items)} things")
        for value in items:
            self._add(value, depth + 1)

    def _add_object(self, value: Any, depth: int) -> None:
        """Add an object by its class, its result as a function if it is one, and its state.

        An object whose state cannot be read is added to `unknown`.
        """
        self.text(_qualified_name(value))
        if callable(value) and self._scope == _Scope.FULL:
            self.text(_trial_result(value))
        kind = type(value)
        self._add_class(kind)
        names = {name for base in kind.__mro__ if base is not object for name in vars(base)}
        # Objects of packages may define their own state for pickling.
        has_reduce = not _is_user_module(kind.__module__) and names & {
            "__reduce__",
            "__reduce_ex__",
        }
        if not has_reduce and names & {"__dict__", "__slots__"}:
            # Attributes and slots, without cached properties, which follow from the others.
            attributes = {
                name: attribute
                for name, attribute in getattr(value, "__dict__", {}).items()
                if not isinstance(getattr(kind, name, None), cached_property)
            }
            slots = (name for base in kind.__mro__ for name, m in vars(base).items() if _is_slot(m))
            attributes |= {name: getattr(value, name) for name in slots if hasattr(value, name)}
            self._add_all(chain.from_iterable(sorted(attributes.items())), depth)
        else:  # the state as pickling sees it (PEP 307)
            try:
                reduced = value.__reduce_ex__(2)
            except Exception:
                reduced = None
            is_builtin = isinstance(value, BuiltinFunctionType) and value.__module__ is not None
            if reduced is None or (
                is_builtin and _top_package(value.__module__) not in _KNOWN_PACKAGES
            ):
                self.unknown.add(_qualified_name(value))
            with self._in_scope(_Scope.UNCALLED):
                self._add(reduced, depth + 1)

    def _add_class(self, kind: type) -> None:
        """Add a class and its bases: a user's with their contents, others by their packages."""
        for base in kind.__mro__:
            if _is_user_module(base.__module__):
                self.text(base.__qualname__)
                self._postpone(base)
            elif base is not object:
                self._add_package(base.__module__)

    def _postpone(self, value: FunctionType | type) -> None:
        """Postpone a function or class; its number is added in its place."""
        number = self._numbers.setdefault(id(value), len(self._pending))
        if number == len(self._pending):
            self._pending.append(_Pending(value, self._scope))
        self.text(f"number {number}")

    def _add_code(self, function: FunctionType) -> None:
        """Add a Python function: its code, constants, defaults, closure and names."""
        cells = []
        for cell in function.__closure__ or ():
            with suppress(ValueError):  # the cell is empty
                cells.append(cell.cell_contents)
        for code in _nested_codes(function.__code__):
            self.text(code.co_code.hex() + repr(code.co_names))
            self._add_all([c for c in code.co_consts if not isinstance(c, CodeType)], 0)
        self._add_all([function.__defaults__, function.__kwdefaults__, cells], 0)
        if _is_user_module(function.__module__):
            # Objects that it names in its module, and in user modules.
            codes = list(_nested_codes(function.__code__))
            names = {str(step.argval) for code in codes for step in dis.get_instructions(code)
                     if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")}  # fmt: skip
            code_names = {name for code in codes for name in code.co_names}
            for name in sorted(names & set(function.__globals__)):
                value = function.__globals__[name]
                members = {name: value}
                if isinstance(value, ModuleType) and _is_user_module(value.__name__):
                    module_members = vars(value)
                    members = {
                        f"{name}.{k}": module_members[k]
                        for k in sorted(code_names & set(module_members))
                    }
                for inner_name, member in members.items():
                    self.text(inner_name)
                    self._add_named(member)

    def _add_named(self, value: Any) -> None:
        with self._in_scope(_Scope.NAMED):
            self._add(value, 0)

    @contextmanager
    def _in_scope(self, scope: _Scope) -> Iterator[None]:
        before, self._scope = self._scope, max(scope, self._scope)
        yield
        self._scope = before

    def _add_package(self, module: str) -> None:
        """Add a package by its name, and by its version if results may depend on it."""
        top = _top_package(module)
        version = "" if top in _KNOWN_PACKAGES else getattr(sys.modules.get(top), "__version__", "")
        self.text(f"{module} {version}")


def _top_package(module: str | None) -> str:
    return str(module or "builtins").partition(".")[0]


def _qualified_name(value: Any) -> str:
    named = value if callable(value) and hasattr(value, "__qualname__") else type(value)
    return f"{named.__module__}.{named.__qualname__}"


def _is_foreign_object(value: Any) -> bool:
    """Return whether an object belongs to Python or a package, and is neither data nor code."""
    kind = type(value)
    data = (
        kind in _CONTAINERS
        or isinstance(value, Number)
        or _top_package(kind.__module__) == "contiga"
    )
    return not (data or callable(value) or _is_user_module(kind.__module__))


def _is_slot(member: Any) -> bool:
    return type(member).__name__ == "member_descriptor"


def _nested_codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and those of the functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _nested_codes(constant)


def _is_user_module(module: str | None) -> bool:
    """Return whether a module is the user's own, not of Python, contiga or a package."""
    top = _top_package(module)
    if top in _KNOWN_PACKAGES:
        return False
    file = getattr(sys.modules.get(top), "__file__", None)
    return file is None or not _SITE_FOLDERS & set(Path(file).resolve().parents)


def _trial_result(function: Callable[..., Any]) -> str:
    """Return the result of a function at `_TRIAL_VALUES` as a text, or the name of its error."""
    try:
        with np.errstate(all="ignore"):
            return repr(np.asarray(function(_TRIAL_VALUES.copy()), dtype=np.float64).tobytes())
    except Exception as error:
        return type(error).__name__
