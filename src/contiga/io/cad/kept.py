"""The cache of CAD files: results by the file's bytes, without loading their reader."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from contiga.errors import ContigaWarning
from contiga.io.cad.formats import PACKAGES, READERS, kept_as
from contiga.io.worker import outcome_in_worker

if TYPE_CHECKING:
    from contiga.arrays.disk_cache import DiskCache

T = TypeVar("T")
_CHECKS = Path(__file__).with_name("read_cad.py")


def _files(file: Path, *sources: Path) -> DiskCache:
    """Return the cache of results that depend on a file's reader, checks and `sources`."""
    # The reader is not imported for that; numba is, while a worker loads a reader.
    from contiga.arrays.disk_cache import DiskCache

    module = Path(__file__).with_name(f"{READERS[file.suffix.lower()]}.py")
    return DiskCache(kept_as(file), module, _CHECKS, *sources)


def read_kept(
    target: str,
    file: Path,
    *args: object,
    needs: str,
    check: Callable[[Any], None],
) -> Any:
    """Return what `read_in_worker` gives for a file, or gave for the same bytes before.

    Parameters
    ----------
    target, file, args, needs : as for `read_in_worker`
    check : called with what was read anew; what it refuses is not kept

    Raises
    ------
    ContigaError
        As `read_in_worker` and `check`.

    Warns
    -----
    ContigaWarning
        What the reader warns of, each time.
    """
    files, key, read = _files(file), _key(target, file, args), kept_as(file)
    kept = files.get(key)
    if kept is not None:
        content, said = kept
        _warn(said)
        return content
    outcome = outcome_in_worker(target, file, *args, needs=needs)
    said = list(outcome.warnings)
    _warn(said)
    content = outcome.value()
    check(content)
    if kept_as(file) == read:  # the file has not been rewritten in the meantime
        files.put(key, (content, said))
    return content


def _warn(said: list[str]) -> None:
    """Issue warnings that point at the caller's caller."""
    for text in said:
        warnings.warn(text, ContigaWarning, stacklevel=4)


def answer_kept(file: Path, asked: str, source: str, make: Callable[[], T]) -> T:
    """Return the answer of `make`, or the cached one for the same bytes.

    An answer with warnings is not cached.

    Parameters
    ----------
    file : the CAD file
    asked : what is to be told
    source : file of the module that tells it
    make : function that computes the answer

    Raises
    ------
    ContigaError
        As `make`.
    """
    try:
        files, read = _files(file, Path(source)), kept_as(file)
    except OSError:  # reported when the file is read
        return make()
    key, said = _key(asked, file, ()), list[str]()
    answer: T | None = files.get(key)
    if answer is not None:
        return answer
    try:
        with _collect_warnings(said):
            answer = make()
    finally:
        for text in said:
            warnings.warn(text, ContigaWarning, stacklevel=3)
    if not said and kept_as(file) == read:
        files.put(key, answer)
    return answer


@contextmanager
def _collect_warnings(said: list[str]) -> Iterator[None]:
    """Collect contiga's warnings raised inside in `said`; issue others afterwards."""
    try:
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always", ContigaWarning)
            yield
    finally:
        for item in heard:
            if issubclass(item.category, ContigaWarning):
                said.append(str(item.message))
            else:
                warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)


def _key(asked: str, file: Path, args: tuple[object, ...]) -> str:
    """Return the key of an answer: all it depends on besides the bytes, and the file's name."""
    return repr((asked, str(file), args, _package_of(file.suffix.lower())))


@lru_cache(maxsize=8)
def _package_of(suffix: str) -> str:
    """Return a text that identifies the version of the package that reads a format."""
    said = []
    for name in PACKAGES[suffix]:
        with suppress(ImportError):  # its users report it
            spec = find_spec(name)
            if spec is not None and spec.origin is not None:
                said.append(f"{spec.origin} {Path(spec.origin).stat().st_mtime_ns}")
    return " ".join(said)
