"""What both suites do alike: choose what is run, tell how far they are, fill and read a folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar

from contiga.errors import FileError, InputError
from contiga.io.out import files

Progress = Callable[[int, int, str], None]
"""Called with how many are done, how many there are, and which comes next."""


class Entry(Protocol):
    """An experiment or a case."""

    @property
    def key(self) -> str:
        """Unique."""


One = TypeVar("One", bound=Entry)


def chosen(
    every: Sequence[One], only: Sequence[str] | None, ends: Sequence[str], what: str, remedy: str
) -> tuple[One, ...]:
    """Those of `every` that `only` names, all of them for None.

    Parameters
    ----------
    only : keys, or starts of keys up to one of `ends`
    what : there is none of, and `remedy`, for the message

    Raises
    ------
    InputError
        An entry that names none, or no entries.
    """
    if only is None:
        return tuple(every)

    def is_meant(key: str, word: str) -> bool:
        return bool(word) and (key == word or key.startswith(tuple(word + end for end in ends)))

    words = [word.strip() for word in only]
    for word in words or [""]:
        if not any(is_meant(one.key, word) for one in every):
            raise InputError(
                f"no {what} has this name",
                where="only",
                found=word,
                allowed=", ".join(one.key for one in every),
                remedy=remedy,
            )
    return tuple(one for one in every if any(is_meant(one.key, word) for word in words))


def in_turn(
    entries: Sequence[One], progress: Progress | None, title_of: Callable[[One], str]
) -> Iterator[One]:
    """One after the other, each told before it comes."""
    for done, one in enumerate(entries):
        if progress is not None:
            progress(done, len(entries), title_of(one))
        yield one
    if progress is not None:
        progress(len(entries), len(entries), "done")


@contextmanager
def opened(out: str | Path, names: Sequence[str], kind: str) -> Iterator[Path]:
    """The folder of results, made where there is none, and removed where nothing comes of it."""
    folder = Path(out)
    made = files.open_folder(folder, names, kind)
    try:
        yield folder
    except BaseException:
        if made and not any(folder.iterdir()):
            folder.rmdir()
        raise


@contextmanager
def told_in(path: Path, what: str) -> Iterator[dict[str, Any]]:
    """What a suite has written, as long as all that is looked for is in it.

    Raises
    ------
    FileError
        It is not there, or is not `what`.
    """
    try:
        yield json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError(f"not {what}", where=str(path)) from error
