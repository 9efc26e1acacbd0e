"""HDF5 files that are whole, and never meet a full disk where the system can set room aside.

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
_SEAL_BYTES = 512
"""The least that HDF5 leaves to users at the beginning of a file ("user block")."""


def open_file(path: Path, mode: str) -> Any:
    """An h5py file that is there, for reading ("r") or to be changed ("r+").

    Raises
    ------
    FileError, OutputError
        It cannot be opened for reading, for writing.
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
    """An HDF5 file that is opened for each read, or once for all in a block: to open it and look
    for an array takes longer than to read a step of it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._held: Callable[[str], Any] | None = None

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the file open."""
        with open_file(self._path, "r") as file:
            self._held = cache(file.__getitem__)
            try:
                yield
            finally:
                self._held = None

    @contextmanager
    def arrays(self) -> Iterator[Callable[[str], Any]]:
        """What gives the array of a name."""
        if self._held is not None:
            yield self._held
            return
        with open_file(self._path, "r") as file:
            yield file.__getitem__


_MAGIC = b"\x89HDF\r\n\x1a\n"


@contextmanager
def whole_file(path: Path, *, sealed: bool = False, before: Path | None = None) -> Iterator[Any]:
    """A new h5py file, written in place of an older one when the block ends well.

    Parameters
    ----------
    sealed : with a checksum of all its bytes in front of them: see `is_sealed`
    before : where an older one is kept

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
    """Whether a file was written with a seal, and is what it was then to the last bit.

    One that cannot be read is not.
    """
    try:
        content = path.read_bytes()
    except OSError:
        return False
    return content[:_SEAL_BYTES] == _seal(content[_SEAL_BYTES:])


def begins_as_hdf5(path: Path) -> bool:
    """Whether a file is one of HDF5 without anything in front of it: it was never sealed."""
    with path.open("rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def _seal(image: bytes) -> bytes:
    return f"contiga sha256 {hashlib.sha256(image).hexdigest()}\n".encode().ljust(
        _SEAL_BYTES, b"\0"
    )


def set_aside(file: Any, n_bytes: int, path: Path) -> None:
    """Have the system keep room for what an open h5py file is to grow by.

    Raises
    ------
    OutputError
        There is none. The file is as it was.
    """
    try:
        end = file.id.get_filesize()
        os.posix_fallocate(file.id.get_vfd_handle(), end, n_bytes + SLACK)
    except (AttributeError, OSError) as error:
        full = full_disk(error, path)
        if full is not None:
            raise full from error
        check_room(path, n_bytes)  # neither every system nor every disk can


def close_file(file: Any, path: Path) -> None:
    """Close an h5py file that room was set aside for, and give back what it did not need."""
    try:
        file.flush()
        size = file.id.get_filesize()
    finally:
        file.close()
    if path.stat().st_size > size:
        os.truncate(path, size)
