"""The cache of kernels: numba's own, with stamps of all sources, and one process at a time.

numba stamps a cached kernel with the text of its own file. A kernel contains the code of the
kernels that it calls, so here the stamp covers its file, all files of the package that the file
imports, directly or not, and numba's version: an edit recompiles the kernels that depend on it, and
no others. The stamp is part of the files' names too, so that several versions of a package share a
folder (`folder`). numba writes the index of a kernel before its code: a process that reads in
between, or after a process that died there, would find the old code under the new index.

One process compiles a kernel; others wait for it and read it. Locks are by kernel and types: since
kernels do not call each other in circles, waiting processes cannot either. The kernels that a
cached kernel calls by name are stored beside it, and loaded before it.

Installed kernels (`prebuilt`) are tried first. numba itself distinguishes processors in one folder;
the numbers in a vector, which are constants of kernels, are part of the stamp. Only kernels of our
packages are cached so: numba's lists of caches are not changed.
"""

from __future__ import annotations

import inspect
import os
import pickle
import re
import sys
from contextlib import AbstractContextManager, ExitStack, suppress
from functools import cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

import numba
from numba.core import event
from numba.core.caching import CompileResultCacheImpl, FunctionCache

from contiga.cache_folder import mark_used
from contiga.jit.folder import PRIVATE, kernel_folder, make_room
from contiga.jit.libraries import CalledLibrary, calls_of, module_of
from contiga.jit.locks import alone
from contiga.jit.notice import notify_once
from contiga.jit.prebuilt import Version, choice, kernel_target
from contiga.jit.stamps import LOCAL, PACKAGES, stamp_at_import
from contiga.jit.vectors import numbers_in_vector

DIGITS = 16
NO_FOLDER = Path(os.devnull)
"""Folder of kernels if none is writable; it is never read."""
ADDRESS = re.compile(r"\b0x[0-9a-f]+")
"""Addresses in the names of function types, which differ between processes."""


class CompileListener(Protocol):
    """A listener that is notified of the compiling of kernels.

    It gets a kernel's module, name and argument types.
    """

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Note that a kernel is needed and not cached; it is compiled if nobody else does that."""

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Note that a kernel is cached, or cannot be compiled."""


COMPILE_LISTENERS: list[CompileListener] = []
"""Listeners of this process."""


class Sourced:
    """Locator of the cached files of a kernel of our packages, by stamps of all sources."""

    def __init__(self, function: Any, file: Path, folder: Path) -> None:
        self._py_file = str(file)
        stamp = (
            f"{numba.__version__} {numbers_in_vector(kernel_target())} {stamp_at_import(function)}"
        )
        self._stamp = sha256(stamp.encode()).hexdigest()
        self._folder = folder

    def get_cache_path(self) -> str:
        """Return the folder of the cached files."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return the stamp that the index of the function is checked by."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return the suffix of the function's name in the names of its files."""
        return self._stamp[:DIGITS]

    def ensure_cache_path(self) -> None:
        """Make the folder before a kernel is written, and room in it; raise OSError on failure."""
        self._folder.mkdir(mode=PRIVATE, parents=True, exist_ok=True)
        make_room(self._folder)


class KernelCacheImpl(CompileResultCacheImpl):  # type: ignore[misc]
    """Serialisation of a compiled kernel: numba's own, and the functions it calls by name.

    Functions of packages outside `PACKAGES` are cached as numba does.
    """

    def __init__(self, function: Any) -> None:
        file = Path(inspect.getfile(function)).resolve()
        if not any(package in file.parents for package in PACKAGES):
            super().__init__(function)
            return
        self._lineno = function.__code__.co_firstlineno
        self._locator = Sourced(function, file, kernel_folder() or NO_FOLDER)
        self._filename_base = self.get_filename_base(
            f"{file.stem}.{function.__qualname__}", getattr(sys, "abiflags", "")
        )

    def check_cachable(self, compiled: Any) -> bool:
        """Return whether a kernel can be cached: it calls no local kernel, and numba agrees."""
        is_known = all(LOCAL not in kernel for _, _, kernel, _ in calls_of(compiled.library))
        return is_known and bool(super().check_cachable(compiled))

    def reduce(self, compiled: Any) -> Any:
        """Return the data to be written: the kernels that it calls, and numba's own."""
        return calls_of(compiled.library), super().reduce(compiled)

    def rebuild(self, target: Any, stored: Any) -> Any:
        """Return the compiled kernel once all that it calls is read or compiled (`known_as`).

        None if one of those has another name by now: the kernel is then compiled anew.
        """
        calls, code = stored
        for name, module, kernel, arguments in calls:
            if getattr(import_module(module), kernel).known_as(arguments) != name:
                return None
        compiled = super().rebuild(target, code)
        library = compiled.library
        if library.name == CalledLibrary.__name__:
            library._shared_module = module_of([], library._final_module)
        return compiled


class KernelCache(FunctionCache):  # type: ignore[misc]
    """Cache of compiled kernels in files."""

    _impl_class = KernelCacheImpl

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        is_writable = self._cache_path != str(NO_FOLDER)
        self.index = self._cache_file._index_path if is_writable else ""
        self._home = function.__module__, function.__qualname__
        self._locks: dict[Any, ExitStack] = {}
        if not is_writable:
            self.disable()

    @cached_property
    def _prebuilt(self) -> dict[Version, bytes]:
        prebuilt = choice().prebuilt
        return {} if prebuilt is None else prebuilt.versions(self._impl.filename_base)

    def prebuilt_signatures(self, target: Any) -> list[Any]:
        """Return the argument types of the installed versions that fit this process."""
        codegen = target.codegen()
        return [
            types for types, _ in self._prebuilt if self._version(types, codegen) in self._prebuilt
        ]

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return an installed or cached version; None if the caller has to compile until `done`.

        Before it returns None it notifies listeners and the user, and waits for the lock of this
        version, to look into the cache once more: another process may have compiled it. The lock is
        held until `done`.
        """
        overload = None
        if self._prebuilt:
            target.refresh()  # the order in which numba's own loading does it
            stored = self._prebuilt.get(self._version(signature, target.codegen()))
            if stored is not None:
                overload = self._impl.rebuild(target, pickle.loads(stored))
        overload = overload or self._cached(signature, target)
        if overload is None and self._enabled and signature not in self._locks:
            for listener in COMPILE_LISTENERS:
                with _waiting():
                    listener.before(*self._home, signature)
            lock = self._locks[signature] = ExitStack()
            lock.enter_context(self._lock(str(signature), _waiting))
            overload = self._cached(signature, target)
        if overload is None:
            notify_once()
        return overload

    def _version(self, signature: Any, codegen: Any) -> Version:
        """Return numba's key without the target."""
        types, _, hashes = self._index_key(signature, codegen)
        return types, hashes

    def _cached(self, signature: Any, target: Any) -> Any:
        """Return a cached version; None without one.

        The files of a kernel are removed if the modules of its record types have moved since.
        """
        try:
            overload = super().load_overload(signature, target)
        except (ImportError, AttributeError):
            self.flush()
            return None
        if overload is not None:
            mark_used(self.index)
        return overload

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Cache a version; do nothing if it cannot be written.

        numba reads the index of a kernel and writes it again with one more line, hence the lock.
        Files whose index cannot be read are removed before.
        """
        with suppress(OSError), self._lock("index"):
            try:
                super().save_overload(signature, compiled)
            except (ImportError, AttributeError):  # another version of contiga has written it
                self.flush()
                super().save_overload(signature, compiled)

    def done(self, signature: Any) -> None:
        """Release the lock of a version that is cached or cannot be compiled; notify listeners."""
        self._locks.pop(signature, ExitStack()).close()
        for listener in COMPILE_LISTENERS:
            listener.after(*self._home, signature)

    def _lock(self, name: str, *waiting: Any) -> AbstractContextManager[None]:
        """Return the lock of a name for this kernel."""
        full_name = f"{self._cache_file._index_name} {ADDRESS.sub('', name)}"
        return alone(self._cache_path, full_name, *waiting)


def _waiting() -> AbstractContextManager[None]:
    """Return a context that counts waiting for another process's compiler as compiling."""
    return event.trigger_event("numba:compile", data={})
