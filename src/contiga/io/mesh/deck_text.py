"""Common syntax of the decks of several programs: numbers and included files."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from contiga.errors import FileError, MeshError

MAX_WHOLE = 2**62
"""Largest whole number that is accepted."""
# Fortran lets a number do without the E of its exponent (1.5-3) and write D for it.
_EXPONENT = re.compile(r"(?<=[\d.])[dDeE]?([+-]\d+)$|(?<=[\d.])[dD](\d+)$")


def fortran_number(text: str) -> float:
    """Return a number in any of Fortran's notations; raise a ValueError for other text."""
    try:
        return float(text)
    except ValueError:
        return float(_EXPONENT.sub(lambda m: f"e{m[1] or m[2]}", text))


def parse_whole(text: str, where: str) -> int:
    """Return a whole number.

    Raises
    ------
    MeshError
        The text is not a whole number, or its magnitude exceeds `MAX_WHOLE`.
    """
    try:
        value = int(text)
    except ValueError:
        value = MAX_WHOLE + 1
    if abs(value) > MAX_WHOLE:
        raise MeshError("not a whole number", where=where, found=text)
    return value


def parse_real(text: str, where: str) -> float:
    """Return the number in a stripped field, in any notation of Fortran; an empty one is 0.

    Raises
    ------
    MeshError
        The text is not a number, or the number is not finite.
    """
    try:
        value = fortran_number(text or "0")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise MeshError("not a finite number", where=where, found=text)
    return value


def find_included(
    name: str, folders: Sequence[Path], open_files: Sequence[Path], where: str
) -> Path:
    """Return an included file from the first folder that has it.

    `open_files` are the files that include it.

    Raises
    ------
    FileError
        No folder has the file, or the file includes itself.
    """
    file = next((folder / name for folder in folders if (folder / name).is_file()), None)
    if file is None:
        raise FileError("no such included file", where=where, found=name)
    if file.resolve() in open_files:
        raise FileError("a file includes itself", where=where, found=name)
    return file
