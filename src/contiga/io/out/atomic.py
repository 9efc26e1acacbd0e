"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from contiga.errors import OutputError


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path`; renamed to it when the block ends well, removed when not.

    The temporary file has the same suffix, for writers that look at it, and is in the same
    folder, so that the rename is one step of the file system. Its content reaches the disk
    before the name changes.

    Raises
    ------
    OutputError
        The folder is missing or cannot be written to, or `path` is a folder.

    Examples
    --------
    >>> with atomic_write("history.csv") as temporary:
    ...     written = temporary.write_text("time"), Path("history.csv").exists()
    >>> written, Path("history.csv").read_text()
    ((4, False), 'time')
    """
    path = Path(path)
    if path.is_dir():
        raise OutputError("a folder has the name of the file to be written", where=str(path))
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise OutputError(
            f"the file cannot be written: {error.strerror}",
            where=str(path),
            allowed="a folder that exists and may be written to",
        ) from error
    try:
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
