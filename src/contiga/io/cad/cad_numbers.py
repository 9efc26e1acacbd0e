"""Invalid numbers in STEP and IGES files, some of which put OpenCASCADE into an endless loop."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from contextlib import suppress
from itertools import chain
from pathlib import Path

from contiga.errors import FileError
from contiga.io.cad.formats import IGES_SUFFIXES

_SUSPECTS = [
    re.compile(text) for text in (rb"NAN", rb"INF", rb"1\.#", rb"E(?=\+?\d{3})", rb"D(?=\+?\d{3})")
]
"""Patterns without alternatives, which `re` finds at the speed of memory."""
_TOKEN = re.compile(
    rb"[+-]?(?:NAN(?:\(\w*\)?)?|INF|INFINITY|1\.#\w+|[\d.]+[ED]\+?\d+)", re.IGNORECASE
)
"""Text between commas and brackets, without a closing bracket."""
_ASIDE = re.compile(rb"'[^']*'|/\*.*?\*/", re.DOTALL)
"""A string or a comment of a STEP file."""
_ENTITY = re.compile(rb"(?:\s|/\*.*?\*/)*(#\d+)\s*=\s*\(?\s*(\w+)", re.DOTALL)
_BEFORE, _AFTER = re.compile(rb"[(,;\n]"), re.compile(rb"[),;\n]")
_MAX_TOKEN = 64
"""Largest number of characters on either side of a position that belong to its number."""
_IGES_PARAMETERS = re.compile(rb"^.{72}P", re.MULTILINE)
_IGES_DATA, _IGES_ENTRY, _IGES_SECTION = slice(0, 64), slice(64, 72), slice(72, 73)


def check_numbers(path: Path) -> None:
    """Refuse a STEP or IGES file in which a number is not finite.

    That is NaN, an infinity, also as 1.#INF, or an exponent beyond float64. Strings, comments, and
    in IGES all but the parameter section are not examined.

    Raises
    ------
    FileError
        There is such a number; the message has the line and the entity of the first one found.
    """
    data = path.read_bytes()
    is_iges = path.suffix.lower() in IGES_SUFFIXES
    upper = data.upper()
    parameters = _IGES_PARAMETERS.search(data) if is_iges else None
    begin = parameters.start() if parameters else 0
    aside_borders: list[int] | None = None
    """Offsets at which strings and comments begin and end, alternating; found when needed."""
    for suspect in chain(*(pattern.finditer(upper, begin) for pattern in _SUSPECTS)):
        position = suspect.start()
        before = data[max(position - _MAX_TOKEN, 0) : position]
        begin_of_token = max((match.end() for match in _BEFORE.finditer(before)), default=0)
        end = _AFTER.search(data, position, position + _MAX_TOKEN)
        after = data[position : end.start() if end else position + _MAX_TOKEN]
        token = (before[begin_of_token:] + after).strip()
        if _TOKEN.fullmatch(token) is None:
            continue
        with suppress(ValueError):  # 1.#INF and the like
            if math.isfinite(float(re.sub(rb"[dD]", b"e", token))):
                continue
        if is_iges:
            start = data.rfind(b"\n", 0, position) + 1
            line = data[start : start + 80]
            if line[_IGES_SECTION] != b"P" or position - start >= _IGES_DATA.stop:
                continue
            name = f", directory entry {line[_IGES_ENTRY].decode('latin-1').strip()}"
        else:
            if aside_borders is None:
                aside_borders = [
                    border for match in _ASIDE.finditer(data) for border in match.span()
                ]
            if bisect_right(aside_borders, position) % 2 == 1:
                continue
            entity = _ENTITY.match(data, data.rfind(b";", 0, position) + 1)
            name = f", {b' '.join(entity.groups()).decode('latin-1')}" if entity else ""
        line_number = data.count(b"\n", 0, position) + 1
        raise FileError(
            "a number is not finite",
            where=f"{path}, line {line_number}{name}",
            found=token.decode("latin-1"),
            allowed="finite numbers",
            remedy="Mend the entity, or export the file anew",
        )
