"""Locks of folders: one process at a time writes to a folder, and identifies itself.

The lock is the operating system's on a file in the folder: it goes with the process that holds it,
however that ends. The file names its holder, for processes that come second; a file that nobody
holds was left by a process that was killed. Without locks (some network drives) all goes on without
them. A link in place of the file is refused: writing there would change another file.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import suppress
from datetime import datetime
from errno import EACCES, EAGAIN, EDEADLK, ELOOP
from pathlib import Path
from stat import S_ISREG

from contiga.errors import OutputError
from contiga.io.out.full_disk import full_disk_errors

_OPEN_FLAGS = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
_LOCKED_ERRORS = (EACCES, EAGAIN, EDEADLK)
_MAX_TRIES = 10
"""Number of attempts to open a file that its holder removes at the same moment."""


class FolderLock:
    """A lock of a folder, held from the start until it is released or the process ends.

    The lock file gets process, machine and time of the holder as JSON. Where the system has no
    locks, none is held and nothing is written.

    Parameters
    ----------
    path : the lock file, in an existing folder
    kind : kind of the process that writes to the folder, in words

    Raises
    ------
    OutputError
        Another process writes there; the message says which, on what machine and since when. Or
        the path is a link, or no plain file.

    >>> lock = FolderLock(Path("run.lock"), "run")
    >>> json.loads(Path("run.lock").read_text())["pid"] == os.getpid()
    True
    >>> lock.release(), Path("run.lock").exists()
    (None, False)
    """

    def __init__(self, path: Path, kind: str) -> None:
        self._path = path
        self._file = _locked_file(path, kind)
        if self._file is not None:
            now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
            holder = {"pid": os.getpid(), "host": socket.gethostname(), "since": now}
            with full_disk_errors(path):
                os.ftruncate(self._file, 0)
                os.write(self._file, json.dumps(holder).encode())

    def release(self) -> None:
        """Release the folder, and remove the lock file; further calls do nothing."""
        file, self._file = self._file, None
        if file is None:
            return
        if sys.platform == "win32":  # open files cannot be removed there
            os.close(file)
        with suppress(OSError):
            self._path.unlink()
        if sys.platform != "win32":
            os.close(file)


def _locked_file(path: Path, kind: str) -> int | None:
    """Return the descriptor of the lock file, opened or made, and locked.

    It is None if the file cannot be opened, or the system has no locks. A file that was removed, or
    replaced by a link, in between is tried again, up to `_MAX_TRIES` times; then it is None, too.

    Raises
    ------
    OutputError
        Another process holds the lock; the path is a link, a folder or the like.
    """
    for _ in range(_MAX_TRIES):
        status = None
        with suppress(OSError):
            status = path.lstat()
        # links, symbolic or hard, folders, pipes
        if status is not None and (not S_ISREG(status.st_mode) or status.st_nlink > 1):
            raise OutputError(
                "is not the lock that a run makes, but a link or another thing of this name",
                where=str(path),
                allowed="a plain file, or none",
                remedy="Remove it",
            )
        try:
            file = os.open(path, _OPEN_FLAGS, 0o666)
        except OSError as error:
            if error.errno == ELOOP:  # replaced by a link in between
                continue
            return None
        try:
            _lock(file)
        except OSError as error:
            os.close(file)
            if error.errno not in _LOCKED_ERRORS:
                return None
            raise _locked_error(path, kind) from None
        with suppress(OSError):
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        os.close(file)  # it was removed in between
    return None


def _locked_error(path: Path, kind: str) -> OutputError:
    """Return the error that another process holds a lock; the file names it, if it can be read."""
    try:
        holder = json.loads(path.read_text(encoding="utf-8"))
        holder = f"process {holder['pid']} on {holder['host']}, since {holder['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        holder = "a process that does not say which"
    return OutputError(
        f"another {kind} writes to this folder",
        where=str(path.parent),
        found=holder,
        allowed="a folder of its own (-o), or to wait until that one has ended",
    )


if sys.platform == "win32":
    import msvcrt

    _LOCKED_BYTE = 1 << 30
    """Position of the locked byte, behind the text that other processes read."""

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(file, 0, os.SEEK_SET)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
