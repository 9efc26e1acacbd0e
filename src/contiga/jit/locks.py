"""Locks by name between processes, on the bytes of one file.

A name is mapped to a byte of a file in the folder concerned, and its lock is the operating system's
lock of that byte: it ends with the process that holds it, however that ends, and leaves nothing but
the one file. Where locks are not possible (a read-only folder, a file system without them) the
block runs without.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from errno import EACCES, EAGAIN
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import monotonic, sleep

FILE = "kernels.lock"
N_BYTES = 1 << 31
"""Range of the file's lockable bytes, the largest of Windows; the file itself stays empty."""
MAX_WAIT = 300.0
"""Time after which a waiting process continues without the lock, seconds.

A stopped process holds its locks.
"""
POLL_INTERVAL = 0.02
"""Time between attempts to get a lock, seconds."""

Waiting = Callable[[], AbstractContextManager[object]]


@contextmanager
def alone(
    folder: Path, name: str, waiting: Waiting = nullcontext, patience: float = MAX_WAIT
) -> Iterator[None]:
    """Hold the lock of a `name` in a folder within this block.

    The block runs without the lock if locks are not possible there, or after the longest wait.

    Parameters
    ----------
    folder : an existing folder, which contains the file
    name : name of the work; a process does not wait for itself
    waiting : returns a context that is entered while the process waits for another
    patience : longest wait, seconds
    """
    place = int(sha256(name.encode()).hexdigest()[:15], 16) % N_BYTES
    file: int | None = None
    with suppress(OSError):
        file = _open_once(os.path.join(folder, FILE))
    is_locked = False if file is None else _try_lock(file, place)
    if file is not None and is_locked is None:
        end = monotonic() + patience
        with waiting():
            while is_locked is None and monotonic() < end:
                sleep(POLL_INTERVAL)
                is_locked = _try_lock(file, place)
    try:
        yield
    finally:
        if file is not None and is_locked:
            _unlock(file, place)


@cache
def _open_once(path: str) -> int:
    """Return the descriptor of a file, opened once: closing it would release all its locks."""
    return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)


def _try_lock(file: int, place: int) -> bool | None:
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

    def _unlock(file: int, place: int) -> None:
        os.lseek(file, place, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _lock(file: int, place: int) -> None:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)

    def _unlock(file: int, place: int) -> None:
        fcntl.lockf(file, fcntl.LOCK_UN, 1, place)
