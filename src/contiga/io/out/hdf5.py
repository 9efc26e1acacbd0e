"""HDF5 files that are whole, with reserved space if the system can reserve it.

A file that the library cannot write to the end is lost to it, and may take the process with it. So
files that are written at once are made in memory and handed to the disk as bytes, and room for what
a file grows by is set aside before the library writes to it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from contiga.errors import FileError, OutputError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.io.out.full_disk import SLACK, check_room, full_disk

# The oldest layout is what every reader knows, and it has no in-use mark that would keep a file
# shut after a crash.
_LAYOUT = ("earliest", "v110")
_MAGIC = b"\x89HDF\r\n\x1a\n"
_SEAL_BYTES = 512
"""Smallest user block of HDF5 at the beginning of a file, bytes."""


def open_file(path: Path, mode: str) -> Any:
    """Return an existing h5py file, open for reading ("r") or changes ("r+"), without its lock.

    Raises
    ------
    FileError
        It cannot be opened for reading.
    OutputError
        It cannot be opened for changes, or the disk is full.
    MissingPackageError
        h5py is not installed.
    """
    require("a file of fields over time", "h5py")
    import h5py

    try:
        # Without the lock, ParaView may look on during a run.
        return h5py.File(path, mode, libver=_LAYOUT, locking=False)
    except OSError as error:
        kind = FileError if mode == "r" else OutputError
        full = full_disk(error, path)
        raise full or kind(f"cannot be opened as HDF5: {error}", where=str(path)) from error


class ReadFile:
    """An HDF5 file that is opened for each read, or once for a block.

    Opening it and finding an array takes longer than reading a step.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._array: Callable[[str], Any] | None = None
        """Function that returns the array of a name, while the file is held open."""

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the file open within this block; arrays that are asked for are found once."""
        with open_file(self._path, "r") as file:
            self._array = cache(file.__getitem__)
            try:
                yield
            finally:
                self._array = None

    @contextmanager
    def arrays(self) -> Iterator[Callable[[str], Any]]:
        """Provide a function that returns the h5py array of a name, a KeyError without one.

        It is valid within this block.
        """
        if self._array is not None:
            yield self._array
            return
        with open_file(self._path, "r") as file:
            yield file.__getitem__


@contextmanager
def whole_file(path: Path, *, sealed: bool = False, before: Path | None = None) -> Iterator[Any]:
    """Provide a new h5py file in memory, which replaces an older one when the block ends well.

    Parameters
    ----------
    path : the file
    sealed : with a checksum of all its bytes in front of them: see `is_sealed`
    before : new path of an older file

    Raises
    ------
    OutputError
        It cannot be written.
    """
    import h5py

    block = _SEAL_BYTES if sealed else 0
    options = {"driver": "core", "backing_store": False, "userblock_size": block}
    with h5py.File(path.name, "w", libver=_LAYOUT, **options) as file:
        yield file
        file.flush()
        image: bytes = file.id.get_file_image()  # without the user block
    with atomic_write(path, before) as temporary:
        temporary.write_bytes((_seal(image) if sealed else b"") + image)


def is_sealed(path: Path) -> bool:
    """Return whether a file can be read, and has a seal that fits all its bytes (SHA-256)."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    return content[:_SEAL_BYTES] == _seal(content[_SEAL_BYTES:])


def begins_as_hdf5(path: Path) -> bool:
    """Return whether a file is HDF5 without a user block: it was never sealed."""
    with path.open("rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def _seal(image: bytes) -> bytes:
    """Return the user block of `_SEAL_BYTES` with the checksum of what follows it."""
    return f"contiga sha256 {hashlib.sha256(image).hexdigest()}\n".encode().ljust(
        _SEAL_BYTES, b"\0"
    )


def set_aside(file: Any, n_bytes: int, path: Path) -> None:
    """Reserve `n_bytes` and `SLACK` behind the content of an open h5py file.

    Where the system cannot reserve space, free space is checked instead.

    Raises
    ------
    OutputError
        The disk is full. The content of the file is unchanged.
    """
    try:
        end = file.id.get_filesize()
        os.posix_fallocate(file.id.get_vfd_handle(), end, n_bytes + SLACK)
    except (AttributeError, OSError) as error:
        full = full_disk(error, path)
        if full is not None:
            raise full from error
        check_room(path, n_bytes)  # some systems and disks cannot reserve space


def close_file(file: Any, path: Path) -> None:
    """Flush and close an h5py file, and cut off the reserved space that is not used.

    If flushing fails the file is closed all the same, and the error passes.
    """
    try:
        file.flush()
        size = file.id.get_filesize()
    finally:
        file.close()
    if path.stat().st_size > size:
        os.truncate(path, size)
