"""What a law or a method is made of, for a fingerprint: its numbers and arrays, and its code.

Code is followed wherever it is the user's own: methods, constants of classes, slots, closures, and
the functions and constants of modules that it names. Of packages that are installed the name and
the version stand for their code. What is left says nothing of itself, and is told to be `unknown`.
"""

from __future__ import annotations

import dis
import sys
import sysconfig
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from contiga.num.digest import Digest

# Arguments a function is tried at, beside its code: strains, penetrations and rates.
_TRIED = np.array([0.0, 1e-6, 1e-3, 0.03, 0.3])
# Objects inside objects, inside objects…: beyond this a law says nothing more about itself.
_DEEPEST = 8
_KNOWN = {*sys.stdlib_module_names, "contiga", "numpy", "numba", "scipy"}
_INSTALLED = {Path(sysconfig.get_path(kind)).resolve() for kind in ("purelib", "platlib")}
# What Python itself puts into a class beside what stands in it.
_OF_PYTHON = {
    *("__module__", "__doc__", "__dict__", "__weakref__", "__slots__", "__annotations__"),
    *("__firstlineno__", "__static_attributes__", "__annotate__", "__annotate_func__"),
    *("__abstractmethods__", "_abc_impl", "__parameters__", "__orig_bases__"),
}


class Things(Digest):
    """Adds laws, methods and what stands in them."""

    def __init__(self) -> None:
        super().__init__()
        self.unknown: set[str] = set()
        # Functions and classes met so far: recursion ends, and they stay where they are.
        self._met: dict[int, Any] = {}
        self._named = False

    def thing(self, value: Any, depth: int = 0) -> None:
        """A law, a method or what stands in one: numbers, arrays, functions, objects."""
        if value is None or isinstance(value, bool | int | float | complex | str | bytes):
            self.text(f"{type(value).__name__} {value!r}")
        elif isinstance(value, np.ndarray | np.generic):
            self.arrays("array", np.asarray(value))
        elif isinstance(value, ModuleType):
            self._installed(value.__name__)
        elif depth >= _DEEPEST:
            self.text(type(value).__qualname__)
        elif isinstance(value, Mapping):
            self._things(chain.from_iterable(value.items()), depth)
        elif isinstance(value, Sequence | set | frozenset):
            ordered = value if isinstance(value, Sequence) else sorted(value, key=repr)
            self._things(ordered, depth)
        elif isinstance(value, type):
            self._class(value, depth)
        else:
            self._object(value, depth)

    def _things(self, values: Iterable[Any], depth: int) -> None:
        own = list(values)
        self.text(f"{len(own)} things")
        for value in own:
            self.thing(value, depth + 1)

    def _object(self, value: Any, depth: int) -> None:
        self.text(_name_of(value))
        function = _function_of(value)
        if function is not None:
            self._code(function, depth)
        if isinstance(value, MethodType):
            self.thing(value.__self__, depth + 1)
        # What code only names is never called: who knows what it does.
        if callable(value) and not self._named:
            self.text(_tried(value))
        if function is not None:
            return
        self._class(type(value), depth)
        if _in_python(type(value)) and not isinstance(value, partial):
            self._things(chain.from_iterable(sorted(_kept(value).items())), depth)
        else:
            self._compiled(value, depth)

    def _class(self, kind: type, depth: int) -> None:
        """Code and constants of a class and of what it comes from."""
        for one in kind.__mro__:
            if not _is_own(one.__module__):
                if one is not object:
                    self._installed(one.__module__)
                continue
            self.text(one.__qualname__)
            if self._meets(one):
                continue
            for name, value in sorted(vars(one).items()):
                if name not in _OF_PYTHON and not _is_slot(value):
                    self.text(name)
                    self._only_named(_plain(value), depth)

    def _code(self, function: FunctionType, depth: int) -> None:
        """What a function of Python does: its code, constants, defaults, closure, and what it
        names."""
        if self._meets(function):
            return
        cells = [cell.cell_contents for cell in function.__closure__ or () if _is_full(cell)]
        for code in _codes(function.__code__):
            self.text(code.co_code.hex() + repr(code.co_names))
            self._things([c for c in code.co_consts if not isinstance(c, CodeType)], depth)
        self._things([function.__defaults__, function.__kwdefaults__, cells], depth)
        if _is_own(function.__module__):
            for name, value in _globals(function):
                self.text(name)
                self._only_named(value, depth)

    def _only_named(self, value: Any, depth: int) -> None:
        before, self._named = self._named, True
        self.thing(value, depth + 1)
        self._named = before

    def _meets(self, value: Any) -> bool:
        """Whether a function or class was met before; from now on it was."""
        met = id(value) in self._met
        self._met[id(value)] = value
        return met

    def _compiled(self, value: Any, depth: int) -> None:
        """What is not made in Python: as it would be kept in a file (PEP 307)."""
        self._named, before = True, self._named
        try:
            told = value.__reduce_ex__(2)
        except Exception:
            told = None
        code = isinstance(value, BuiltinFunctionType) and value.__module__ is not None
        if told is None or (code and _top(value.__module__) not in _KNOWN):
            self.unknown.add(_name_of(value))
        self.thing(told, depth + 1)
        self._named = before

    def _installed(self, module: str) -> None:
        """A package by its name, and by its version where that is not one that all need."""
        top = _top(module)
        version = "" if top in _KNOWN else getattr(sys.modules.get(top), "__version__", "")
        self.text(f"{module} {version}")


def _top(module: str | None) -> str:
    return str(module or "builtins").partition(".")[0]


def _name_of(value: Any) -> str:
    named = value if callable(value) and hasattr(value, "__qualname__") else type(value)
    return f"{named.__module__}.{named.__qualname__}"


def _in_python(kind: type) -> bool:
    """Whether a class was made there, or keeps what it is where Python sees it."""
    return any(name in vars(one) for one in kind.__mro__ for name in ("__dict__", "__slots__"))


def _function_of(value: Any) -> FunctionType | None:
    """The function of Python that something calls: a method, what is wrapped or compiled."""
    for name in ("__func__", "py_func", "__wrapped__"):
        value = getattr(value, name, value)
    return value if isinstance(value, FunctionType) else None


def _kept(value: Any) -> dict[str, Any]:
    """Attributes and slots of an object, by name.

    What follows from the rest, and is there only once it was asked for, tells nothing.
    """
    kind = type(value)
    own = {
        name: inner
        for name, inner in getattr(value, "__dict__", {}).items()
        if not isinstance(getattr(kind, name, None), cached_property)
    }
    slots = (name for one in kind.__mro__ for name, m in vars(one).items() if _is_slot(m))
    return own | {name: getattr(value, name) for name in slots if hasattr(value, name)}


def _is_slot(member: Any) -> bool:
    return type(member).__name__ == "member_descriptor"


def _plain(member: Any) -> Any:
    """What stands in a class, out of what makes it a property or a method of the class."""
    if isinstance(member, property):
        return [member.fget, member.fset]
    if isinstance(member, cached_property):
        return member.func
    return getattr(member, "__func__", member)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A code and those of the functions that stand in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _globals(function: FunctionType) -> list[tuple[str, Any]]:
    """What a function names in its module, and in modules of the user's that it names."""
    codes = list(_codes(function.__code__))
    names = {str(step.argval) for code in codes for step in dis.get_instructions(code)
             if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")}  # fmt: skip
    inner = {name for code in codes for name in code.co_names}
    found: list[tuple[str, Any]] = []
    for name in sorted(names & set(function.__globals__)):
        value = function.__globals__[name]
        if isinstance(value, ModuleType) and _is_own(value.__name__):
            found += [(f"{name}.{k}", vars(value)[k]) for k in sorted(inner & set(vars(value)))]
        else:
            found.append((name, value))
    return found


def _is_own(module: str | None) -> bool:
    """Whether a module is the user's: none of Python, of contiga or of an installed package."""
    top = _top(module)
    if top in _KNOWN:
        return False
    file = getattr(sys.modules.get(top), "__file__", None)
    return file is None or not _INSTALLED & set(Path(file).resolve().parents)


def _is_full(cell: Any) -> bool:
    try:
        return cell.cell_contents is cell.cell_contents
    except ValueError:  # what is named in it was not made yet
        return False


def _tried(function: Callable[..., Any]) -> str:
    """What a function answers; the name of the error where it takes other arguments."""
    try:
        with np.errstate(all="ignore"):
            return repr(np.asarray(function(_TRIED.copy()), dtype=np.float64).tobytes())
    except Exception as error:
        return type(error).__name__
