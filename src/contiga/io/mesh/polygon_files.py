"""OFF and OBJ: surfaces of polygons of any number of corners, read line by line.

meshio reads only triangles of OFF files, and no polygons, relative numbers or separately counted
texture coordinates of OBJ files.
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
    """Return points and polygons of an OFF or an OBJ file; groups (g, o) of an OBJ file.

    Polygons of more than four corners are split into triangles, with a warning; those of fewer
    than three are left out. Normals, colours and texture coordinates are ignored.

    Raises
    ------
    FileError
        Not such a file, a truncated file, text in place of a number.
    MeshError
        A face names a node that does not exist.
    """
    with path.open(encoding="utf-8", errors="replace") as stream:
        lines = (
            _Line(f"{path}, line {number}", words)
            for number, text in watched_lines(stream, path)
            if (words := text.partition("#")[0].split())
        )
        return _read_off(path, lines) if path.suffix.lower() == ".off" else _read_obj(path, lines)


def _read_off(path: Path, lines: Iterator[_Line]) -> RawMesh:
    """Return an OFF file as a mesh without groups; `lines` are those with words."""
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
    counts = same_line if same_line.words else _next_line(path, lines, "its counts")
    n_points, n_faces = (_count(counts.where, word) for word in (*counts.words[:2], "", "")[:2])
    points = [
        _coordinates(_next_line(path, lines, f"point {k + 1} of {n_points}"))
        for k in range(n_points)
    ]
    faces = []
    for k in range(n_faces):
        line = _next_line(path, lines, f"face {k + 1} of {n_faces}")
        size = _count(line.where, line.words[0])
        corners = line.words[1 : 1 + size]
        if len(corners) < size:
            raise FileError(
                f"a face of {size} corners names fewer", where=line.where, found=line.words
            )
        face = []
        for word in corners:
            row = _count(line.where, word)
            if row >= n_points:
                raise _missing_node(line.where, row, f"0 to {n_points - 1}")
            face.append(row)
        faces.append(face)
    return _mesh(path, points, faces, [])


def _read_obj(path: Path, lines: Iterator[_Line]) -> RawMesh:
    """Return the vertices, faces and groups of an OBJ file; other lines are ignored."""
    points: list[list[float]] = []
    faces: list[list[int]] = []
    places: list[str] = []
    groups: list[tuple[str, int]] = []
    """Names of groups, and the faces at which they begin."""
    for line in lines:
        key, *words = line.words
        if key == "v":
            points.append(_coordinates(line._replace(words=words)))
        elif key == "f":
            faces.append([])
            places.append(line.where)
            for word in words:  # "7", "7/1", "7//3", or "-1" for the last point so far
                try:
                    number = int(word.partition("/")[0])
                except ValueError as error:
                    raise FileError(
                        "a corner of a face must be a whole number", where=line.where, found=word
                    ) from error
                row, count = number - 1 if number > 0 else len(points) + number, len(points)
                if number == 0 or row < 0:
                    allowed = f"1 to {count}, or −{count} to −1 from the last"
                    raise _missing_node(line.where, number, allowed)
                faces[-1].append(row)
        elif key in ("g", "o") and words:
            groups.append((" ".join(words), len(faces)))
    for face, where in zip(faces, places, strict=True):
        if max(face, default=-1) >= len(points):
            raise _missing_node(where, max(face) + 1, f"1 to {len(points)}")
    return _mesh(path, points, faces, groups)


def _mesh(
    path: Path, points: list[list[float]], faces: list[list[int]], groups: list[tuple[str, int]]
) -> RawMesh:
    """Return the mesh of polygons; `groups` has names and the first face of each, in order.

    A group ends where the next one begins; groups of one name add up, and empty ones are left out.
    """
    array = np.array(points, dtype=np.float64).reshape(-1, 3)
    ends = [start for _, start in groups[1:]] + [len(faces)]
    members: dict[str, list[int]] = {}
    for (name, start), end in zip(groups, ends, strict=False):
        members.setdefault(name, []).extend(range(start, end))
    pieces = blocks_of(array, faces, str(path))
    return RawMesh(
        array,
        pieces.blocks,
        tuple(
            Group(None, name, pieces.rows(np.array(rows))) for name, rows in members.items() if rows
        ),
    )


def _next_line(path: Path, lines: Iterator[_Line], item: str) -> _Line:
    line = next(lines, None)
    if line is None:
        raise FileError(f"the file ends before {item}", where=str(path), allowed="a complete file")
    return line


def _coordinates(line: _Line) -> list[float]:
    """Return the first three words of a line as numbers; fewer, or other text, is a `FileError`."""
    try:
        x, y, z = (float(word) for word in line.words[:3])
    except ValueError as error:
        raise FileError(
            "a point needs three numbers", where=line.where, found=line.words
        ) from error
    return [x, y, z]


def _count(where: str, word: str) -> int:
    if not word.isdecimal():
        raise FileError("a count must be a whole number", where=where, found=word)
    return int(word)


def _missing_node(where: str, index: int, allowed: str) -> MeshError:
    return MeshError(
        "a face names a node that is not there", where=where, found=index, allowed=allowed
    )
