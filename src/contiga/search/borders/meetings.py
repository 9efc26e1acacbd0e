"""Whether the pieces of a body are apart, or touch, cross or lie within one another.

A piece is a set of faces connected by shared edges. A body of several closed pieces is sound if
each place of its surface has matter behind it and none before: the winding numbers of all pieces
about a point just before it (1 inside a piece that faces outward, −1 inside a cavity, which faces
inward) add up to 0. The test places are points of triangles, flat copies of the leaves, of pieces
whose leaves come near each other, or whose boxes contain each other. A triangle is dropped if its
distance from the other piece exceeds its reach; the nearest of the remaining ones are divided. If
none of them shows a meeting, the nearest places are moved by projections to where both pieces are
nearest, and their surroundings are tested. Meetings are exact to the tolerance; a small overlap far
from all these places may be missed.
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
"""Number of meetings after which the search ends."""
MAX_DIVIDED, MAX_LEVELS = 12, 5
"""Largest number of triangles divided at each level, and largest number of levels."""
BARYCENTRIC = np.array([0.36, 0.33, 0.31])
"""Barycentric coordinates of the test place of a triangle: no place of symmetry."""
N_NEAREST, N_PROJECTIONS = 4, 12
"""Number of places that are moved to where two pieces are nearest, and of projections for that."""
N_AROUND = 6
"""Number of places around a meeting that are tested before the pieces are said to coincide."""
PROBE_DIST = 3e-3
"""Distance of probes from the nearest places, as a share of the diagonal of the overlap."""


class Meeting(NamedTuple):
    """A place where pieces of a body touch or overlap."""

    patches: tuple[int, int]
    """A face of each."""
    point: tuple[float, float, float]
    """Body frame."""
    overlap: bool
    """Whether the pieces overlap; else they have a part of their faces in common."""

    def __str__(self) -> str:
        (a, b), (x, y, z) = self.patches, self.point
        verb = "overlap" if self.overlap else "coincide"
        return f"patches {a} and {b} {verb} at ({x:.6g}, {y:.6g}, {z:.6g})"


class _Piece(NamedTuple):
    """A piece of a body, and what the tests of meetings need of it."""

    faces: Faces
    patches: IndexArray
    """Its patches in the body."""
    box: FloatArray
    triangles: FloatArray
    """(n, 3, 3) flat copies of its leaves."""
    bulge: float
    """Largest distance of the piece from its triangles, length."""
    winding: int
    """1 if it faces outward, −1 if it bounds a cavity."""


def meetings_of(body: Faces, piece: IntArray, tolerance: float) -> tuple[Meeting, ...]:
    """Return places where closed pieces of `body` meet: `MAX_MEETINGS` at most, one for each pair.

    Pairs of pieces are tested whose leaves come near each other, or of which one box contains the
    other. An overlap is reported at a crossing of faces if one is found. If no pieces meet, a place
    where faces coincide is returned, if one is found, else no place.

    Parameters
    ----------
    body : the faces
    piece : (patches,) number of the piece of each patch
    tolerance : largest distance of pieces that touch, length
    """
    meetings: list[Meeting] = []
    groups = [np.flatnonzero(piece == k) for k in np.unique(piece)]
    if len(groups) > 1:
        pieces = _Pieces(body, groups)
        low, high = pieces.boxes.swapaxes(0, 1)
        may_meet = ((low[:, None] >= low) & (high[:, None] <= high)).all(axis=2)
        patch = tables_of(body).leaves["patch"]
        may_meet[tuple(piece[patch[near_leaves(tables_of(body), tolerance)]].T)] = True
        for i, j in np.argwhere(np.triu(may_meet | may_meet.T, 1)).tolist():
            meeting = _meeting_of_pieces(pieces, pieces[i], pieces[j], tolerance)
            if meeting is not None:
                if meeting.overlap:
                    # Move the overlap to a crossing of faces, unless one piece contains the other.
                    singles = np.arange(1, len(piece) + 1)
                    in_pair = np.isin(piece, piece[list(meeting.patches)])
                    crossing = crossing_of(body, np.where(in_pair, 0, singles), 0.0)
                    if crossing is not None:
                        meeting = Meeting(crossing.patches, crossing.point, overlap=True)
                meetings.append(meeting)
            if len(meetings) == MAX_MEETINGS:
                break
    if not meetings:
        coincidence = coincident_at(body)
        if coincidence is not None:
            (x, y, z) = coincidence[2].tolist()
            meetings.append(Meeting(coincidence[:2], (x, y, z), overlap=False))
    return tuple(meetings)


class _Pieces:
    """The pieces of a body; their triangles are computed at first use."""

    def __init__(self, body: Faces, groups: Sequence[IndexArray]) -> None:
        self._body = body
        self._faces = [piece_of(body, group.tolist()) for group in groups]
        self._groups = groups
        self._cache: dict[int, _Piece] = {}
        self.boxes = np.array([faces.bounds() for faces in self._faces])

    def __getitem__(self, k: int) -> _Piece:
        """Return piece k with its triangles, computed at the first use."""
        if k not in self._cache:
            tables, faces, patches = tables_of(self._body), self._faces[k], self._groups[k]
            in_piece = np.isin(tables.leaves["patch"], patches) & (tables.leaves["element"] >= 0)
            plates = tables.plates[in_piece]
            middle, x, y = plates["middle"], plates["x"], plates["y"]
            corners = [middle + i * x + j * y for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            triangles = [np.stack([corners[0], *corners[m : m + 2]], axis=1) for m in (1, 2)]
            winding = 1 if faces.volume() > 0.0 else -1
            bulge = float(plates["departure"].max())
            self._cache[k] = _Piece(
                faces, patches, self.boxes[k], np.concatenate(triangles), bulge, winding
            )
        return self._cache[k]


def _meeting_of_pieces(
    pieces: _Pieces, first: _Piece, second: _Piece, tolerance: float
) -> Meeting | None:
    """Find a place where two pieces meet, None if no test place shows one.

    Each piece is divided in turn; then places around its nearest points are tested.
    """
    low = np.maximum(first.box[0], second.box[0]) - tolerance
    box = np.array([low, np.minimum(first.box[1], second.box[1]) + tolerance])
    for piece, other in ((first, second), (second, first)):
        meeting, nearest = _meeting_by_division(pieces, piece, other, box, tolerance)
        if meeting is None and len(nearest):
            # Alternating projections lead to where the pieces are nearest: probe around there.
            for _ in range(N_PROJECTIONS):
                nearest = project(piece.faces, project(other.faces, nearest).point).point
            offset = np.random.default_rng(0).normal(size=(len(nearest), 8, 3))
            probe_dist = PROBE_DIST * float(np.linalg.norm(box[1] - box[0]))
            offset *= probe_dist / np.linalg.norm(offset, axis=2, keepdims=True)
            probes = (nearest[:, None] + offset).reshape(-1, 3)
            meeting, _ = _meeting_among(pieces, piece, other, probes, tolerance)
        if meeting is not None:
            return meeting
    return None


def _meeting_by_division(
    pieces: _Pieces, piece: _Piece, other: _Piece, box: FloatArray, tolerance: float
) -> tuple[Meeting | None, FloatArray]:
    """Find a place within a box where `piece` meets `other`; also return the nearest places.

    Returns the meeting, None if no test place shows one, and (k, 3) at most `N_NEAREST` test places
    of the last level that may still touch, nearest first; with a meeting they are of no use.
    """
    triangles, bulge = piece.triangles, piece.bulge
    nearest = np.zeros((0, 3))
    for _ in range(MAX_LEVELS):
        low, high = triangles.min(axis=1), triangles.max(axis=1)
        triangles = triangles[((low <= box[1] + bulge) & (high >= box[0] - bulge)).all(axis=1)]
        if len(triangles) == 0:
            break
        places = BARYCENTRIC @ triangles
        meeting, distance = _meeting_among(pieces, piece, other, places, tolerance)
        if meeting is not None:
            return meeting, nearest
        reach = np.linalg.norm(triangles - places[:, None], axis=2).max(axis=1) + 2.0 * bulge
        order = np.argsort(distance, kind="stable")
        order = order[(distance - reach)[order] <= tolerance]
        nearest, a = places[order[:N_NEAREST]], triangles[order[:MAX_DIVIDED]]
        middles = 0.5 * (a + np.roll(a, -1, axis=1))
        corners = [np.stack([a[:, k], middles[:, k], middles[:, k - 1]], 1) for k in range(3)]
        triangles = np.concatenate([middles, *corners])
    return None, nearest


def _meeting_among(
    pieces: _Pieces, piece: _Piece, other: _Piece, places: FloatArray, tolerance: float
) -> tuple[Meeting | None, FloatArray]:
    """Find a meeting of `piece` with `other` at the feet on `piece` of some places (n, 3).

    Returns the meeting, None if no foot shows one, and the distance (n,) of each foot from `other`.
    Coincidence goes before overlap; of several feet the one farthest from `other` is taken. Feet on
    edges do not count.
    """
    feet = project(piece.faces, places)
    other_feet = project(other.faces, feet.point)
    distance = np.abs(other_feet.gap)
    on_face = feet.feature == Feature.FACE  # pieces with only an edge in common are apart
    rows = np.flatnonzero(on_face & (distance <= tolerance))
    rows = rows[_coincides_around(piece, other, feet.point[rows], feet.normal[rows], tolerance)]
    overlap = len(rows) == 0
    if overlap:
        # Other pieces may balance an overlap: those in a cavity, and the cavity itself.
        is_inside = other.winding * other_feet.gap < 0.0
        rows = np.flatnonzero(on_face & (is_inside | (piece.winding < 0)))
        winding, is_touching = _winding_numbers(pieces, piece, feet.point[rows], tolerance)
        rows = rows[(winding != 0) & ~is_touching]
    if len(rows) == 0:
        return None, distance
    k = int(rows[np.argmax(distance[rows])])
    x, y, z = feet.point[k].tolist()
    patches = int(piece.patches[feet.patch[k]]), int(other.patches[other_feet.patch[k]])
    return Meeting(patches, (x, y, z), overlap), distance


def _coincides_around(
    piece: _Piece, other: _Piece, points: FloatArray, normals: FloatArray, tolerance: float
) -> NDArray[np.bool_]:
    """Return a mask (n,) of common points (n, 3) around which the faces of two pieces coincide.

    They do if `N_AROUND` places on a circle have feet inside faces of both, within the tolerance.
    Pieces that touch in a point or along an edge do not. At the radius of the test, surfaces that
    touch are farther apart than the tolerance, unless both are flatter than a ball of the body's
    size.
    """
    radius = 4.0 * np.sqrt(tolerance * piece.faces.size)
    e = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    angles = 2.0 * np.pi / N_AROUND * np.arange(N_AROUND)[:, None, None]
    directions = np.cos(angles) * e + np.sin(angles) * np.cross(normals, e)
    feet = project(piece.faces, (points + radius * directions).reshape(-1, 3))
    other_feet = project(other.faces, feet.point)
    coincides = (feet.feature == Feature.FACE) & (other_feet.feature == Feature.FACE)
    coincides &= np.abs(other_feet.gap) <= tolerance
    return np.asarray(coincides.reshape(N_AROUND, -1).all(axis=0))


def _winding_numbers(
    pieces: _Pieces, piece: _Piece, points: FloatArray, tolerance: float
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the sum (n,) of the winding numbers of all pieces just before points of one piece.

    Also returns a mask (n,) of the points within `tolerance` of another piece.
    """
    winding = np.full(len(points), min(piece.winding, 0))
    is_touching = np.zeros(len(points), bool)
    for k, (low, high) in enumerate(pieces.boxes):
        in_box = (points >= low - tolerance) & (points <= high + tolerance)
        rows = np.flatnonzero(in_box.all(axis=1))
        if len(rows) == 0 or pieces[k] is piece:
            continue
        other = pieces[k]
        feet = project(other.faces, points[rows])
        winding[rows] += other.winding * (other.winding * feet.gap < 0.0)
        is_touching[rows] |= np.abs(feet.gap) <= tolerance
    return winding, is_touching
