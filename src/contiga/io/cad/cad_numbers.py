"""Invalid numbers in STEP and IGES files, some of which make OpenCASCADE loop for ever."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from functools import cached_property
from itertools import chain
from pathlib import Path

from contiga.errors import FileError

_SUSPECTS = [
    re.compile(text) for text in (rb"NAN", rb"INF", rb"1\.#", rb"E(?=\+?\d{3})", rb"D(?=\+?\d{3})")
]
"""Patterns of which each is found at the speed of memory."""
_TOKEN = re.compile(
    rb"[+-]?(?:NAN(?:\(\w*\)?)?|INF|INFINITY|1\.#\w+|[\d.]+[ED]\+?\d+)", re.IGNORECASE
)
"""Text between commas and brackets, without a closing bracket."""
_ASIDE = re.compile(rb"'[^']*'|/\*.*?\*/", re.DOTALL)
"""A string or a comment of a STEP file."""
_ENTITY = re.compile(rb"(?:\s|/\*.*?\*/)*(#\d+)\s*=\s*\(?\s*(\w+)", re.DOTALL)
_BEFORE, _AFTER = re.compile(rb"[(,;\n]"), re.compile(rb"[),;\n]")
_MAX_TOKEN = 64
_IGES_PARAMETERS = re.compile(rb"^.{72}P", re.MULTILINE)
_IGES_DATA, _IGES_ENTRY, _IGES_SECTION = slice(0, 64), slice(64, 72), slice(72, 73)


def check_numbers(path: Path) -> None:
    """Refuse a file in which a number is not finite.

    Raises
    ------
    FileError
        With the line and the entity.
    """
    data = path.read_bytes()
    iges = path.suffix.lower() in (".igs", ".iges")
    upper = data.upper()
    parameters = _IGES_PARAMETERS.search(data) if iges else None
    begin = parameters.start() if parameters else 0
    asides = _Asides(data)
    for suspect in chain(*(pattern.finditer(upper, begin) for pattern in _SUSPECTS)):
        token = _token(data, suspect.start())
        if _TOKEN.fullmatch(token) is None or _is_finite(token):
            continue
        line = data.count(b"\n", 0, suspect.start()) + 1
        at = suspect.start()
        name = _iges_entity(data, at) if iges else _step_entity(data, at, asides)
        if name is not None:
            raise FileError(
                "a number is not finite",
                where=f"{path}, line {line}{name}",
                found=token.decode("latin-1"),
                allowed="finite numbers",
                remedy="Mend the entity, or export the file anew",
            )


def _token(data: bytes, at: int) -> bytes:
    """Return the text around a position, between commas and the like."""
    before = data[max(at - _MAX_TOKEN, 0) : at]
    start = max((match.end() for match in _BEFORE.finditer(before)), default=0)
    end = _AFTER.search(data, at, at + _MAX_TOKEN)
    return (before[start:] + data[at : end.start() if end else at + _MAX_TOKEN]).strip()


class _Asides:
    """The strings and comments of a STEP file, located once and only on request."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    @cached_property
    def _borders(self) -> list[int]:
        """The positions where they begin and end, alternating."""
        return [border for match in _ASIDE.finditer(self._data) for border in match.span()]

    def __contains__(self, at: int) -> bool:
        return bisect_right(self._borders, at) % 2 == 1


def _step_entity(data: bytes, at: int, asides: _Asides) -> str | None:
    """Return number and type of the entity around a position; None within a string or comment."""
    if at in asides:
        return None
    entity = _ENTITY.match(data, data.rfind(b";", 0, at) + 1)
    return f", {b' '.join(entity.groups()).decode('latin-1')}" if entity else ""


def _iges_entity(data: bytes, at: int) -> str | None:
    """Return the directory entry of the parameters around a position; None in other sections."""
    start = data.rfind(b"\n", 0, at) + 1
    line = data[start : start + 80]
    if line[_IGES_SECTION] != b"P" or at - start >= _IGES_DATA.stop:
        return None
    return f", directory entry {line[_IGES_ENTRY].decode('latin-1').strip()}"


def _is_finite(text: bytes) -> bool:
    try:
        return math.isfinite(float(re.sub(rb"[dD]", b"e", text)))
    except ValueError:
        return False
