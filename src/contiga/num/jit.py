"""Where compiled kernels are kept, so that an old one can never be run.

numba stamps a cached kernel with the text of its own file. A kernel holds the code of the kernels
it calls, so here the stamp is the text of its file and of all files of this package which that
imports, directly or not: an edit compiles anew what it touches, and nothing else. The stamp is
part of the files' names too. numba writes the index of a kernel before its code, so that one who
reads in between, or after a process that died there, would find the old code under the new index.

Importing this module is enough; every room with kernels does so first. `NUMBA_CACHE_DIR`, a
read-only package and different processors in one folder are numba's business, as ever.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import caching

from contiga.num import reference as reference  # the types of tuples of tables
from contiga.num.compiler import (
    CalledCompiler,
    InnerCompiler,
    KernelCompiler,
    KernelDispatcher,
    decorator,
)
from contiga.num.lazy import lazily
from contiga.num.stamps import PACKAGE, PACKAGES, stamp_at_import

DIGITS = 16
KEPT = (".nbi", ".nbc")
"""Endings of the files of compiled kernels."""
Decorator = Callable[[Any], Any]


def kernel(linked: bool = False, **options: Any) -> Decorator:
    """Decorator of kernels that Python calls, on any thread.

    What kernels call as well, all the time, is better `linked` into them.
    """
    return decorator(KernelCompiler if linked else CalledCompiler, nogil=True, **options)


def inner(linked: bool = True, **options: Any) -> Decorator:
    """Decorator of kernels that only kernels call.

    Without what a call from Python needs, they compile a fifth faster. Called from Python they
    would crash; a test sees to it that none is.

    Their code is put into that of their callers. What is not `linked` is compiled once and called,
    and none of its callers has to be optimised with its code in it: for what takes longer than a
    call (some nanoseconds) and is a part of several kernels, or a large part of one.
    """
    made_by = InnerCompiler if linked else CalledCompiler
    return decorator(made_by, no_cpython_wrapper=True, **options)


def lazy(returns: Any, **options: Any) -> Decorator:
    """Decorator of kernels that only kernels call, and in most runs none: fallbacks.

    They are called, as what is not `linked`, and compiled when they are called first; no caller
    has to wait for them. `returns` is the type of what they answer, numba's.
    """
    return lazily(returns, no_cpython_wrapper=True, **options)


def straight(function: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel as it is called all the time, without a look at what it is handed: see
    `KernelDispatcher.straight`. All arguments are given by their places."""
    return function.straight if isinstance(function, KernelDispatcher) else function


inlined = partial(njit, inline="always")
"""Decorator of a few lines that are put in place of their calls."""


class Sourced:
    """What a locator of numba's is given: stamps of all sources, for the files of a package.

    Mixed in before one of numba's locators, which says in what folder files are kept.
    """

    package: Path
    _name = _stamp = ""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """A locator for the function; none where its file is not of the package."""
        path = Path(py_file).resolve()
        if cls.package not in path.parents or not path.is_file():
            return None
        locator: Any = super().from_function(py_func, py_file)  # type: ignore[misc]
        if locator is not None:
            name = f"{path.stem}.{py_func.__qualname__}"
            locator._name = name.replace("<", "").replace(">", "")
            locator._stamp = stamp_at_import(py_func)
        return locator

    def get_source_stamp(self) -> str:
        """What the index of the function is checked by."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """What is put after the function's name in the names of its files."""
        return self._stamp[:DIGITS]

    def ensure_cache_path(self) -> None:
        """Called before a kernel is written, too: those of other sources are removed then."""
        super().ensure_cache_path()  # type: ignore[misc]
        if self._stamp:
            folder = Path(self.get_cache_path())  # type: ignore[attr-defined]
            old, own = f"{self._name}-", f"{self._name}-{self.get_disambiguator()}."
            for name in os.listdir(folder):  # a pattern takes ten times as long, for each kernel
                if name.startswith(old) and not name.startswith(own) and name.endswith(KEPT):
                    (folder / name).unlink(missing_ok=True)


def keep_by_sources(package: Path) -> None:
    """From now on, stamp the kernels of `package`, a folder, by all their sources."""
    PACKAGES.append(package)
    plain = [
        base
        for base in caching.CacheImpl._locator_classes
        if issubclass(base, caching._SourceFileBackedLocatorMixin) and not issubclass(base, Sourced)
    ]
    own = [type(f"Sourced{base.__name__}", (Sourced, base), {"package": package}) for base in plain]
    caching.CacheImpl._locator_classes = [*own, *caching.CacheImpl._locator_classes]


keep_by_sources(PACKAGE)
