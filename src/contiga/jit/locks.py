"""Locks by name between processes, on the bytes of one file.

A name is a byte of a file in the folder concerned, and a lock is the operating system's on that
byte: it goes with the process that holds it, however that ends, and leaves nothing behind but the
one file. Where there are no locks (a folder that is read only, a file system without them) all goes
on without.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from errno import EACCES, EAGAIN
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import monotonic, sleep

FILE = "kernels.lock"
BYTES = 1 << 31
"""Range of the file's lockable bytes, the largest of Windows; the file itself stays empty."""
PATIENCE = 300.0
"""Time after which a waiting process continues without the lock, seconds.

A stopped process holds its locks.
"""
AGAIN = 0.02

Waiting = Callable[[], AbstractContextManager[object]]


@contextmanager
def alone(
    folder: Path, name: str, waiting: Waiting = nullcontext, patience: float = PATIENCE
) -> Iterator[None]:
    """Hold the lock of a `name` in a folder within this block.

    Parameters
    ----------
    folder : it holds the file, and has to be there
    name : of what is done alone; a process does not wait for itself
    waiting : gives the context of waiting for another process
    patience : s, how long one waits at most
    """
    file, place = _file(folder), int(sha256(name.encode()).hexdigest()[:15], 16) % BYTES
    taken = file is not None and _wait(file, place, waiting, patience)
    try:
        yield
    finally:
        if file is not None and taken:
            _let_go(file, place)


@cache
def _opened(path: str) -> int:
    """Return the file, opened once: closing it would release all locks of the process."""
    return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)


def _file(folder: Path) -> int | None:
    try:
        return _opened(os.path.join(folder, FILE))
    except OSError:
        return None


def _wait(file: int, place: int, waiting: Waiting, patience: float) -> bool:
    """Wait for the byte; return whether this process holds it now."""
    taken = _take(file, place)
    if taken is not None:
        return taken
    end = monotonic() + patience
    with waiting():
        while taken is None and monotonic() < end:
            sleep(AGAIN)
            taken = _take(file, place)
    return bool(taken)


def _take(file: int, place: int) -> bool | None:
    """Lock the byte: True if it is locked, None if another has it, False if it cannot be."""
    try:
        _lock(file, place)
    except OSError as error:
        return None if error.errno in (EACCES, EAGAIN) else False
    return True


if sys.platform == "win32":
    import msvcrt

    def _lock(file: int, place: int) -> None:
        os.lseek(file, place, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

    def _let_go(file: int, place: int) -> None:
        os.lseek(file, place, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _lock(file: int, place: int) -> None:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)

    def _let_go(file: int, place: int) -> None:
        fcntl.lockf(file, fcntl.LOCK_UN, 1, place)
