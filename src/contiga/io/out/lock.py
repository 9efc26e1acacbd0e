"""Locks of folders: one process at a time writes to a folder, and identifies itself.

The lock is the operating system's on a file in the folder: it goes with the process that holds it,
however that ends. The file says who holds it, for those who come second; one that nobody holds is
what a process left that was killed. Where there are no locks (some network drives) all goes on
without. A link in its place is refused: what is written there would be in another file.
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
from contiga.io.out.full_disk import telling_of_full_disks

_OPENED = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
_HELD = (EACCES, EAGAIN, EDEADLK)
_TRIES = 10
"""Number of attempts to open a file that its holder removes at the same moment."""


class FolderLock:
    """A lock of a folder, held until it is released.

    Parameters
    ----------
    path : of the file, in a folder that is there
    kind : what writes to the folder, in words

    Raises
    ------
    OutputError
        Another one writes there; the message says which, on what machine and since when. Or what
        has the name of the file is a link, or no file.

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
            who = {"pid": os.getpid(), "host": socket.gethostname(), "since": _now()}
            with telling_of_full_disks(path):
                os.ftruncate(self._file, 0)
                os.write(self._file, json.dumps(who).encode())

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
    """Return the locked file; None if there are no locks."""
    for _ in range(_TRIES):
        _refuse_others(path)
        try:
            file = os.open(path, _OPENED, 0o666)
        except OSError as error:
            if error.errno == ELOOP:  # replaced by a link in between
                continue
            return None
        try:
            _lock(file)
        except OSError as error:
            os.close(file)
            if error.errno in _HELD:
                raise _is_held(path, kind) from None
            return None
        with suppress(OSError):
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        os.close(file)  # it was removed in between
    return None


def _refuse_others(path: Path) -> None:
    """Refuse a link, symbolic or hard, a folder, a pipe: anything but a file of its own."""
    try:
        found = path.lstat()
    except OSError:
        return
    if not S_ISREG(found.st_mode) or found.st_nlink > 1:
        raise OutputError(
            "is not the lock that a run makes, but a link or another thing of this name",
            where=str(path),
            allowed="a plain file, or none",
            remedy="Remove it",
        )


def _is_held(path: Path, kind: str) -> OutputError:
    try:
        who = json.loads(path.read_text(encoding="utf-8"))
        holder = f"process {who['pid']} on {who['host']}, since {who['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        holder = "a process that does not say which"
    return OutputError(
        f"another {kind} writes to this folder",
        where=str(path.parent),
        found=holder,
        allowed="a folder of its own (-o), or to wait until that one has ended",
    )


def _now() -> str:
    return datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")


if sys.platform == "win32":
    import msvcrt

    _PLACE = 1 << 30
    """Of the byte that is locked, behind what others are to read."""

    def _lock(file: int) -> None:
        os.lseek(file, _PLACE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(file, 0, os.SEEK_SET)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
