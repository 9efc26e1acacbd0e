"""Files that are written whole or not at all, and folders of one process alone."""

from __future__ import annotations

import glob
import json
import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contiga.errors import FileError, OutputError
from contiga.io.out.full_disk import full_disk, full_disk_errors

_N_TOKEN_BYTES = 4
"""Number of random bytes in the name of a temporary file."""


@contextmanager
def atomic_write(path: str | Path, before: Path | None = None) -> Iterator[Path]:
    """Provide a temporary path beside `path`; rename it on success, remove it on an error.

    An older file goes, or stays under the name `before`, in place of a still older one.

    The temporary file exists, is empty, and has the same suffix, for writers that look at it. It is
    in the same folder, so that the rename is one step of the file system. Its content reaches the
    disk before the name changes.

    Raises
    ------
    OutputError
        The folder is missing or cannot be written to, `path` is a folder, or the disk is full.

    Examples
    --------
    >>> with atomic_write("history.csv") as temporary:
    ...     n_written = temporary.write_text("time"), Path("history.csv").exists()
    >>> n_written, Path("history.csv").read_text()
    ((4, False), 'time')
    """
    path = Path(path)
    if path.is_dir():
        raise OutputError("a folder has the name of the file to be written", where=str(path))
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(_N_TOKEN_BYTES)}{path.suffix}")
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise full_disk(error, path) or OutputError(
            f"the file cannot be written: {error.strerror}",
            where=str(path),
            allowed="a folder that exists and may be written to",
        ) from error
    try:
        with full_disk_errors(path):
            yield temporary
            with temporary.open("rb") as file:
                os.fsync(file.fileno())
            if before is not None and path.exists():
                path.replace(before)
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def check_suffix(path: str | Path, suffix: str) -> None:
    """Refuse an output file whose name does not end in `suffix` in any case, such as ".zip".

    Raises
    ------
    FileError
        It has another suffix, or none.
    """
    if Path(path).suffix.lower() != suffix:
        raise FileError(
            "the file has another suffix than its format",
            where=str(path),
            found=Path(path).suffix or "no suffix",
            allowed=suffix,
        )


def clear_temporaries(folder: Path, names: Iterable[str]) -> None:
    """Remove the temporary files of these names that a killed process left behind.

    Nobody else may be writing them.
    """
    for path in map(Path, names):
        token = "[0-9a-f]" * (2 * _N_TOKEN_BYTES)
        pattern = f".{glob.escape(path.stem)}.{token}{glob.escape(path.suffix)}"
        for temporary in folder.glob(pattern):
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; an older one is replaced."""
    with atomic_write(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write an indented JSON file in UTF-8, whole or not at all; an older one is replaced."""
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False) + "\n")


def open_folder(folder: Path, ours: Iterable[str], kind: str) -> bool:
    """Make `folder`, or check that it is writable and empty, or holds a file of the same kind.

    Parameters
    ----------
    folder : the folder, made if it does not exist
    ours : names of files that mark an earlier folder of the same kind
    kind : kind of the folder, in words

    Returns
    -------
    bool
        Whether the folder is new.

    Raises
    ------
    OutputError
        It is a file, cannot be made or written, or holds files but none of `ours`.
    """
    where = str(folder)
    if folder.exists() and not folder.is_dir():
        raise OutputError("the output folder is a file", where=where, allowed="a folder")
    if folder.is_dir():
        names = {path.name for path in folder.iterdir()}
        if names and not names & set(ours):
            raise OutputError(
                f"the output folder holds files that are not of a {kind}",
                where=where,
                found=sorted(names)[0],
                allowed=f"a new or empty folder, or that of an earlier {kind}",
            )
    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise full_disk(error, folder) or OutputError(
            "the output folder cannot be written",
            where=str(folder),
            found=error.strerror,
            allowed="a folder you may write to",
        ) from error
    return is_new
