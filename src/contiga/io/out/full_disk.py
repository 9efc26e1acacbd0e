"""Messages about a full disk, whether Python or HDF5 reports it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from errno import EDQUOT, EFBIG, ENOSPC
from pathlib import Path

from contiga.errors import OutputError

_MESSAGES = {
    ENOSPC: "the disk is full",
    EDQUOT: "the disk quota is used up",
    EFBIG: "the file is larger than may be",
}
SLACK = 1_000_000
"""Space that stays free, bytes: HDF5 writes more than its data, and other files are written too."""
_HDF5_ERRNO = re.compile(r"errno = (\d+)")


def full_disk(error: BaseException, path: str | Path) -> OutputError | None:
    """Return an `OutputError` about `path` for an error due to a full disk; None for any other.

    A used-up quota and a file that is too large count too. The number of the error is the one in
    a message of HDF5, or else `errno`.
    """
    match = _HDF5_ERRNO.search(str(error))
    number = int(match[1]) if match else getattr(error, "errno", None)
    if number not in _MESSAGES:
        return None
    return OutputError(_MESSAGES[number], where=str(path), remedy="Make room on it")


def check_room(path: str | Path, needed: int) -> None:
    """Refuse to begin without enough space: HDF5 loses a file that it cannot complete.

    Parameters
    ----------
    path : file that is to be written or to grow, in an existing folder
    needed : upper bound of the growth, bytes

    Raises
    ------
    OutputError
        The disk has less free space than `needed` and `SLACK` together.
    """
    free = shutil.disk_usage(Path(path).parent).free
    if free < needed + SLACK:
        raise OutputError(
            _MESSAGES[ENOSPC],
            where=str(path),
            found=f"{free / 1e6:.3g} MB left",
            allowed=f"about {(needed + SLACK) / 1e6:.3g} MB for the next step",
            remedy="Make room on it",
        )


@contextmanager
def full_disk_errors(path: str | Path) -> Iterator[None]:
    """Turn errors of a full disk into an `OutputError` about `path` within this block.

    Raises
    ------
    OutputError
        The disk or the quota is full, or the file is too large.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        full = full_disk(error, path)
        if full is None:
            raise
        raise full from error
