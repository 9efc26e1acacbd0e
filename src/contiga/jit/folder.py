"""The folder of compiled kernels, one for all installations: their files are known by stamps.

numba would keep them beside the sources, where they outlive the package: pip removes what it has
installed and nothing else, and a folder that stays behind can still be imported.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile, gettempdir

from numba import config

from contiga.cache_folder import is_ours, trim, user_folder

RECORD = "warmup"
"""What the names of files begin with that say what a warm-up has left here."""
KEPT = (".nbi", ".nbc", ".json")
"""Endings of files of kernels, and of such records."""
SHARED, PRIVATE = 0o777, 0o700
"""Modes of folders that are made: where the user names one, the system says who may enter."""
LIMIT = 1024**3
"""Bytes that all kernels may take: those of some 25 versions of the package."""


def kernel_folder() -> Path | None:
    """The folder that `NUMBA_CACHE_DIR` names, the user's, or one of the user's among temporary
    files, whichever can be written to first; None where none can."""
    return _kernel_folder(config.CACHE_DIR)


@cache
def _kernel_folder(named: str) -> Path | None:
    for folder, mode in _folders(named):
        with suppress(OSError):
            for made in (folder.parent, folder):
                made.mkdir(mode=mode, parents=True, exist_ok=True)
            TemporaryFile(dir=folder).close()
            if mode == SHARED or is_ours(folder):
                return folder
    return None


def _folders(named: str) -> Iterator[tuple[Path, int]]:
    """Folders that may be taken, and who may enter those that are made."""
    if named:
        yield Path(named).absolute() / "contiga", SHARED
    user = user_folder()
    if user is not None:
        yield user / "kernels", PRIVATE
    with suppress(OSError):  # no folder of temporary files either
        name = f"contiga-kernels-{os.getuid()}" if hasattr(os, "getuid") else "contiga-kernels"
        yield Path(gettempdir()) / name, PRIVATE


@cache
def make_room(folder: Path) -> None:
    """Once in a process, remove what takes more than kernels may: what was not used the longest."""
    with suppress(OSError):
        trim(folder, KEPT, LIMIT)


def remove_kernels() -> int:
    """Remove all kernels of the folder, whatever they were compiled from, and say how many."""
    folder = kernel_folder()
    if folder is None:
        return 0
    return sum(not name.startswith(RECORD) for name in trim(folder, KEPT, -1))
