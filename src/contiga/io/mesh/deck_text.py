"""Common parts of the decks of several programs: numbers, included files, axes from points."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contiga.errors import FileError, MeshError
from contiga.records import FloatArray

Position = tuple[float, float, float]

MAX_WHOLE = 2**62
"""Largest whole number that is accepted."""
# Fortran lets a number do without the E of its exponent (1.5-3) and write D for it.
_EXPONENT = re.compile(r"(?<=[\d.])[dDeE]?([+-]\d+)$|(?<=[\d.])[dD](\d+)$")


def fortran_number(text: str) -> float:
    """Return a number in any of Fortran's notations (1.5, 1.5D3, 1.5-3); "nan" and "inf" are read.

    Other text raises a ValueError.
    """
    try:
        return float(text)
    except ValueError:
        return float(_EXPONENT.sub(lambda m: f"e{m[1] or m[2]}", text))


def parse_whole(text: str, where: str) -> int:
    """Return the whole number that Python's `int` reads in a text; a text such as "3.0" is refused.

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
    """Return the path of an included file in the first folder that has it.

    `open_files` are the resolved paths of the files being read that include it.

    Raises
    ------
    FileError
        No folder has the file, or it is one of `open_files`.
    """
    file = next((folder / name for folder in folders if (folder / name).is_file()), None)
    if file is None:
        raise FileError("no such included file", where=where, found=name)
    if file.resolve() in open_files:
        raise FileError("a file includes itself", where=where, found=name)
    return file


def orthonormal_axes(
    first: FloatArray, in_plane: FloatArray, where: str
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return unit vectors (3,) along `first`, at right angles to it toward `in_plane`, and normal.

    The normal is that of first × in_plane.

    Raises
    ------
    MeshError
        The sine of the angle between the two vectors is at most 1e-12, or one is zero.
    """
    normal = np.cross(first, in_plane)
    if not np.linalg.norm(normal) > 1e-12 * np.linalg.norm(first) * np.linalg.norm(in_plane):
        raise MeshError("the three points of a system lie on a line", where=where)
    along, normal = first / np.linalg.norm(first), normal / np.linalg.norm(normal)
    return along, np.cross(normal, along), normal
