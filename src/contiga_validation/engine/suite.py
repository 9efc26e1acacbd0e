"""Common parts of both suites: selection, progress, and the folder of results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar

from contiga.errors import FileError, InputError
from contiga.io.out import files

Progress = Callable[[int, int, str], None]
"""Called with the number done, the total, and the title of the next one."""


class Entry(Protocol):
    """An experiment or a case."""

    @property
    def key(self) -> str:
        """Unique name."""


EntryT = TypeVar("EntryT", bound=Entry)


def selected(
    entries: Sequence[EntryT],
    only: Sequence[str] | None,
    separators: Sequence[str],
    kind: str,
    remedy: str,
) -> tuple[EntryT, ...]:
    """Return the entries that `only` names, in their own order; all of them for None.

    Parameters
    ----------
    entries : all
    only : keys, or starts of keys up to a separator
    separators : characters that may end the start of a key
    kind, remedy : for the message

    Raises
    ------
    InputError
        A word names no entry, or there are no words.
    """
    if only is None:
        return tuple(entries)

    def matches(key: str, word: str) -> bool:
        starts = tuple(word + separator for separator in separators)
        return bool(word) and (key == word or key.startswith(starts))

    words = [word.strip() for word in only]
    for word in words or [""]:
        if not any(matches(entry.key, word) for entry in entries):
            raise InputError(
                f"no {kind} has this name",
                where="only",
                found=word,
                allowed=", ".join(entry.key for entry in entries),
                remedy=remedy,
            )
    return tuple(entry for entry in entries if any(matches(entry.key, word) for word in words))


def with_progress(
    entries: Sequence[EntryT], progress: Progress | None, title_of: Callable[[EntryT], str]
) -> Iterator[EntryT]:
    """Yield the entries, and report each to `progress` before, and the end after the last."""
    for n_done, entry in enumerate(entries):
        if progress is not None:
            progress(n_done, len(entries), title_of(entry))
        yield entry
    if progress is not None:
        progress(len(entries), len(entries), "done")


@contextmanager
def results_folder(out: str | Path, names: Sequence[str], kind: str) -> Iterator[Path]:
    """Open the folder of results; remove a new one if an error in the block leaves it empty.

    `names` are files of an earlier run, by which its folder is known. An OutputError is raised if
    the folder cannot be written, or holds other files.
    """
    folder = Path(out)
    is_new = files.open_folder(folder, names, kind)
    try:
        yield folder
    except BaseException:
        if is_new and not any(folder.iterdir()):
            folder.rmdir()
        raise


@contextmanager
def reading(path: Path, kind: str) -> Iterator[dict[str, Any]]:
    """Yield the content of a file of results; a missing key in the block is an error of the file.

    Raises
    ------
    FileError
        The file is missing, or is not `kind`.
    """
    try:
        yield json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError(f"not {kind}", where=str(path)) from error
