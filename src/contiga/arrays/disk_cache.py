"""Keep on the disk what was computed from a file or a body, for the next process.

An entry is known by the digest of what it was made of, with the sources that made it: it is never
out of date. It is a pickle, as a kernel that numba keeps is; so one that anybody else may have
written, or that is damaged, is not opened.
"""

from __future__ import annotations

import os
import pickle
import secrets
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from time import thread_time
from typing import Any, TypeVar

import numpy as np

from contiga.cache_folder import asked_for, cache_folder, is_ours, trim
from contiga.jit.stamps import stamp_of
from contiga.version import __version__

T = TypeVar("T")

LONG = 0.1
"""Seconds to work something out from which on it is kept: to read it takes a tenth."""
MAX_BYTES, MAX_ENTRIES = 512 * 1024**2, 2_000
"""Bytes that all entries may take, and how many there may be; those not asked for the longest go
first."""
_SEAL = 32
"""Bytes of the checksum in front of an entry."""


class DiskCache:
    """Entries of one kind.

    Parameters
    ----------
    kind : what the names of their files begin with
    sources : files of the modules that make them: what these import is part of the key, too
    """

    def __init__(self, kind: str, *sources: str | Path) -> None:
        self._kind, self._sources = kind, sources

    @cached_property
    def _made_by(self) -> str:
        versions = f"{__version__} {sys.version_info[:2]} {np.__version__}"
        return " ".join((self._kind, *map(stamp_of, self._sources), versions))

    def kept(self, key: str | None, build: Callable[[], T]) -> T:
        """Return what is there under a key, or what `build` makes; keep that if it took long.

        Without a key it is built and the disk left alone.
        """
        value: T | None = None if key is None else self.get(key)
        if value is None:
            begun = thread_time()
            value = build()
            if key is not None and thread_time() - begun > LONG:
                self.put(key, value)
        return value

    def get(self, key: str) -> Any | None:
        """Return what was put under a key; None where nothing there can be trusted."""
        folder = cache_folder()
        if folder is None:
            return None
        path = self._path(folder, key)
        with suppress(OSError):
            if not (is_ours(folder) and is_ours(path)):
                return None
            content = path.read_bytes()
            if content[:_SEAL] == sha256(content[_SEAL:]).digest():
                with suppress(Exception):  # of another make of the same version
                    value = pickle.loads(memoryview(content)[_SEAL:])
                    asked_for(path)
                    return value
            path.unlink()
        return None

    def put(self, key: str, value: Any) -> None:
        """Keep a value; nothing is said where that is not possible."""
        folder = cache_folder()
        if folder is None:
            return
        with suppress(OSError, pickle.PicklingError, TypeError, AttributeError):
            content = _pickled(value)
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not is_ours(folder):
                return  # what is written there would not be opened
            path = self._path(folder, key)
            temporary = folder / f"{secrets.token_hex(8)}.new"
            try:
                with open(temporary, "xb", opener=_private) as stream:
                    stream.write(sha256(content).digest() + content)
                temporary.replace(path)
            finally:
                temporary.unlink(missing_ok=True)
            trim(folder, (".kept",), MAX_BYTES, MAX_ENTRIES)

    def _path(self, folder: Path, key: str) -> Path:
        name = sha256(f"{self._made_by}\0{key}".encode()).hexdigest()[:32]
        return folder / f"{self._kind}-{name}.kept"


class _Limited(BytesIO):
    """Takes no more than an entry may be: what is larger is never in memory twice."""

    def write(self, data: Any) -> int:
        if self.tell() + memoryview(data).nbytes > MAX_BYTES // 4:
            raise OSError("larger than an entry may be")
        return super().write(data)


def _pickled(value: Any) -> bytes:
    with _Limited() as stream:
        pickle.dump(value, stream, protocol=5)
        return stream.getvalue()


def _private(path: str, flags: int) -> int:
    """Open a file that nobody else may write to, whatever the process allows others."""
    return os.open(path, flags, 0o600)
