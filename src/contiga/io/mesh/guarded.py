"""Open files that refuse to be read on and on after their end.

Some readers ask for line after line until they find what they look for, which a file cut short
never brings.
"""

from __future__ import annotations

import io

_READS_AFTER_END = 1000


class GuardedFile(io.BufferedReader):
    """A binary file that raises EOFError when it is read on and on after its end."""

    _empty = 0

    def readline(self, size: int | None = -1, /) -> bytes:
        line = super().readline(size)
        self._empty = _count_end(self._empty, line)
        return line

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self._empty = _count_end(self._empty, data)
        return data


class GuardedText(io.TextIOWrapper):
    """A text file that raises EOFError when it is read on and on after its end."""

    _empty = 0

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        line = super().readline(size)
        self._empty = _count_end(self._empty, line)
        return line


def _count_end(count: int, data: bytes | str) -> int:
    """Return one more if nothing was read, else 0."""
    if data:
        return 0
    if count >= _READS_AFTER_END:
        raise EOFError("the file ends too early")
    return count + 1
