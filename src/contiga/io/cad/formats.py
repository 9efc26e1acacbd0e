"""The formats of CAD files: suffixes, readers, and preparation of a reader.

Nothing here takes time to import.
"""

from __future__ import annotations

import re
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path
from typing import NamedTuple

from contiga.cache_folder import cache_folder
from contiga.io.worker import prepare


class Format(NamedTuple):
    """A format of CAD files."""

    reader: str
    """Module beside this one, with functions `read_<reader>` and `list_<reader>`."""
    packages: tuple[str, ...] = ()
    """Packages that must be installed to read its files."""


IGES_SUFFIXES = (".iges", ".igs")
FORMATS = {
    **dict.fromkeys((".step", ".stp", *IGES_SUFFIXES), Format("step_iges", ("OCP",))),
    ".3dm": Format("rhino", ("rhino3dm",)),
    ".xml": Format("gismo"),
}
"""Formats by suffix."""
SUFFIXES = tuple(FORMATS)
_QUOTED = re.compile(r"\"([^\"\n]*)\"|'([^'\n]*)'")


def reader(suffix: str, verb: str = "read") -> str:
    """Return the target of `read_in_worker` for files of a suffix; `verb` is "read" or "list".

    >>> reader(".igs")
    'contiga.io.cad.step_iges:read_step_iges'
    """
    module = FORMATS[suffix].reader
    return f"contiga.io.cad.{module}:{verb}_{module}"


def _needs_opencascade(file: Path) -> bool:
    form = FORMATS.get(file.suffix.lower())
    return form is not None and "OCP" in form.packages


def expect_cad(*files: Path) -> None:
    """Let a worker load OpenCASCADE if one of `files` needs it and is not cached.

    Loading is not waited for. It takes as long as the rest of the program. If no file is read in
    the end, the process that has loaded it ends when it gets no work.
    """
    for file in files:
        if _needs_opencascade(file) and not is_cached(file):
            prepare(reader(file.suffix.lower()))
            return


def cad_files_in(text: str, folder: Path) -> list[Path]:
    """Return the quoted file names in the text of a case that may need OpenCASCADE, in `folder`.

    Comments are searched too, and the files need not exist.

    >>> [file.name for file in cad_files_in('geometry = { file = "a b.STEP" } # "c.stl"', Path())]
    ['a b.STEP']
    """
    names = (double or single for double, single in _QUOTED.findall(text))
    return [folder / name for name in names if _needs_opencascade(Path(name))]


def is_cached(file: Path) -> bool:
    """Return whether any results of a file's bytes are cached; False if it cannot be read."""
    folder = cache_folder()
    try:
        return folder is not None and any(folder.glob(f"{cache_prefix(file)}-*"))
    except OSError:  # reported when the file is read
        return False


def cache_prefix(file: Path) -> str:
    """Return the beginning of the names of cache entries for a file's bytes.

    The file is read, unless it was before and its time and size are the same; an OSError passes.
    """
    stat = file.stat()
    return f"cad-{_digest(str(file), stat.st_mtime_ns, stat.st_size)[:32]}"


@lru_cache(maxsize=64)
def _digest(file: str, modified: int, size: int) -> str:
    """Return the digest of a file's bytes; time and size only serve as keys of this cache."""
    with open(file, "rb") as stream:
        return file_digest(stream, "sha256").hexdigest()
