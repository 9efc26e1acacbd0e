"""OFF and OBJ: surfaces of polygons of any number of corners, read line by line.

meshio reads triangles alone of the one, and of the other no polygons, no relative numbers and no
texture coordinates of another count than points.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.errors import FileError, MeshError
from contiga.io.limits import watched_lines
from contiga.io.mesh.polygons import blocks_of
from contiga.io.mesh.raw import Group, RawMesh

SUFFIXES = (".off", ".obj")
_HEADS = ("OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF")
"""Colours, normals and texture coordinates follow the three coordinates; 4OFF and nOFF differ."""


class _Line(NamedTuple):
    where: str
    words: list[str]


def read_polygons(path: Path) -> RawMesh:
    """Return points and polygons of an OFF or an OBJ file; groups of an OBJ file.

    Polygons of more than four corners are split into triangles, with a warning.

    Raises
    ------
    FileError
        Not such a file, cut short, a number that is none.
    MeshError
        A face names a node that is not there.
    """
    with path.open(encoding="utf-8", errors="replace") as stream:
        lines = _lines(path, watched_lines(stream, path))
        return _off(path, lines) if path.suffix.lower() == ".off" else _obj(path, lines)


def _lines(path: Path, numbered: Iterator[tuple[int, str]]) -> Iterator[_Line]:
    """Yield the lines that are not empty, without comments."""
    for number, text in numbered:
        words = text.partition("#")[0].split()
        if words:
            yield _Line(f"{path}, line {number}", words)


def _off(path: Path, lines: Iterator[_Line]) -> RawMesh:
    head = next(lines, _Line(str(path), []))
    words = head.words
    if not words or words[0] not in _HEADS or "BINARY" in words:
        raise FileError(
            "not an OFF file of text",
            where=str(path),
            found=" ".join(words)[:24],
            allowed=f"a file that begins with {', '.join(_HEADS)}",
        )
    same_line = head._replace(words=words[1:])
    counts = same_line if same_line.words else _next(path, lines, "its counts")
    two = (*counts.words[:2], "", "")[:2]
    n_points, n_faces = (_whole(counts.where, word) for word in two)
    points = [_numbers(_next(path, lines, f"point {k + 1} of {n_points}")) for k in range(n_points)]
    faces = []
    for k in range(n_faces):
        line = _next(path, lines, f"face {k + 1} of {n_faces}")
        size = _whole(line.where, line.words[0])
        corners = line.words[1 : 1 + size]
        if len(corners) < size:
            raise _bad(line.where, f"a face of {size} corners names fewer", line.words)
        faces.append([_corner(line.where, word, n_points) for word in corners])
    return _mesh(path, points, faces, [])


def _obj(path: Path, lines: Iterator[_Line]) -> RawMesh:
    points: list[list[float]] = []
    faces: list[list[int]] = []
    places: list[str] = []
    names: list[tuple[str, int]] = []
    """Names of groups, and the faces at which they begin."""
    for line in lines:
        key, *words = line.words
        if key == "v":
            points.append(_numbers(line._replace(words=words)))
        elif key == "f":
            faces.append([_obj_corner(line.where, word, len(points)) for word in words])
            places.append(line.where)
        elif key in ("g", "o") and words:
            names.append((" ".join(words), len(faces)))
    for face, where in zip(faces, places, strict=True):
        if max(face, default=-1) >= len(points):
            raise _not_there(where, max(face) + 1, f"1 to {len(points)}")
    return _mesh(path, points, faces, names)


def _mesh(
    path: Path, points: list[list[float]], faces: list[list[int]], names: list[tuple[str, int]]
) -> RawMesh:
    array = np.array(points, dtype=np.float64).reshape(-1, 3)
    ends = [start for _, start in names[1:]] + [len(faces)]
    members: dict[str, list[int]] = {}
    for (name, start), end in zip(names, ends, strict=False):
        members.setdefault(name, []).extend(range(start, end))
    made = blocks_of(array, faces, str(path))
    groups = tuple(
        Group(None, name, made.rows(np.array(rows))) for name, rows in members.items() if rows
    )
    return RawMesh(array, made.blocks, groups)


def _next(path: Path, lines: Iterator[_Line], what: str) -> _Line:
    line = next(lines, None)
    if line is None:
        raise FileError(f"the file ends before {what}", where=str(path), allowed="a complete file")
    return line


def _numbers(line: _Line) -> list[float]:
    try:
        x, y, z = (float(word) for word in line.words[:3])
    except ValueError as error:
        raise _bad(line.where, "a point needs three numbers", line.words) from error
    return [x, y, z]


def _whole(where: str, word: str) -> int:
    if not word.isdecimal():
        raise _bad(where, "a count must be a whole number", word)
    return int(word)


def _corner(where: str, word: str, count: int) -> int:
    row = _whole(where, word)
    if row >= count:
        raise _not_there(where, row, f"0 to {count - 1}")
    return row


def _obj_corner(where: str, word: str, count: int) -> int:
    """Return the row of a point from "7", "7/1", "7//3", or "-1" for the last point so far."""
    text = word.partition("/")[0]
    try:
        value = int(text)
    except ValueError as error:
        raise _bad(where, "a corner of a face must be a whole number", word) from error
    row = value - 1 if value > 0 else count + value
    if value == 0 or row < 0:
        raise _not_there(where, value, f"1 to {count}, or −{count} to −1 from the last")
    return row


def _bad(where: str, what: str, given: object) -> FileError:
    return FileError(what, where=where, found=given)


def _not_there(where: str, index: int, allowed: str) -> MeshError:
    what = "a face names a node that is not there"
    return MeshError(what, where=where, found=index, allowed=allowed)
