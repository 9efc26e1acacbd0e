"""Stamps of compiled kernels: hashes of source files and of all that they import."""

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
IGNORED_TEXT = re.compile(r"#[^\n]*|\\\n")
"""Comments and continued line ends, which are removed before imports are looked for."""
PACKAGES = [PACKAGE]
"""Folders of packages whose kernels have such stamps."""
LOCAL = "<locals>"
"""Mark of a local function in a name, which may not be unique."""
_IMPORTED: dict[str, tuple[Any, str]] = {}
"""Import specification and stamp of each file imported by this process."""


def stamp_at_import(function: Callable[..., Any]) -> str:
    """Return `stamp_of` the file of a function, computed once per import of its module.

    The code in memory is that of the import: a file that has changed since has another stamp. The
    package is the last of `PACKAGES` that holds the file, else contiga.
    """
    file, spec = function.__code__.co_filename, function.__globals__.get("__spec__")
    last_spec, stamp = _IMPORTED.get(file, (None, ""))
    if spec is None or last_spec is not spec:
        parents = Path(file).resolve().parents
        holders = (package for package in reversed(PACKAGES) if package in parents)
        stamp = stamp_of(file, next(holders, PACKAGE))
        _IMPORTED[file] = spec, stamp
    return stamp


def stamp_of(file: str | Path, package: Path = PACKAGE) -> str:
    """Return the hash of a source file and of all files of `package` that it imports.

    Indirect imports count.
    """
    hasher = sha256()
    for _, content in sorted(_with_imports(file, package).items()):
        hasher.update(content)
    return hasher.hexdigest()


def sources_of(files: Iterable[str | Path]) -> list[str]:
    """Return `files` and the contiga modules they import: sorted paths relative to the package."""
    paths = {path for file in files for path in _with_imports(file, PACKAGE)}
    return sorted(Path(path).relative_to(PACKAGE).as_posix() for path in paths)


def stamp_of_files(names: Iterable[str]) -> str:
    """Return the hash of files of the package; raise OSError if one is missing."""
    hasher = sha256()
    for name in names:
        hasher.update(_hashed(name, PACKAGE.joinpath(name).read_bytes()))
    return hasher.hexdigest()


def _with_imports(file: str | Path, package: Path) -> dict[str, bytes]:
    """Return name and hash of a file and of its imports in the package, by path.

    Indirect imports are among them.
    """
    hashes: dict[str, bytes] = {}
    pending = [os.path.realpath(file)]
    while pending:
        path = pending.pop()
        if path not in hashes:
            stat = os.stat(path)
            hashes[path], imported = _read(path, stat.st_mtime_ns, stat.st_size, package)
            pending += imported
    return hashes


def _hashed(name: str, text: bytes) -> bytes:
    """Return the name and the hash of a text."""
    return name.encode() + b"\0" + sha256(text).digest()


@cache
def _read(path: str, when: int, size: int, package: Path) -> tuple[bytes, tuple[str, ...]]:
    """Return name and hash of a file, and the files of the package that it imports itself.

    Imports are found by their text, wherever they are in the file, each once. Time and size are
    arguments so that a file which changes while this process runs is read again.
    """
    text = Path(path).read_bytes()
    imported: list[str] = []
    for module, names, plain in IMPORT.findall(IGNORED_TEXT.sub(" ", text.decode("utf-8"))):
        modules = _names(plain)
        if module:
            absolute = module
            if level := len(module) - len(module.lstrip(".")):  # relative to this file
                parts = Path(path).parents[level - 1].relative_to(package.parent).parts
                absolute = ".".join((*parts, module[level:])).rstrip(".")
            modules = [absolute, *(f"{absolute}.{name}" for name in _names(names))]
        imported += [file for name in modules if (file := _file_of(name, package)) is not None]
    return _hashed(os.path.relpath(path, package), text), tuple(dict.fromkeys(imported))


def _names(listed: str) -> list[str]:
    """Return the names in ``a, b as c``, with or without brackets."""
    return [part.split()[0] for part in listed.strip("() \t\n").split(",") if part.strip()]


@cache
def _file_of(module: str, package: Path) -> str | None:
    """Return the path of a module's source file; None if there is no such file in the package."""
    parts = module.split(".")
    if parts[0] != package.name:
        return None
    path = package.joinpath(*parts[1:])
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return str(file)
    return None
