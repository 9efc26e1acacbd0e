"""What was read of a file in a process of its own, or the error that it came to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contiga.errors import FileError
from contiga.io.child_process import Outcome
from contiga.io.limits import limits_for, too_large

_SAID = 300
"""Characters of what a reader says that are passed on."""


def content_of(outcome: Outcome, path: Path) -> Any:
    """What was read; raises as `read_apart`."""
    if outcome.kind == "value":
        return outcome.content
    if outcome.kind == "error":
        raise outcome.content
    if outcome.kind == "memory":
        raise too_large(str(path), limits_for(path).memory)
    said, trace = outcome.content
    raise _failed(path, said) from RuntimeError(trace)


def _failed(path: Path, said: str) -> FileError:
    return FileError(
        f"cannot be read: {' '.join(said.split())[:_SAID]}",
        where=str(path),
        allowed=f"an undamaged {path.suffix} file",
    )
