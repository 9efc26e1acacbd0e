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

import glob
import os
import re
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import caching

from contiga.num.compiler import InnerCompiler

PACKAGE = Path(__file__).resolve().parents[1]
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]*))",
    re.MULTILINE,
)
ASIDE = re.compile(r"#[^\n]*|\\\n")
"""Comments, and ends of lines that do not end: they are gone when imports are looked for."""
DIGITS = 16
kernel = partial(njit, cache=True, nogil=True)
"""Decorator of kernels that Python calls, on any thread."""
inner = partial(
    njit,
    cache=True,
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    pipeline_class=InnerCompiler,
)
"""Decorator of kernels that only kernels call: without what a call from Python needs, they compile
a fifth faster. Called from Python they would crash; a test sees to it that none is."""
inlined = partial(njit, inline="always")
"""Decorator of a few lines that are put in place of their calls."""


def stamp_of(file: str | Path, package: Path = PACKAGE) -> str:
    """Hash of a source file and of all files of `package` that it imports, directly or not."""
    seen: dict[Path, bytes] = {}
    waiting = [Path(file).resolve()]
    while waiting:
        path = waiting.pop()
        if path not in seen:
            stat = path.stat()
            seen[path], found = _read(path, stat.st_mtime_ns, stat.st_size, package)
            waiting += found
    whole = sha256()
    for path in sorted(seen):
        whole.update(os.path.relpath(path, package).encode() + b"\0" + seen[path])
    return whole.hexdigest()


@cache
def _read(path: Path, when: int, size: int, package: Path) -> tuple[bytes, tuple[Path, ...]]:
    """Hash of a file, and the files of the package that it imports itself.

    Time and size are asked for so that a file which changes while this runs is read again.
    """
    text = path.read_bytes()
    found: list[Path] = []
    for module, names, plain in IMPORT.findall(ASIDE.sub(" ", text.decode("utf-8"))):
        wanted = _names(plain)
        if module:
            own = _absolute(module, path, package)
            wanted = [own, *(f"{own}.{name}" for name in _names(names))]
        found += [file for name in wanted if (file := _file_of(name, package)) is not None]
    return sha256(text).digest(), tuple(found)


def _names(listed: str) -> list[str]:
    """The names of ``a, b as c``, in brackets perhaps."""
    return [part.split()[0] for part in listed.strip("() \t\n").split(",") if part.strip()]


def _absolute(module: str, path: Path, package: Path) -> str:
    """The full name of a module that the file `path` names, by dots perhaps."""
    name = module.lstrip(".")
    up = len(module) - len(name)
    if up == 0:
        return module
    home = path.parents[up - 1].relative_to(package.parent).parts
    return ".".join((*home, name)).rstrip(".")


@cache
def _file_of(module: str, package: Path) -> Path | None:
    """Source of a module of the package; none for other modules and for names in modules."""
    parts = module.split(".")
    if parts[0] != package.name:
        return None
    path = package.joinpath(*parts[1:])
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


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
            locator._stamp = stamp_of(path, cls.package)
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
            own = f"{self._name}-{self.get_disambiguator()}."
            for file in Path(self.get_cache_path()).glob(f"{glob.escape(self._name)}-*.nb[ci]"):  # type: ignore[attr-defined]
                if not file.name.startswith(own):
                    file.unlink(missing_ok=True)


def keep_by_sources(package: Path) -> None:
    """From now on, stamp the kernels of `package`, a folder, by all their sources."""
    plain = [
        base
        for base in caching.CacheImpl._locator_classes
        if issubclass(base, caching._SourceFileBackedLocatorMixin) and not issubclass(base, Sourced)
    ]
    own = [type(f"Sourced{base.__name__}", (Sourced, base), {"package": package}) for base in plain]
    caching.CacheImpl._locator_classes = [*own, *caching.CacheImpl._locator_classes]


keep_by_sources(PACKAGE)
