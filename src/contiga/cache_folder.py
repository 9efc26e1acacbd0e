"""Folders of what one process leaves for the next, and how large they grow. Quick to import."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from contextlib import suppress
from math import inf
from pathlib import Path
from time import time

FOLDER = "CONTIGA_CACHE_DIR"
"""Environment variable: the folder of what came of files, or "" or "0" for none."""
DAY = 86_400.0
"""Seconds after which it is written down anew that a file was asked for, and after which what a
killed process has left is removed."""


def cache_folder() -> Path | None:
    """Return the folder of cached results, or None if nothing is cached.

    It is the folder of the environment variable, else the user's.
    """
    named = os.environ.get(FOLDER)
    if named is not None:
        return None if named in ("", "0") else Path(named)
    return user_folder()


def user_folder() -> Path | None:
    """The folder of the user for what can be made again; None where there is no home."""
    with suppress(RuntimeError):
        home = Path.home()
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local")) / "contiga"
        if sys.platform == "darwin":
            return home / "Library" / "Caches" / "contiga"
        named = Path(os.environ.get("XDG_CACHE_HOME", ""))
        return (named if named.is_absolute() else home / ".cache") / "contiga"
    return None


def is_ours(path: str | Path) -> bool:
    """Whether nobody else can have written a file or a folder, as far as the system says."""
    if not hasattr(os, "geteuid"):
        return True
    status = os.stat(path)
    return status.st_uid == os.geteuid() and not status.st_mode & 0o022


def asked_for(path: str | Path) -> None:
    """Have a file stay: write down that it was asked for today, where that can be written."""
    with suppress(OSError):
        if os.stat(path).st_mtime < time() - DAY:
            os.utime(path)


def trim(folder: Path, endings: tuple[str, ...], limit: int, count: float = inf) -> list[str]:
    """Remove the least recently used entries of a folder, and files left half-written.

    An entry is all files whose names are the same up to the first point after the last hyphen.

    Parameters
    ----------
    folder : it may hold other files, too
    endings : of the names of its files
    limit : bytes that the entries which stay may take
    count : how many of them may stay

    Returns
    -------
    names of the entries that were removed
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
