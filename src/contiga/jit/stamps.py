"""Hashes of source files and of all that they import: what compiled kernels are known by."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).resolve().parents[1]
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]*))",
    re.MULTILINE,
)
ASIDE = re.compile(r"#[^\n]*|\\\n")
"""Comments, and ends of lines that do not end: they are gone when imports are looked for."""
PACKAGES = [PACKAGE]
"""Folders of packages whose kernels are kept by such hashes."""
LOCAL = "<locals>"
"""In the names of functions made in functions: there may be several of one name."""
_IMPORTED: dict[str, tuple[Any, str]] = {}
"""Of a file imported by this process: the import (its specification), and the stamp then."""


def stamp_at_import(function: Callable[..., Any]) -> str:
    """`stamp_of` the file of a function, taken once for all functions of an import of it.

    What is in memory is what was imported: a file that has changed since has another stamp.
    """
    file, spec = function.__code__.co_filename, function.__globals__.get("__spec__")
    known, stamp = _IMPORTED.get(file, (None, ""))
    if spec is None or known is not spec:
        above = Path(file).resolve().parents
        holders = (package for package in reversed(PACKAGES) if package in above)
        stamp = stamp_of(file, next(holders, PACKAGE))
        _IMPORTED[file] = spec, stamp
    return stamp


def stamp_of(file: str | Path, package: Path = PACKAGE) -> str:
    """Hash of a source file and of all files of `package` that it imports, directly or not."""
    whole = sha256()
    for _, content in sorted(_with_imports(file, package).items()):
        whole.update(content)
    return whole.hexdigest()


def sources_of(files: Iterable[str | Path]) -> list[str]:
    """Names of files of the package and of all that they import, from the package's folder on."""
    paths = {path for file in files for path in _with_imports(file, PACKAGE)}
    return sorted(Path(path).relative_to(PACKAGE).as_posix() for path in paths)


def stamp_of_files(names: Iterable[str]) -> str:
    """Hash of so named files of the package; OSError where one is not there."""
    whole = sha256()
    for name in names:
        whole.update(_hashed(name, PACKAGE.joinpath(name).read_bytes()))
    return whole.hexdigest()


def _with_imports(file: str | Path, package: Path) -> dict[str, bytes]:
    """Name and hash of a file and of all files of the package that it imports, by their paths."""
    seen: dict[str, bytes] = {}
    waiting = [os.path.realpath(file)]
    while waiting:
        path = waiting.pop()
        if path not in seen:
            stat = os.stat(path)
            seen[path], imported = _read(path, stat.st_mtime_ns, stat.st_size, package)
            waiting += imported
    return seen


def _hashed(name: str, text: bytes) -> bytes:
    return name.encode() + b"\0" + sha256(text).digest()


@cache
def _read(path: str, when: int, size: int, package: Path) -> tuple[bytes, tuple[str, ...]]:
    """Name and hash of a file, and the files of the package that it imports itself.

    Time and size are asked for so that a file which changes while this runs is read again.
    """
    text = Path(path).read_bytes()
    imported: list[str] = []
    for module, names, plain in IMPORT.findall(ASIDE.sub(" ", text.decode("utf-8"))):
        wanted = _names(plain)
        if module:
            absolute = _absolute(module, Path(path), package)
            wanted = [absolute, *(f"{absolute}.{name}" for name in _names(names))]
        imported += [file for name in wanted if (file := _file_of(name, package)) is not None]
    return _hashed(os.path.relpath(path, package), text), tuple(dict.fromkeys(imported))


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
def _file_of(module: str, package: Path) -> str | None:
    """Source of a module of the package; none for other modules and for names in modules."""
    parts = module.split(".")
    if parts[0] != package.name:
        return None
    path = package.joinpath(*parts[1:])
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return str(file)
    return None
