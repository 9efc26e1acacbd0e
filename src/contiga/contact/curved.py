"""The search of a step in which the body turns: in its frame paths are curves, not their chords.

Over a step the body goes evenly from one pose to the other, on a screw (exact where it turns about
a fixed axis), and slave points go straight: in world axes, or, where they are carried along with
the body, in its own. Seen from the body a point of the first kind goes along
p(s) = exp(−s ξ)(q₀ + s (q₁ − q₀)), whose second derivative is bounded, and a curve is never farther
from its chord than an eighth of that (its bulge). Where the bulge is more than the share `bulge` of
the body's size the step is made in 2, 4, 8… pieces, in each of which it is less, and the state
after the step is that after the last piece. Each point has pieces of its own: what becomes of it
does not depend on others. Points that cannot come to the surface are left alone, and so are steps
without turning.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.ordered import length, row_lengths
from contiga.arrays.threads import run_ranges
from contiga.contact.detect import detect
from contiga.contact.foot_rows import take
from contiga.contact.kernels import bulging_nb
from contiga.contact.loads import Guards, Holds, merged
from contiga.contact.search_records import (
    CHUNK,
    BoolArray,
    Columns,
    Detected,
    Last,
    Options,
    Workspace,
    listed,
)
from contiga.contact.settle_records import ChunkLists, LastPlaces, Motion
from contiga.masters.protocol import Surface
from contiga.records import ByteArray, ContactStatus, FloatArray, IndexArray
from contiga.rigid.frames import to_body, to_world
from contiga.rigid.pose import relative
from contiga.rigid.screw import Screw, screw_between

# Pieces a step is made in at most. Half a turn about an axis in the body takes 256.
MOST = 1024
# A point that goes less than this share of its way in the world, as the body sees it, is carried.
CARRIED = 0.25
# What rounding may take from a bound, relative.
ROUNDING = 1e-9
FOUND_AGAIN = (ContactStatus.FOUND, ContactStatus.REACQUIRED)
LEFT = (ContactStatus.RELEASED, ContactStatus.SLID_OFF)


def detect_on_curves(
    surface: Surface,
    now: FloatArray,
    last: Last,
    active: BoolArray,
    options: Options,
    poses: tuple[FloatArray, FloatArray],
    memory: tuple[Workspace, Columns] | None = None,
) -> Detected:
    """Search one step of a body that goes from one to the other of its `poses` (4, 4): `detect`.

    Of shells with a thickness places decide, not paths.
    """
    if not is_turned(poses) or options.half is not None:
        return detect(surface, now, last, active, options, memory)
    screw = screw_between(*poses)
    rows, bulge = _bulging(surface, (screw, relative(*poses)), (last, now), active, options)
    if len(rows) == 0:
        return detect(surface, now, last, active, options, memory)
    pieces = np.minimum(
        np.exp2(np.ceil(0.5 * np.log2(bulge / (options.bulge * options.size)))), MOST
    )
    # The others in one step, as if there were no more.
    straight = np.ones(len(now), dtype=bool)
    straight[rows] = False
    rest = last._replace(patch=np.where(straight, last.patch, np.int32(-1)))
    whole = detect(surface, now, rest, active & straight, options, memory)
    for count in np.unique(pieces):
        together = rows[pieces == count]
        ends = last.points_B[together], to_world(relative(*poses), now[together])
        path = Path(screw, *ends, now[together])
        part = _follow(surface, path, _rows_of(last, together), options, int(count))
        for name in ("status", "safe_distance", "last_patch", "uv"):
            getattr(whole, name)[together] = getattr(part, name)
        take(whole.feet, together, part.feet, np.ones(len(together), dtype=bool))
        opposed = Guards(together[part.opposed.rows], part.opposed.normal)
        whole = whole._replace(opposed=merged(whole.opposed, opposed))
    return whole._replace(held=np.flatnonzero(whole.feet.patch >= 0).astype(np.int32))


def is_turned(poses: tuple[FloatArray, FloatArray]) -> bool:
    """Tell whether a body turns from one to the other of its poses."""
    # As lists: four times as fast for so few numbers.
    return bool(poses[0][:3, :3].tolist() != poses[1][:3, :3].tolist())


class Path(NamedTuple):
    """The way of n points over a step, as the body sees it."""

    screw: Screw
    """Of the body."""
    start: FloatArray
    """(n, 3) at the start of the step."""
    end: FloatArray
    """(n, 3) at its end, in the axes that the body had at its start."""
    now: FloatArray
    """(n, 3) the same in those that it has at the end."""

    def at(self, s: float) -> FloatArray:
        """Return the points (n, 3) after the part `s` of the step, body axes."""
        if s == 1.0:
            return self.now
        return to_body(self.screw.pose(s), self.start + s * (self.end - self.start))


def _bulging(
    surface: Surface,
    turned: tuple[Screw, FloatArray],
    ways: tuple[Last, FloatArray],
    active: BoolArray,
    options: Options,
) -> tuple[IndexArray, FloatArray]:
    """Find points that may reach the surface on paths that leave their chords by more than allowed.

    Returns their rows, and how far the paths may be off. `turned` is the screw of the body, and its
    pose at the end of the step in that at its start.
    """
    (screw, X_01), (last, now) = turned, ways
    n, allowed, path = len(now), options.bulge * options.size, Motion(last.points_B, now)
    chunks = ceil(n / CHUNK)
    extremes = np.zeros((chunks, 2))
    run_ranges(bulging_nb.farthest, chunks, 1, path, extremes, CHUNK)
    bulge = _most(screw, X_01, *extremes.max(axis=0, initial=0.0))
    if bulge <= allowed:
        return np.zeros(0, np.int64), np.zeros(0)
    known = LastPlaces(last.patch, last.safe_distance, locked(active))
    lists = ChunkLists(np.empty(n, np.int32), np.zeros(chunks, np.int64))
    run_ranges(bulging_nb.within_reach, chunks, 1, path, known, bulge, lists, CHUNK)
    rows = listed(*lists)
    start, end = last.points_B[rows], to_world(X_01, now[rows])
    bulges, way = bulge_of(screw, start, end), row_lengths(now[rows] - start)
    clearance = np.where(last.patch[rows] >= 0, 0.0, np.abs(last.safe_distance[rows]))
    far = (
        (bulges > allowed)
        & (clearance <= way + bulges)
        & (way >= CARRIED * row_lengths(end - start))
    )
    rows, bulges = rows[far], bulges[far]
    # A safe distance shrinks with every step, also where a point comes no nearer, most of all where
    # the body turns. So ask anew: about the middle of its chord a free point must have something as
    # near as path and chord can come.
    start, end = last.points_B[rows], now[rows]
    middle, reach = 0.5 * (start + end), np.zeros(len(rows))
    surface.safe_distance(middle, np.flatnonzero(last.patch[rows] < 0).astype(np.int32), reach)
    near = reach <= (0.5 + ROUNDING) * row_lengths(end - start) + bulge
    return rows[near], bulges[near]


def bulge_of(screw: Screw, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return a bound (n,) of how far paths leave their chords, length; ends are as of `Path`.

    p″ = exp(−s ξ)(ω × ξ(q) − 2 ω × (q₁ − q₀)), and ω × ξ(q) is longest at an end.
    """
    bulge = np.empty(len(start))
    bulging_nb.bulges(screw.turn, screw.velocity, start, end, bulge)
    return bulge


def _most(screw: Screw, X_01: FloatArray, way: float, far: float) -> float:
    """Bound `bulge_of` for points whose ways and coordinates are no more than these."""
    reach = np.sqrt(3.0) * far
    angle, moved = length(screw.turn), length(X_01[:3, 3])
    field = angle * (reach + moved) + length(screw.velocity)
    return float((0.125 + ROUNDING) * angle * (field + 2.0 * (way + angle * reach + moved)))


def _follow(surface: Surface, path: Path, last: Last, options: Options, pieces: int) -> Detected:
    """Search along `path` in so many pieces."""
    n = len(path.now)
    active = np.ones(n, dtype=bool)
    story = Story.begin(last.patch >= 0)
    for k in range(1, pieces + 1):
        now = path.at(k / pieces)
        detected = detect(surface, now, last, active, options, (Workspace.of(n), Columns.of(n)))
        story = story.after(detected)
        place = detected.feet.patch, detected.uv, detected.last_patch
        last = Last(now, *place, detected.safe_distance, detected.holds)
    feet = detected.feet._replace(certified=story.certified)
    return detected._replace(feet=feet, status=story.status(detected.status))


class Story(NamedTuple):
    """The events of n points in the pieces of a step so far."""

    began: BoolArray
    """In contact at the start of the step."""
    touching: BoolArray
    """In contact now."""
    since: BoolArray
    """In contact from the start of the step until now, on one wall."""
    again: ByteArray
    """FOUND or REACQUIRED where that happened since contact began, else 0."""
    left: ByteArray
    """RELEASED or SLID_OFF, as the last contact that ended in the step did; FREE for none."""
    lost: BoolArray
    """LOST in one of the pieces."""
    certified: ByteArray
    """1 where the foot is proved in each piece since it was last taken anew."""

    @classmethod
    def begin(cls, touching: BoolArray) -> Story:
        """Begin before the first piece."""
        none = np.zeros(len(touching), np.int8)
        return cls(touching, touching, touching, none, none, none > 0, none + np.int8(1))

    def after(self, detected: Detected) -> Story:
        """Add another piece."""
        status, touching = detected.status, detected.feet.patch >= 0
        new = touching & (~self.touching | (status == ContactStatus.NEW))
        again = touching & np.isin(status, FOUND_AGAIN)
        kept = np.where(touching & ~new, self.again, np.int8(0))
        proved = np.where(new | again, np.int8(1), self.certified) & detected.feet.certified
        return Story(
            self.began,
            touching,
            self.since & touching & ~new,
            np.where(again, status, kept),
            np.where(np.isin(status, LEFT), status, self.left),
            self.lost | (status == ContactStatus.LOST),
            np.where(touching, proved, np.int8(0)),
        )

    def status(self, last: ByteArray) -> ByteArray:
        """Return the statuses of the whole step, whose last piece ended with `last`.

        What came and went within the step is FREE, as it is where a straight path did.
        """
        plain = np.where(self.since, ContactStatus.OLD, ContactStatus.NEW)
        plain = np.where(last == ContactStatus.HELD, last, plain)
        plain = np.where(self.again > 0, self.again, plain)
        plain = np.where(last == ContactStatus.THROUGH, last, plain)
        free = np.where(self.began, self.left, ContactStatus.FREE)
        free = np.where(self.lost, ContactStatus.LOST, free)
        return np.where(self.touching, plain, free).astype(np.int8)


def _rows_of(last: Last, rows: IndexArray) -> Last:
    """Take the part of some points, `rows` ascending."""
    held, guard, depth, opposed = last.holds
    place = np.full(len(last.patch), -1, np.int32)
    place[rows] = np.arange(len(rows), dtype=np.int32)
    chosen = np.flatnonzero(place[held] >= 0)
    return Last(
        last.points_B[rows],
        last.patch[rows],
        last.uv[rows],
        last.last_patch[rows],
        last.safe_distance[rows],
        Holds(place[held[chosen]], guard[chosen], depth[chosen], opposed[chosen]),
    )
