"""How much time and memory reading a file may take.

The bounds grow with the file, so that a large one is not refused and a damaged one ends soon.
Two environment variables set them outright: ``CONTIGA_READ_SECONDS`` and ``CONTIGA_READ_MEMORY``
(in MB), for example for a small deck that includes large ones.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, TextIO

from contiga.errors import FileError, InputError

SECONDS, MEMORY = "CONTIGA_READ_SECONDS", "CONTIGA_READ_MEMORY"
MB = 1024**2
_BASE_SECONDS, _SECONDS_A_MB = 60.0, 30.0
# NIST's test parts take 0.7 s and 12 MB a MB of STEP, a deck of solids 0.5 s and 20 MB.
_BASE_MEMORY, _MEMORY_A_BYTE = 4096 * MB, 100
_CHECKED_LINES = 4096
_LONGEST_LINE = 10_000


class Limits(NamedTuple):
    """Bounds on reading one file."""

    seconds: float
    """Processor time, where the system bounds it; else time by the clock."""
    memory: int
    """Bytes, beyond what the interpreter and its libraries take."""


def limits_for(path: Path) -> Limits:
    """Bounds for a file: 60 s and 30 s a MB, 4 GB and 100 bytes a byte, no more than there is.

    Raises
    ------
    InputError
        An environment variable is not a positive number.
    """
    try:
        size = path.stat().st_size
    except OSError:
        size = 0
    seconds = _positive(SECONDS)
    if seconds is None:
        seconds = _BASE_SECONDS + _SECONDS_A_MB * size / MB
    memory = _positive(MEMORY)
    if memory is None:
        return Limits(seconds, min(_BASE_MEMORY + _MEMORY_A_BYTE * size, physical_memory()))
    return Limits(seconds, int(memory * MB))


def physical_memory() -> int:
    """Bytes the machine has; a bound that never binds where the system does not say."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 2**62


def _positive(name: str) -> float | None:
    text = os.environ.get(name, "").strip()
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0.0 and math.isfinite(value)):
        raise InputError(
            "must be a positive number", where=name, found=text, allowed="such as 600, or unset"
        )
    return value


def too_slow(where: str, seconds: float) -> FileError:
    """What is said of a file whose reading did not end in time."""
    return FileError(
        f"reading took more than {seconds:.4g} s and was stopped",
        where=where,
        remedy=(
            "The file is likely to be damaged; if it is only large, allow more seconds with "
            f"the environment variable {SECONDS}"
        ),
    )


def too_large(where: str, memory: int) -> FileError:
    """What is said of a file whose reading asks for too much memory."""
    return FileError(
        f"reading needed more than {memory / MB:.4g} MB of memory and was stopped",
        where=where,
        remedy=(
            "The file is likely to be damaged; if it is only large, allow more MB with "
            f"the environment variable {MEMORY}"
        ),
    )


def watched_lines(
    stream: TextIO, path: Path, longest: int = _LONGEST_LINE
) -> Iterator[tuple[int, str]]:
    """Numbered lines of a text, one at a time and none of them endless.

    Raises
    ------
    FileError
        A line of more than `longest` characters, or reading takes too long.
    """
    seconds = limits_for(path).seconds
    end = time.monotonic() + seconds
    number = 0
    while line := stream.readline(longest + 1):
        number += 1
        if len(line) > longest:
            raise FileError(
                f"a line is longer than {longest} characters",
                where=f"{path}, line {number}",
                found=line[:80],
            )
        if number % _CHECKED_LINES == 0 and time.monotonic() > end:
            raise too_slow(str(path), seconds)
        yield number, line.rstrip("\r\n")
