"""Whether the pieces of a body are apart, or touch, cross or lie within one another.

A piece is what hangs together by shared edges. A body of several closed pieces is sound where each
place of its surface has matter behind it and none before: the turns of all pieces about a point
just before it (1 within one that faces outward, −1 within a cavity, which faces inward) add up to
0. Places are the middles of triangles, leaves laid flat, of pieces whose leaves come near each
other, or of which the box of one lies in another's. What is farther from the
other piece than its triangle reaches is done with; of the rest the nearest are cut up. Where none
tells, the nearest places are led to where both pieces are nearest, and it is looked about there.
What is found is exact to the tolerance; a small overlap far from those places may be overlooked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.faces import Faces
from contiga.geometry.piece import piece_of
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.search.borders.coincident import coincident_at
from contiga.search.borders.crossings import crossing_of, near_leaves
from contiga.search.tables import tables_of
from contiga.search.track.project import project
from contiga.statuses import Feature

MAX_MEETINGS = 4
"""Meetings after which no more are looked for."""
KEPT, LEVELS = 12, 5
"""Triangles that are cut up at each level, those that are nearest to the other piece; levels."""
INNER = np.array([0.36, 0.33, 0.31])
"""Shares of the corners in the place of a triangle: no place of symmetry."""
NEAREST, HOPS = 4, 12
"""Places that are led to where two pieces are nearest, in so many steps."""
N_AROUND = 6
"""Places around one where pieces meet that are looked at before they are said to coincide."""
ASIDE = 3e-3
"""How far beside such a place it is looked, in the diagonal of the overlap."""


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
        return (
            f"patches {self.patches[0]} and {self.patches[1]} {how} at ({x:.6g}, {y:.6g}, {z:.6g})"
        )


class _Piece(NamedTuple):
    faces: Faces
    patches: IndexArray
    """Its patches in the body."""
    box: FloatArray
    triangles: FloatArray
    """(n, 3, 3) near it: its leaves laid flat."""
    bulge: float
    """How far it is from them at most, length."""
    turn: int
    """1 if it faces outward, −1 if it bounds a cavity."""


def meetings_of(body: Faces, piece: IntArray, tolerance: float) -> tuple[Meeting, ...]:
    """Return the first `MAX_MEETINGS` places where closed pieces of `body` meet.

    If there are none, those where faces of one piece meet.

    Parameters
    ----------
    body : the faces
    piece : (patches,) number of the piece each is of
    tolerance : nearer than this they touch, length
    """
    meetings: list[Meeting] = []
    groups = [np.flatnonzero(piece == k) for k in np.unique(piece)]
    if len(groups) > 1:
        pieces = _Pieces(body, groups)
        low, high = pieces.boxes.swapaxes(0, 1)
        near = ((low[:, None] >= low) & (high[:, None] <= high)).all(axis=2)
        patch = tables_of(body).leaves["patch"]
        near[tuple(piece[patch[near_leaves(tables_of(body), tolerance)]].T)] = True
        for i, j in np.argwhere(np.triu(near | near.T, 1)).tolist():
            meeting = _meeting(pieces, pieces[i], pieces[j], tolerance)
            if meeting is not None:
                meetings.append(_at_crossing(body, piece, meeting) if meeting.overlap else meeting)
            if len(meetings) == MAX_MEETINGS:
                break
    if not meetings:
        common = coincident_at(body)
        if common is not None:
            (x, y, z) = common[2].tolist()
            meetings.append(Meeting(common[:2], (x, y, z), overlap=False))
    return tuple(meetings)


def _at_crossing(body: Faces, piece: IntArray, meeting: Meeting) -> Meeting:
    """An overlap where faces of the two pieces cross; as it is where one piece holds the other."""
    apart = np.arange(1, len(piece) + 1)
    group = np.where(np.isin(piece, piece[list(meeting.patches)]), 0, apart)
    crossing = crossing_of(body, group, 0.0)
    if crossing is None:
        return meeting
    return meeting._replace(patches=crossing.patches, point=crossing.point)


class _Pieces:
    """The pieces of a body, each looked into when first asked for."""

    def __init__(self, body: Faces, groups: Sequence[IndexArray]) -> None:
        self._body = body
        self._faces = [piece_of(body, group.tolist()) for group in groups]
        self._groups = groups
        self._made: dict[int, _Piece] = {}
        self.boxes = np.array([faces.bounds() for faces in self._faces])

    def __getitem__(self, k: int) -> _Piece:
        if k not in self._made:
            tables, faces, patches = tables_of(self._body), self._faces[k], self._groups[k]
            mine = np.isin(tables.leaves["patch"], patches) & (tables.leaves["element"] >= 0)
            plates = tables.plates[mine]
            middle, x, y = plates["middle"], plates["x"], plates["y"]
            corners = [middle + i * x + j * y for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            triangles = [np.stack([corners[0], *corners[m : m + 2]], axis=1) for m in (1, 2)]
            turn = 1 if faces.volume() > 0.0 else -1
            bulge = float(plates["departure"].max())
            flat = np.concatenate(triangles)
            self._made[k] = _Piece(faces, patches, self.boxes[k], flat, bulge, turn)
        return self._made[k]


def _meeting(pieces: _Pieces, first: _Piece, second: _Piece, tolerance: float) -> Meeting | None:
    """A place where two pieces meet."""
    low = np.maximum(first.box[0], second.box[0]) - tolerance
    box = np.array([low, np.minimum(first.box[1], second.box[1]) + tolerance])
    aside = ASIDE * float(np.linalg.norm(box[1] - box[0]))
    for one, other in ((first, second), (second, first)):
        meeting, nearest = _looked_at(pieces, one, other, box, tolerance)
        if meeting is None and len(nearest):
            meeting, _ = _meeting_among(
                pieces, one, other, _beside(one, other, nearest, aside), tolerance
            )
        if meeting is not None:
            return meeting
    return None


def _looked_at(
    pieces: _Pieces, one: _Piece, other: _Piece, box: FloatArray, tolerance: float
) -> tuple[Meeting | None, FloatArray]:
    """A place of a piece within a box that shows that it meets another; the nearest places."""
    rest, bulge = one.triangles, one.bulge
    nearest = np.zeros((0, 3))
    for _ in range(LEVELS):
        meets = (rest.min(axis=1) <= box[1] + bulge) & (rest.max(axis=1) >= box[0] - bulge)
        rest = rest[meets.all(axis=1)]
        if len(rest) == 0:
            break
        places = INNER @ rest
        meeting, off = _meeting_among(pieces, one, other, places, tolerance)
        if meeting is not None:
            return meeting, nearest
        reach = np.linalg.norm(rest - places[:, None], axis=2).max(axis=1) + 2.0 * bulge
        order = np.argsort(off, kind="stable")
        order = order[(off - reach)[order] <= tolerance]
        nearest, rest = places[order[:NEAREST]], rest[order[:KEPT]]
        middles = 0.5 * (rest + np.roll(rest, -1, axis=1))
        corners = [np.stack([rest[:, k], middles[:, k], middles[:, k - 1]], 1) for k in range(3)]
        rest = np.concatenate([middles, *corners])
    return None, nearest


def _meeting_among(
    pieces: _Pieces, one: _Piece, other: _Piece, places: FloatArray, tolerance: float
) -> tuple[Meeting | None, FloatArray]:
    """Return whether one of some places near a piece shows that it meets another.

    Also how far each is off.
    """
    feet = project(one.faces, places)
    there = project(other.faces, feet.point)
    off = np.abs(there.gap)
    face = feet.feature == Feature.FACE  # pieces that have but an edge in common are apart
    rows = np.flatnonzero(face & (off <= tolerance))
    rows = rows[_coincide_about(one, other, feet.point[rows], feet.normal[rows], tolerance)]
    overlap = len(rows) == 0
    if overlap:
        # Others may make up for it: what lies in a cavity, and the cavity itself.
        rows = np.flatnonzero(face & ((other.turn * there.gap < 0.0) | (one.turn < 0)))
        turns, beside = _turns(pieces, one, feet.point[rows], tolerance)
        rows = rows[(turns != 0) & ~beside]
    if len(rows) == 0:
        return None, off
    k = int(rows[np.argmax(off[rows])])
    x, y, z = feet.point[k].tolist()
    faces = int(one.patches[feet.patch[k]]), int(other.patches[there.patch[k]])
    return Meeting(faces, (x, y, z), overlap), off


def _coincide_about(
    one: _Piece, other: _Piece, points: FloatArray, normals: FloatArray, tolerance: float
) -> NDArray[np.bool_]:
    """Return whether the faces of two pieces coincide all round points that they have in common.

    Pieces that touch in a point or along an edge do not. Looked at so far around that two
    surfaces which touch are farther apart there than the tolerance, unless both are flatter than
    a ball of the body's size.
    """
    radius = 4.0 * np.sqrt(tolerance * one.faces.size)
    first = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    angles = 2.0 * np.pi / N_AROUND * np.arange(N_AROUND)[:, None, None]
    ways = np.cos(angles) * first + np.sin(angles) * np.cross(normals, first)
    around = (points + radius * ways).reshape(-1, 3)
    feet = project(one.faces, around)
    there = project(other.faces, feet.point)
    coincide = (feet.feature == Feature.FACE) & (there.feature == Feature.FACE)
    coincide &= np.abs(there.gap) <= tolerance
    return np.asarray(coincide.reshape(N_AROUND, -1).all(axis=0))


def _turns(
    pieces: _Pieces, one: _Piece, points: FloatArray, tolerance: float
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Turns of all pieces just before places of one; which places are beside another piece."""
    turns = np.full(len(points), min(one.turn, 0))
    beside = np.zeros(len(points), bool)
    for k, (low, high) in enumerate(pieces.boxes):
        within = (points >= low - tolerance) & (points <= high + tolerance)
        rows = np.flatnonzero(within.all(axis=1))
        if len(rows) == 0 or pieces[k] is one:
            continue
        piece = pieces[k]
        there = project(piece.faces, points[rows])
        turns[rows] += piece.turn * (piece.turn * there.gap < 0.0)
        beside[rows] |= np.abs(there.gap) <= tolerance
    return turns, beside


def _beside(one: _Piece, other: _Piece, points: FloatArray, aside: float) -> FloatArray:
    """Return places (n, 3) about those where two pieces are nearest, from `points` on."""
    for _ in range(HOPS):
        points = project(one.faces, project(other.faces, points).point).point
    way = np.random.default_rng(0).normal(size=(len(points), 8, 3))
    way *= aside / np.linalg.norm(way, axis=2, keepdims=True)
    return np.asarray((points[:, None] + way).reshape(-1, 3))
