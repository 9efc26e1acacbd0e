"""Limits of time and memory on reading a file.

They grow with the file, so that a large one is not refused and a damaged one ends soon.
Two environment variables set them directly: ``CONTIGA_READ_SECONDS`` and ``CONTIGA_READ_MEMORY``
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
_BASE_SECONDS, _SECONDS_PER_MB = 60.0, 30.0
# NIST's test parts take 0.7 s and 12 MB a MB of STEP, a deck of solids 0.5 s and 20 MB.
_BASE_MEMORY, _MEMORY_PER_BYTE = 4096 * MB, 100
_LINES_PER_CHECK = 4096
_MAX_LINE_LENGTH = 10_000


class Limits(NamedTuple):
    """Limits on reading one file."""

    seconds: float
    """Processor time where the system limits it, else wall-clock time."""
    memory: int
    """Bytes, not counting the interpreter and its libraries."""


def limits_for(path: Path) -> Limits:
    """Return the limits for a file: 60 s + 30 s per MB; 4 GB + 100 × its size, at most all memory.

    The environment variables named by `SECONDS` and `MEMORY` (in MB) replace them. A missing file
    has a size of 0.

    Raises
    ------
    InputError
        An environment variable is not a positive number.
    """
    try:
        size = path.stat().st_size
    except OSError:
        size = 0
    seconds = _positive_variable(SECONDS)
    if seconds is None:
        seconds = _BASE_SECONDS + _SECONDS_PER_MB * size / MB
    memory = _positive_variable(MEMORY)
    if memory is None:
        return Limits(seconds, min(_BASE_MEMORY + _MEMORY_PER_BYTE * size, physical_memory()))
    return Limits(seconds, int(memory * MB))


def physical_memory() -> int:
    """Return the memory of the machine, bytes; practically infinite if the system gives none."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 2**62


def _positive_variable(name: str) -> float | None:
    """Return the number in an environment variable; None if it is not set, or blank.

    Any text but a finite number above zero is an `InputError`.
    """
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
    """Return the error for a file whose reading did not end in time."""
    return _stopped_error(where, f"took more than {seconds:.4g} s", "seconds", SECONDS)


def too_large(where: str, memory: int) -> FileError:
    """Return the error for a file whose reading needs too much memory."""
    return _stopped_error(where, f"needed more than {memory / MB:.4g} MB of memory", "MB", MEMORY)


def _stopped_error(where: str, reason: str, unit: str, variable: str) -> FileError:
    return FileError(
        f"reading {reason} and was stopped",
        where=where,
        remedy=f"The file is likely to be damaged; if it is only large, allow more {unit} with "
        f"the environment variable {variable}",
    )


def watched_lines(
    stream: TextIO, path: Path, max_length: int = _MAX_LINE_LENGTH
) -> Iterator[tuple[int, str]]:
    """Yield number, from 1, and text of the lines of a file within the limits of time and length.

    Line ends are removed. `path` gives the limits, and the name in messages. Time, from the first
    line on, includes that of the caller; it is looked at every `_LINES_PER_CHECK` lines.

    Raises
    ------
    FileError
        A line of more than `max_length` characters, or reading takes too long.
    """
    seconds = limits_for(path).seconds
    end = time.monotonic() + seconds
    number = 0
    while line := stream.readline(max_length + 1):
        number += 1
        if len(line) > max_length:
            raise FileError(
                f"a line is longer than {max_length} characters",
                where=f"{path}, line {number}",
                found=line[:80],
            )
        if number % _LINES_PER_CHECK == 0 and time.monotonic() > end:
            raise too_slow(str(path), seconds)
        yield number, line.rstrip("\r\n")
