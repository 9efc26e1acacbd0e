"""Open files that refuse to be read again and again after their end.

Some readers ask for line after line until they find a keyword that a truncated file does not have.
"""

from __future__ import annotations

import io

_MAX_READS_AFTER_END = 1000


class GuardedFile(io.BufferedReader):
    """A binary file that raises EOFError when it is read again and again after its end."""

    _n_empty = 0

    def readline(self, size: int | None = -1, /) -> bytes:
        line = super().readline(size)
        self._n_empty = _count_empty_reads(self._n_empty, line)
        return line

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self._n_empty = _count_empty_reads(self._n_empty, data)
        return data


class GuardedText(io.TextIOWrapper):
    """A text file that raises EOFError when it is read again and again after its end."""

    _n_empty = 0

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        line = super().readline(size)
        self._n_empty = _count_empty_reads(self._n_empty, line)
        return line


def _count_empty_reads(count: int, data: bytes | str) -> int:
    """Return the count of reads without data, with this one; 0 if it has data."""
    if data:
        return 0
    if count >= _MAX_READS_AFTER_END:
        raise EOFError("the file ends too early")
    return count + 1
