"""The formats of CAD files: suffixes, what reads them, and a reader loaded ahead of its file.

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
"""What reads files of a suffix and has to be installed."""
READERS = dict.fromkeys(SUFFIXES[:4], "step_iges") | {".3dm": "rhino", ".xml": "gismo"}
"""Modules beside this one, with functions `read_<module>` and `list_<module>`."""
_QUOTED = re.compile(r"\"([^\"\n]*)\"|'([^'\n]*)'")


def reader(suffix: str, verb: str = "read") -> str:
    """What `read_in_worker` is to call for files of a suffix; "read" or "list".

    >>> reader(".igs")
    'contiga.io.cad.step_iges:read_step_iges'
    """
    return f"contiga.io.cad.{READERS[suffix]}:{verb}_{READERS[suffix]}"


def expect_cad(*files: Path) -> None:
    """Have OpenCASCADE loaded beside the rest where files need it that were never read before.

    It takes as long to load as all else. Where none is to be read in the end, the process that has
    loaded it ends for want of work.
    """
    for file in files:
        suffix = file.suffix.lower()
        if "OCP" in PACKAGES.get(suffix, ()) and not was_read(file):
            prepare(reader(suffix))
            return


def cad_files_in(text: str, folder: Path) -> list[Path]:
    """Files in quotes that a case in `folder` names and that may need OpenCASCADE.

    >>> [file.name for file in cad_files_in('geometry = { file = "a b.STEP" } # "c.stl"', Path())]
    ['a b.STEP']
    """
    named = (one or other for one, other in _QUOTED.findall(text))
    return [folder / name for name in named if "OCP" in PACKAGES.get(Path(name).suffix.lower(), ())]


def was_read(file: Path) -> bool:
    """Whether what came of a file of the same bytes is kept, whatever was asked of it."""
    folder = cache_folder()
    try:
        return folder is not None and any(folder.glob(f"{kept_as(file)}-*"))
    except OSError:  # it is told when the file is to be read
        return False


def kept_as(file: Path) -> str:
    """What names of entries begin with, of `contiga.arrays.disk_cache`, of a file's bytes."""
    stat = file.stat()
    return f"cad-{_digest(str(file), stat.st_mtime_ns, stat.st_size)[:32]}"


@lru_cache(maxsize=64)
def _digest(file: str, when: int, size: int) -> str:
    """Of a file's bytes; time and size are asked for so that one that changes is read again."""
    with open(file, "rb") as stream:
        return file_digest(stream, "sha256").hexdigest()
