"""The formats of CAD files: suffixes, readers, and preparation of a reader.

Nothing here takes time to import.
"""

from __future__ import annotations

import re
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path

from contiga.cache_folder import cache_folder
from contiga.io.worker import prepare

SUFFIXES = (".step", ".stp", ".iges", ".igs", ".3dm", ".xml")
PACKAGES = dict.fromkeys(SUFFIXES[:4], ("OCP",)) | {".3dm": ("rhino3dm",), ".xml": ()}
"""Packages that must be installed to read files of a suffix."""
READERS = dict.fromkeys(SUFFIXES[:4], "step_iges") | {".3dm": "rhino", ".xml": "gismo"}
"""Modules beside this one, with functions `read_<module>` and `list_<module>`."""
_QUOTED = re.compile(r"\"([^\"\n]*)\"|'([^'\n]*)'")


def reader(suffix: str, verb: str = "read") -> str:
    """Return the target of `read_in_worker` for files of a suffix; `verb` is "read" or "list".

    >>> reader(".igs")
    'contiga.io.cad.step_iges:read_step_iges'
    """
    return f"contiga.io.cad.{READERS[suffix]}:{verb}_{READERS[suffix]}"


def expect_cad(*files: Path) -> None:
    """Let a worker load OpenCASCADE if files need it that are not cached.

    Loading it takes as long as the rest of the program. If no file is read in the end, the process
    that has loaded it ends when it gets no work.
    """
    for file in files:
        suffix = file.suffix.lower()
        if "OCP" in PACKAGES.get(suffix, ()) and not is_cached(file):
            prepare(reader(suffix))
            return


def cad_files_in(text: str, folder: Path) -> list[Path]:
    """Return the quoted files of a case in `folder` that may need OpenCASCADE.

    >>> [file.name for file in cad_files_in('geometry = { file = "a b.STEP" } # "c.stl"', Path())]
    ['a b.STEP']
    """
    names = (double or single for double, single in _QUOTED.findall(text))
    return [folder / name for name in names if "OCP" in PACKAGES.get(Path(name).suffix.lower(), ())]


def is_cached(file: Path) -> bool:
    """Return whether any results of a file with the same bytes are cached."""
    folder = cache_folder()
    try:
        return folder is not None and any(folder.glob(f"{cache_prefix(file)}-*"))
    except OSError:  # reported when the file is read
        return False


def cache_prefix(file: Path) -> str:
    """Return the beginning of the names of cache entries for a file's bytes."""
    stat = file.stat()
    return f"cad-{_digest(str(file), stat.st_mtime_ns, stat.st_size)[:32]}"


@lru_cache(maxsize=64)
def _digest(file: str, modified: int, size: int) -> str:
    """Return the digest of a file's bytes; time and size only serve as keys of this cache."""
    with open(file, "rb") as stream:
        return file_digest(stream, "sha256").hexdigest()
