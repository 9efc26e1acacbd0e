"""Folders of files that processes keep for later ones, and their limits. Quick to import."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from contextlib import suppress
from math import inf
from pathlib import Path
from time import time

FOLDER = "CONTIGA_CACHE_DIR"
"""Environment variable: the folder of cached results, or "" or "0" for none."""
DAY = 86_400.0
"""Time after which the use of a file is recorded again, and after which the unfinished files of a
killed process are removed, seconds."""


def cache_folder() -> Path | None:
    """Return the cache folder; None if caching is off or there is no home folder.

    It is the folder of the environment variable `FOLDER`, else the user's, and may not exist yet.
    """
    folder = os.environ.get(FOLDER)
    if folder is not None:
        return None if folder in ("", "0") else Path(folder)
    return user_folder()


def user_folder() -> Path | None:
    """Return the cache folder of the user; None without a home folder.

    It is `contiga` in %LOCALAPPDATA% on Windows, in ~/Library/Caches on macOS, and elsewhere in
    $XDG_CACHE_HOME if that is an absolute path, else in ~/.cache.
    """
    with suppress(RuntimeError):
        home = Path.home()
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local")) / "contiga"
        if sys.platform == "darwin":
            return home / "Library" / "Caches" / "contiga"
        folder = Path(os.environ.get("XDG_CACHE_HOME", ""))
        return (folder if folder.is_absolute() else home / ".cache") / "contiga"
    return None


def is_owned(path: str | Path) -> bool:
    """Return whether this user owns a file or a folder that nobody else may write to.

    True without a look on systems without user numbers (Windows). OSError if there is no such file.
    """
    if not hasattr(os, "geteuid"):
        return True
    status = os.stat(path)
    return status.st_uid == os.geteuid() and not status.st_mode & 0o022


def mark_used(path: str | Path) -> None:
    """Set the modification time of a file to now if it is more than a day old; ignore errors.

    `trim` removes the files with the oldest times.
    """
    with suppress(OSError):
        if os.stat(path).st_mtime < time() - DAY:
            os.utime(path)


def trim(folder: Path, endings: tuple[str, ...], limit: int, count: float = inf) -> list[str]:
    """Remove the least recently used entries of a folder until both limits hold.

    An entry is all files with the same name up to the first point after the last hyphen; its time
    is the newest modification time of its files. Unfinished files (.new, or with .tmp. in the name)
    older than a day are removed, too. Files that cannot be removed stay, without an error, and
    their entry still counts as removed.

    Parameters
    ----------
    folder : the folder, which may have other files, too
    endings : endings of the names of its files
    limit : largest size of all entries, bytes
    count : largest number of entries

    Returns
    -------
    names of the removed entries without their last hyphen, the oldest first
    """
    entries: dict[str, list[str]] = defaultdict(list)
    size: dict[str, int] = defaultdict(int)
    used: dict[str, int] = defaultdict(int)
    with os.scandir(folder) as files:
        for file in files:
            is_unfinished = file.name.endswith(".new") or ".tmp." in file.name
            if not is_unfinished and not file.name.endswith(endings):
                continue
            with suppress(OSError):  # another process has just removed it
                status = file.stat()
                if is_unfinished:
                    if status.st_mtime < time() - DAY:
                        os.unlink(file.path)
                    continue
                head, _, tail = file.name.rpartition("-")
                name = head + tail.partition(".")[0]
                entries[name].append(file.path)
                size[name] += status.st_size
                used[name] = max(used[name], status.st_mtime_ns)
    total, number = sum(size.values()), len(size)
    removed: list[str] = []
    for name in sorted(used, key=used.__getitem__):
        if total <= limit and number <= count:
            break
        for path in entries[name]:
            with suppress(OSError):
                os.unlink(path)
        removed.append(name)
        total, number = total - size[name], number - 1
    return removed
