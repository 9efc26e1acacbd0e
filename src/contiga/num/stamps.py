"""Hashes of source files and of all that they import: what compiled kernels are known by."""

from __future__ import annotations

import os
import re
from functools import cache
from hashlib import sha256
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]*))",
    re.MULTILINE,
)
ASIDE = re.compile(r"#[^\n]*|\\\n")
"""Comments, and ends of lines that do not end: they are gone when imports are looked for."""


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
