"""Disk cache of CAD files: results by the file's bytes, without loading their reader."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from contiga.errors import ContigaWarning
from contiga.io.cad.formats import FORMATS, cache_prefix
from contiga.io.worker import outcome_in_worker

if TYPE_CHECKING:
    from contiga.arrays.disk_cache import DiskCache

T = TypeVar("T")
_CHECKS = Path(__file__).with_name("read_cad.py")


def _disk_cache(file: Path, *sources: Path) -> DiskCache:
    """Return the cache of results that depend on a file's reader, checks and `sources`."""
    # The reader is not imported for its stamp; numba is, while a worker loads a reader.
    from contiga.arrays.disk_cache import DiskCache

    module = Path(__file__).with_name(f"{FORMATS[file.suffix.lower()].reader}.py")
    return DiskCache(cache_prefix(file), module, _CHECKS, *sources)


def read_cached(
    target: str,
    file: Path,
    *args: object,
    needs: str,
    check: Callable[[Any], None],
) -> Any:
    """Return the result of `read_in_worker` for a file, cached on disk by the file's bytes.

    A result is cached with its warnings; errors are not, nor is that of a file which is rewritten
    in the meantime. The cache also depends on the path, `args`, the sources of the reader and the
    version of its package.

    Parameters
    ----------
    target, file, args, needs : as for `read_in_worker`
    check : called with a new result, not with a cached one; what it refuses is not cached

    Raises
    ------
    ContigaError
        As `read_in_worker` and `check`.

    Warns
    -----
    ContigaWarning
        The warnings of the reader, each time.
    """
    cache, key, prefix = _disk_cache(file), _key(target, file, args), cache_prefix(file)
    entry = cache.get(key)
    if entry is not None:
        content, messages = entry
        _warn(messages)
        return content
    outcome = outcome_in_worker(target, file, *args, needs=needs)
    messages = list(outcome.warnings)
    _warn(messages)
    content = outcome.value()
    check(content)
    if cache_prefix(file) == prefix:  # the file has not been rewritten in the meantime
        cache.put(key, (content, messages))
    return content


def _warn(messages: list[str]) -> None:
    """Issue warnings that point at the caller's caller."""
    for text in messages:
        warnings.warn(text, ContigaWarning, stacklevel=4)


def cached_answer(file: Path, request: str, source: str, make: Callable[[], T]) -> T:
    """Return the answer of `make`, or the one cached on disk for the same bytes of a file.

    An answer with warnings of contiga is not cached, nor is None, or an answer about a file which
    is rewritten in the meantime. All warnings are issued when `make` has ended, also by an error.

    Parameters
    ----------
    file : the CAD file
    request : label of the answer
    source : file of the module that makes it
    make : function that computes the answer

    Raises
    ------
    ContigaError
        As `make`.
    """
    try:
        cache, prefix = _disk_cache(file, Path(source)), cache_prefix(file)
    except OSError:  # reported when the file is read
        return make()
    key = _key(request, file, ())
    answer: T | None = cache.get(key)
    if answer is not None:
        return answer
    has_warnings = False
    try:
        with warnings.catch_warnings(record=True) as records:
            warnings.simplefilter("always", ContigaWarning)
            answer = make()
    finally:
        for item in records:
            if issubclass(item.category, ContigaWarning):
                has_warnings = True
                warnings.warn(str(item.message), ContigaWarning, stacklevel=3)
            else:
                warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
    if not has_warnings and cache_prefix(file) == prefix:
        cache.put(key, answer)
    return answer


def _key(request: str, file: Path, args: tuple[object, ...]) -> str:
    """Return the key of an answer: everything but the bytes that determines it."""
    return repr((request, str(file), args, _package_stamp(file.suffix.lower())))


@lru_cache(maxsize=8)
def _package_stamp(suffix: str) -> str:
    """Return a text of path and time of the packages that read a suffix; "" without any installed.

    It changes with their version.
    """
    stamps = []
    for name in FORMATS[suffix].packages:
        with suppress(ImportError):  # reported when the file is read
            spec = find_spec(name)
            if spec is not None and spec.origin is not None:
                stamps.append(f"{spec.origin} {Path(spec.origin).stat().st_mtime_ns}")
    return " ".join(stamps)
