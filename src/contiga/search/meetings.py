"""Whether the pieces of a body are apart, or touch, cross or lie within one another.

A piece is what hangs together by shared edges. A body of several closed pieces is sound where each
place of its surface has matter behind it and none before: the turns of all pieces about a point
just before it (1 within one that faces outward, −1 within a cavity, which faces inward) add up to
0. Places are drawn from where boxes of pieces overlap; where none of them tells, those nearest to
the other piece are led to where both are nearest, and looked at there once more. What is found is
exact to the tolerance; pieces may overlap unseen by less than places are apart.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from contiga.geometry.faces import Faces
from contiga.geometry.piece import piece_of
from contiga.records import FloatArray, IntArray
from contiga.search.project import project
from contiga.statuses import Feature

MOST = 4
"""Meetings after which no more are looked for."""
FINE = (2.0, 6.0)
"""Sides of the overlap of two boxes in sides of the triangles whose middles are looked at: first
few, then more."""
TRIANGLES = 2000
"""Of a piece, looked at in one overlap at most."""
CHORD = 1e-2
"""How far triangles may be from a piece, in its size: the places are on the piece itself."""
INNER = np.array([0.36, 0.33, 0.31])
"""Shares of the corners in the place of a triangle: no place of symmetry."""
NEAREST, HOPS = 6, 24
"""Places that are led to where two pieces are nearest, in so many steps."""
ASIDE = 0.02
"""How far beside such a place it is looked, in sides of a triangle."""


class Meeting(NamedTuple):
    """A place where pieces of a body touch or overlap."""

    patches: tuple[int, int]
    """A face of each."""
    point: tuple[float, float, float]
    """Body frame."""
    overlap: bool
    """Whether one reaches into the other; else they have a part of their faces in common."""

    def __str__(self) -> str:
        how = "overlap" if self.overlap else "coincide"
        x, y, z = self.point
        return f"patches {self.patches[0]} and {self.patches[1]} {how} at ({x:.6g}, {y:.6g}, {z:.6g})"


class _Piece(NamedTuple):
    faces: Faces
    patches: IntArray
    """Its patches in the body."""
    box: FloatArray
    triangles: FloatArray
    """(n, 3, 3) near it."""
    turn: int
    """1 if it faces outward, −1 if it bounds a cavity."""


def meetings_of(body: Faces, piece: IntArray, tolerance: float) -> tuple[Meeting, ...]:
    """Where closed pieces of `body` meet, the first `MOST` places.

    Parameters
    ----------
    piece : (patches,) number of the piece each is of
    tolerance : nearer than this they touch, length
    """
    groups = [np.flatnonzero(piece == k) for k in np.unique(piece)]
    whole = [piece_of(body, group.tolist()) for group in groups]
    boxes = [faces.bounds() for faces in whole]
    near = [
        (i, j)
        for i, j in combinations(range(len(whole)), 2)
        if _overlap(boxes[i], boxes[j], tolerance) is not None
    ]
    made = {
        k: _made(whole[k], groups[k], boxes[k]) for k in sorted({k for pair in near for k in pair})
    }
    found: list[Meeting] = []
    for i, j in near:
        meeting = _meeting(list(made.values()), made[i], made[j], tolerance)
        if meeting is not None:
            found.append(meeting)
        if len(found) == MOST:
            break
    return tuple(found)


def _overlap(a: FloatArray, b: FloatArray, tolerance: float) -> FloatArray | None:
    """(2, 3) what two boxes have in common, `tolerance` wider; None if nothing."""
    box = np.array([np.maximum(a[0], b[0]) - tolerance, np.minimum(a[1], b[1]) + tolerance])
    return box if (box[0] <= box[1]).all() else None


def _made(faces: Faces, patches: IntArray, box: FloatArray) -> _Piece:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of triangles that are coarse
        mesh = faces.tessellate(CHORD * faces.size)
    triangles = mesh.vertices[mesh.triangles]
    a, b, c = np.moveaxis(triangles - box.mean(axis=0), 1, 0)
    turn = 1 if float((a * np.cross(b, c)).sum()) > 0.0 else -1
    return _Piece(faces, patches, box, triangles, turn)


def _meeting(
    pieces: Sequence[_Piece], first: _Piece, second: _Piece, tolerance: float
) -> Meeting | None:
    """A place where two pieces meet."""
    overlap = _overlap(first.box, second.box, tolerance)
    assert overlap is not None
    for fine in FINE:
        side = float(np.linalg.norm(overlap[1] - overlap[0])) / fine
        for own, other in ((first, second), (second, first)):
            places = _places(own, overlap, side)
            meeting = _told(pieces, own, other, places, tolerance)
            if meeting is None and fine == FINE[-1]:
                beside = _beside(own, other, places, ASIDE * side)
                meeting = _told(pieces, own, other, beside, tolerance)
            if meeting is not None:
                return meeting
    return None


def _places(own: _Piece, box: FloatArray, side: float) -> FloatArray:
    """(n, 3) places of triangles no longer than `side` that those of a piece are cut into, where
    the piece may be within a box."""
    done = []
    rest, off = own.triangles, CHORD * own.faces.size
    while len(rest):
        meets = (rest.min(axis=1) <= box[1] + off) & (rest.max(axis=1) >= box[0] - off)
        rest = rest[meets.all(axis=1)]
        long = np.ptp(rest, axis=1).max(axis=1) > side
        done.append(rest[~long])
        rest = rest[long]
        if sum(map(len, done)) + 4 * len(rest) > TRIANGLES:
            done.append(rest)
            break
        middles = 0.5 * (rest + np.roll(rest, -1, axis=1))
        corners = [np.stack([rest[:, k], middles[:, k], middles[:, k - 1]], 1) for k in range(3)]
        rest = np.concatenate([middles, *corners])
    return np.concatenate([INNER @ part for part in done]) if done else np.zeros((0, 3))


def _told(
    pieces: Sequence[_Piece], own: _Piece, other: _Piece, places: FloatArray, tolerance: float
) -> Meeting | None:
    """Whether one of some places near a piece shows that it meets another, and which."""
    if len(places) == 0:
        return None
    feet = project(own.faces, places)
    turns = np.full(len(places), min(own.turn, 0))
    off = np.full(len(places), np.inf)
    beside = np.zeros(len(places), bool)
    patch = np.zeros(len(places), np.int64)
    for piece in pieces:
        low, high = piece.box[0] - tolerance, piece.box[1] + tolerance
        within = ((feet.point >= low) & (feet.point <= high)).all(axis=1)
        rows = np.flatnonzero(within | (piece is other))
        if piece is own or len(rows) == 0:
            continue
        there = project(piece.faces, feet.point[rows])
        turns[rows] += piece.turn * (piece.turn * there.gap < 0.0)
        beside[rows] |= np.abs(there.gap) <= tolerance
        if piece is other:
            off[rows], patch[rows] = np.abs(there.gap), other.patches[there.patch]
    face = feet.feature == Feature.FACE  # pieces that have but an edge in common are apart
    touch, reach_in = face & (off <= tolerance), face & ~beside & (turns != 0)
    for rows, overlap in ((touch, False), (reach_in, True)):
        if rows.any():
            k = int(np.flatnonzero(rows)[np.argmax(off[rows])])
            x, y, z = feet.point[k].tolist()
            return Meeting((int(own.patches[feet.patch[k]]), int(patch[k])), (x, y, z), overlap)
    return None


def _beside(own: _Piece, other: _Piece, places: FloatArray, aside: float) -> FloatArray:
    """(n, 3) places about those where two pieces are nearest to each other."""
    if len(places) == 0:
        return places
    off = np.abs(project(other.faces, places).gap)
    points = places[np.argsort(off, kind="stable")[:NEAREST]]
    for _ in range(HOPS):
        points = project(own.faces, project(other.faces, points).point).point
    way = np.random.default_rng(0).normal(size=(len(points), 8, 3))
    way *= aside / np.linalg.norm(way, axis=2, keepdims=True)
    return np.asarray((points[:, None] + way).reshape(-1, 3))
