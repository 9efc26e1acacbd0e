"""The folder of compiled kernels of all installations, whose files have stamps in their names.

numba would store them beside the sources, where they outlive the package: pip removes only the
files that it has installed, and a folder that is left behind can still be imported.
"""

from __future__ import annotations

import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile, gettempdir

from numba import config

from contiga.cache_folder import is_owned, trim, user_folder

RECORD = "warmup"
"""Prefix of the names of files that record a warm-up."""
SUFFIXES = (".nbi", ".nbc", ".json")
"""Suffixes of files of kernels and of such records."""
SHARED, PRIVATE = 0o777, 0o700
"""Modes of new folders: the system's default if the user named it, else private."""
LIMIT = 1024**3
"""Largest size of all kernels, bytes: those of some 25 versions of the package."""


def kernel_folder() -> Path | None:
    """Return the folder of kernels, or None if none is writable; it is made if it is missing.

    It is the first writable one of `NUMBA_CACHE_DIR`, the user's cache, and a temporary folder. The
    last two count only if they belong to the user.
    """
    return _kernel_folder(config.CACHE_DIR)


@cache
def _kernel_folder(named: str) -> Path | None:
    """Return the first writable folder, made if missing, or None; `named`: the user's or empty."""
    candidates: list[tuple[Path, int]] = []
    if named:
        candidates.append((Path(named).absolute() / "contiga", SHARED))
    user = user_folder()
    if user is not None:
        candidates.append((user / "kernels", PRIVATE))
    with suppress(OSError):  # no folder of temporary files either
        name = f"contiga-kernels-{os.getuid()}" if hasattr(os, "getuid") else "contiga-kernels"
        candidates.append((Path(gettempdir()) / name, PRIVATE))
    for folder, mode in candidates:
        with suppress(OSError):
            for new_folder in (folder.parent, folder):
                new_folder.mkdir(mode=mode, parents=True, exist_ok=True)
            TemporaryFile(dir=folder).close()
            if mode == SHARED or is_owned(folder):
                return folder
    return None


@cache
def make_room(folder: Path) -> None:
    """Remove the least recently used kernels above `LIMIT`, once per process; ignore errors."""
    with suppress(OSError):
        trim(folder, SUFFIXES, LIMIT)


def remove_kernels() -> int:
    """Remove all kernels of the folder, of any sources; return their number.

    Records of warm-ups are removed too, and not counted.
    """
    folder = kernel_folder()
    if folder is None:
        return 0
    return sum(not name.startswith(RECORD) for name in trim(folder, SUFFIXES, -1))
