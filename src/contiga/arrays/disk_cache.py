"""Cache on the disk what was computed from a file or a body, for the next process.

The name of an entry contains the digest of its input and of the sources that computed it, so that
it is never out of date. Like the kernels that numba caches it is a pickle; an entry that another
user could have written, or that is damaged, is not opened.
"""

from __future__ import annotations

import os
import pickle
import secrets
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property, partial
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from time import thread_time
from typing import Any, TypeVar

import numpy as np

from contiga.cache_folder import cache_folder, is_owned, mark_used, trim
from contiga.jit.stamps import stamp_of
from contiga.version import __version__

T = TypeVar("T")

MIN_SECONDS = 0.1
"""Least computing time of entries, seconds: reading one takes a tenth of that."""
MAX_BYTES, MAX_ENTRIES = 512 * 1024**2, 2_000
"""Largest size and number of all entries; the least recently used ones are removed first."""
_CHECKSUM_SIZE = 32
"""Bytes of the checksum in front of an entry."""


class DiskCache:
    """Entries of one kind.

    Parameters
    ----------
    kind : prefix of the names of their files
    sources : files of the modules that compute them; the key also covers the modules they import
    """

    def __init__(self, kind: str, *sources: str | Path) -> None:
        self._kind, self._sources = kind, sources

    @cached_property
    def _source_stamp(self) -> str:
        """Text that changes with the kind, the sources and the versions behind an entry."""
        versions = f"{__version__} {sys.version_info[:2]} {np.__version__}"
        return " ".join((self._kind, *map(stamp_of, self._sources), versions))

    def get_or_build(self, key: str | None, build: Callable[[], T]) -> T:
        """Return the entry of a key, or the result of `build` if there is none.

        The result is stored if the thread computed it for longer than `MIN_SECONDS`. Without a key
        it is built and not stored.
        """
        value: T | None = None if key is None else self.get(key)
        if value is None:
            start = thread_time()
            value = build()
            if key is not None and thread_time() - start > MIN_SECONDS:
                self.put(key, value)
        return value

    def get(self, key: str) -> Any | None:
        """Return the entry of a key; None if there is none, or none that can be trusted.

        An entry that is damaged or cannot be unpickled is removed; one that another user could have
        written stays unread. A returned entry is marked as used today.
        """
        folder = cache_folder()
        if folder is None:
            return None
        path = self._path(folder, key)
        with suppress(OSError):
            if not (is_owned(folder) and is_owned(path)):
                return None
            content = path.read_bytes()
            if content[:_CHECKSUM_SIZE] == sha256(content[_CHECKSUM_SIZE:]).digest():
                with suppress(Exception):  # of another make of the same version
                    value = pickle.loads(memoryview(content)[_CHECKSUM_SIZE:])
                    mark_used(path)
                    return value
            path.unlink()
        return None

    def put(self, key: str, value: Any) -> None:
        """Store a value under a key, and remove the least recently used entries above the limits.

        Nothing happens without a folder of the user's own, or for a value that cannot be pickled
        or takes more than a quarter of `MAX_BYTES`.
        """
        folder = cache_folder()
        if folder is None:
            return
        with suppress(OSError, pickle.PicklingError, TypeError, AttributeError):
            with _Limited() as buffer:
                pickle.dump(value, buffer, protocol=5)
                content = buffer.getvalue()
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not is_owned(folder):
                return  # entries there would not be opened
            path = self._path(folder, key)
            temporary = folder / f"{secrets.token_hex(8)}.new"
            # No other user may open it, whatever the umask.
            private = partial(os.open, mode=0o600)
            try:
                with open(temporary, "xb", opener=private) as stream:
                    stream.write(sha256(content).digest() + content)
                temporary.replace(path)
            finally:
                temporary.unlink(missing_ok=True)
            trim(folder, (".kept",), MAX_BYTES, MAX_ENTRIES)

    def _path(self, folder: Path, key: str) -> Path:
        """Return the file of an entry, named by the digest of sources and key."""
        name = sha256(f"{self._source_stamp}\0{key}".encode()).hexdigest()[:32]
        return folder / f"{self._kind}-{name}.kept"


class _Limited(BytesIO):
    """A buffer with the size limit of an entry, so that a larger one is never in memory twice."""

    def write(self, data: Any) -> int:
        if self.tell() + memoryview(data).nbytes > MAX_BYTES // 4:
            raise OSError("larger than an entry may be")
        return super().write(data)
