"""Search of a step in which the body rotates: in its frame paths are curves, not chords.

In a step the body moves evenly from one pose to the other on a screw (exact for a rotation about a
fixed axis). Slave points move straight in world axes, or, if the body carries them, in its own. In
the body's frame a point of the first kind has the path p(s) = exp(−s ξ)(q₀ + s (q₁ − q₀)), whose
second derivative is bounded. A curve is never farther from its chord than an eighth of that bound,
its bulge. If the bulge is more than the share `bulge` of the body's size, the step is made in 2, 4,
8… pieces with smaller bulges, and the state after the last piece is the result. The pieces of a
point do not depend on other points. Points that cannot reach the surface, and steps without
rotation, need no pieces.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.ordered import length, row_lengths
from contiga.arrays.threads import run_ranges
from contiga.contact.detect import detect
from contiga.contact.foot_rows import copy_feet
from contiga.contact.kernels import bulging_nb
from contiga.contact.loads import Guards, GuardStates, merged
from contiga.contact.search_records import (
    CHUNK,
    BoolArray,
    Columns,
    Detection,
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

# Largest number of pieces of a step. Half a turn about an axis in the body takes 256.
MAX_PIECES = 1024
# A point counts as carried by the body if its path there is shorter than this share of that in the
# world.
CARRIED_SHARE = 0.25
# Relative allowance for rounding in bounds.
ROUNDING = 1e-9
REACQUIRED_STATUSES = (ContactStatus.FOUND, ContactStatus.REACQUIRED)
RELEASED_STATUSES = (ContactStatus.RELEASED, ContactStatus.SLID_OFF)


def detect_on_curves(
    surface: Surface,
    now: FloatArray,
    last: Last,
    active: BoolArray,
    options: Options,
    poses: tuple[FloatArray, FloatArray],
    memory: tuple[Workspace, Columns] | None = None,
) -> Detection:
    """Search one step of a body between two `poses` (4, 4), in pieces where paths bulge too much.

    `now` (n, 3) are the points at the end, body axes; for other arguments see `detect`. Without
    rotation all paths count as straight, in one call of `detect`, as they do for shells with a
    thickness, where positions decide, not paths. Otherwise a path with a large bulge is followed in
    2, 4, 8… pieces, `MAX_PIECES` at most.
    """
    if not is_turned(poses) or options.half is not None:
        return detect(surface, now, last, active, options, memory)
    screw = screw_between(*poses)
    rows, bulge = _bulging_rows(surface, (screw, relative(*poses)), (last, now), active, options)
    if len(rows) == 0:
        return detect(surface, now, last, active, options, memory)
    pieces = np.minimum(
        np.exp2(np.ceil(0.5 * np.log2(bulge / (options.bulge * options.size)))), MAX_PIECES
    )
    # All other points in one step.
    is_straight = np.ones(len(now), dtype=bool)
    is_straight[rows] = False
    straight_only = last._replace(patch=np.where(is_straight, last.patch, np.int32(-1)))
    result = detect(surface, now, straight_only, active & is_straight, options, memory)
    for count in np.unique(pieces):
        group = rows[pieces == count]
        ends = last.points_B[group], to_world(relative(*poses), now[group])
        path = Path(screw, *ends, now[group])
        of_group = _follow_pieces(surface, path, _rows_of_last(last, group), options, int(count))
        for name in ("status", "safe_distance", "last_patch", "uv"):
            getattr(result, name)[group] = getattr(of_group, name)
        copy_feet(result.feet, group, of_group.feet)
        opposed = Guards(group[of_group.guards.rows], of_group.guards.normal)
        result = result._replace(guards=merged(result.guards, opposed))
    return result._replace(touching=np.flatnonzero(result.feet.patch >= 0).astype(np.int32))


def is_turned(poses: tuple[FloatArray, FloatArray]) -> bool:
    """Return whether the rotations of two poses differ, in any bit."""
    # As lists: four times as fast for so few numbers.
    return bool(poses[0][:3, :3].tolist() != poses[1][:3, :3].tolist())


class Path(NamedTuple):
    """Paths of n points in a step, in the frame of the body."""

    screw: Screw
    """Screw of the body from pose to pose."""
    start: FloatArray
    """(n, 3) positions at the start of the step."""
    end: FloatArray
    """(n, 3) positions at the end, in the axes of the body at the start."""
    now: FloatArray
    """(n, 3) positions at the end, in the axes of the body at the end."""

    def at(self, s: float) -> FloatArray:
        """Return the points (n, 3) after the part `s` of the step, body axes."""
        if s == 1.0:
            return self.now
        return to_body(self.screw.pose(s), self.start + s * (self.end - self.start))


def _bulging_rows(
    surface: Surface,
    motion: tuple[Screw, FloatArray],
    ends: tuple[Last, FloatArray],
    active: BoolArray,
    options: Options,
) -> tuple[IndexArray, FloatArray]:
    """Return points that may reach the surface on paths that bulge more than allowed, and bulges.

    `motion` is the screw of the body, and its pose at the end of the step relative to the start.
    Points (k,) are ascending, and bulges (k,) are upper bounds, length. Points that the body
    carries are not listed: their paths in the body are short.
    """
    (screw, X_01), (last, now) = motion, ends
    n, max_bulge, path = len(now), options.bulge * options.size, Motion(last.points_B, now)
    chunks = ceil(n / CHUNK)
    extremes = np.zeros((chunks, 2))
    run_ranges(bulging_nb.largest_paths, chunks, 1, path, extremes, CHUNK)
    # A bound of `bulge_of` for all points, from the longest path and the largest coordinate.
    max_length, max_coordinate = extremes.max(axis=0, initial=0.0)
    reach = np.sqrt(3.0) * max_coordinate
    angle, shift = length(screw.turn), length(X_01[:3, 3])
    field = angle * (reach + shift) + length(screw.velocity)
    bulge = (0.125 + ROUNDING) * angle * (field + 2.0 * (max_length + angle * reach + shift))
    bulge = float(bulge)
    if bulge <= max_bulge:
        return np.zeros(0, np.int64), np.zeros(0)
    last_places = LastPlaces(last.patch, last.safe_distance, locked(active))
    lists = ChunkLists(np.empty(n, np.int32), np.zeros(chunks, np.int64))
    run_ranges(bulging_nb.list_within_reach, chunks, 1, path, last_places, bulge, lists, CHUNK)
    rows = listed(*lists)
    start, end = last.points_B[rows], to_world(X_01, now[rows])
    bulges, path_length = bulge_of(screw, start, end), row_lengths(now[rows] - start)
    clearance = np.where(last.patch[rows] >= 0, 0.0, np.abs(last.safe_distance[rows]))
    is_bulging = (
        (bulges > max_bulge)
        & (clearance <= path_length + bulges)
        & (path_length >= CARRIED_SHARE * row_lengths(end - start))
    )
    rows, bulges = rows[is_bulging], bulges[is_bulging]
    # Safe distances shrink with every step, even if a point comes no nearer, mostly if the body
    # rotates. So measure again: the surface must come as near to the middle of the chord as path
    # and chord can reach.
    start, end = last.points_B[rows], now[rows]
    middle, distance = 0.5 * (start + end), np.zeros(len(rows))
    surface.safe_distance(middle, np.flatnonzero(last.patch[rows] < 0).astype(np.int32), distance)
    may_reach = distance <= (0.5 + ROUNDING) * row_lengths(end - start) + bulge
    return rows[may_reach], bulges[may_reach]


def bulge_of(screw: Screw, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return an upper bound (n,) of the distance of paths from their chords; ends as in `Path`.

    p″ = exp(−s ξ)(ω × ξ(q) − 2 ω × (q₁ − q₀)), and ω × ξ(q) is longest at an end.
    """
    bulge = np.empty(len(start))
    bulging_nb.bulges(screw.turn, screw.velocity, start, end, bulge)
    return bulge


def _follow_pieces(
    surface: Surface, path: Path, last: Last, options: Options, pieces: int
) -> Detection:
    """Return the results of the search along `path` in this number of equal pieces.

    Feet are those at the end; statuses and proofs are those of all pieces, see `StepHistory`.
    """
    n = len(path.now)
    active = np.ones(n, dtype=bool)
    history = StepHistory.begin(last.patch >= 0)
    for k in range(1, pieces + 1):
        now = path.at(k / pieces)
        detected = detect(surface, now, last, active, options, (Workspace.of(n), Columns.of(n)))
        history = history.after(detected)
        last = detected.last(now)
    feet = detected.feet._replace(certified=history.certified)
    return detected._replace(feet=feet, status=history.status(detected.status))


class StepHistory(NamedTuple):
    """Events of n points in the pieces of a step so far."""

    touched_at_start: BoolArray
    """Whether a point was in contact at the start of the step."""
    touching: BoolArray
    """Whether a point is in contact now."""
    unbroken: BoolArray
    """Whether a point has been in contact since the start of the step, on one wall."""
    reacquired: ByteArray
    """FOUND or REACQUIRED if that happened since contact began, else 0."""
    released: ByteArray
    """RELEASED or SLID_OFF, how the last contact in the step ended; FREE without one."""
    lost: BoolArray
    """Whether a point was LOST in one of the pieces."""
    certified: ByteArray
    """1 if the foot is proved in each piece since it was last searched anew."""

    @classmethod
    def begin(cls, touching: BoolArray) -> StepHistory:
        """Return the history before the first piece."""
        none = np.zeros(len(touching), np.int8)
        return cls(touching, touching, touching, none, none, none > 0, none + np.int8(1))

    def after(self, detected: Detection) -> StepHistory:
        """Return the history after another piece, which `detected` describes.

        A contact is new if there was none before the piece, or if its status is NEW. The history of
        its foot then starts anew, as it does when the foot is FOUND or REACQUIRED.
        """
        status, touching = detected.status, detected.feet.patch >= 0
        is_new = touching & (~self.touching | (status == ContactStatus.NEW))
        is_reacquired = touching & np.isin(status, REACQUIRED_STATUSES)
        reacquired_before = np.where(touching & ~is_new, self.reacquired, np.int8(0))
        is_proved = (
            np.where(is_new | is_reacquired, np.int8(1), self.certified) & detected.feet.certified
        )
        return StepHistory(
            self.touched_at_start,
            touching,
            self.unbroken & touching & ~is_new,
            np.where(is_reacquired, status, reacquired_before),
            np.where(np.isin(status, RELEASED_STATUSES), status, self.released),
            self.lost | (status == ContactStatus.LOST),
            np.where(touching, is_proved, np.int8(0)),
        )

    def status(self, last: ByteArray) -> ByteArray:
        """Return the statuses (n,) of the whole step, whose last piece ended with `last`.

        A contact within the step is FREE at the end, as on a straight path.
        """
        plain = np.where(self.unbroken, ContactStatus.OLD, ContactStatus.NEW)
        plain = np.where(last == ContactStatus.HELD, last, plain)
        plain = np.where(self.reacquired > 0, self.reacquired, plain)
        plain = np.where(last == ContactStatus.THROUGH, last, plain)
        free = np.where(self.touched_at_start, self.released, ContactStatus.FREE)
        free = np.where(self.lost, ContactStatus.LOST, free)
        return np.where(self.touching, plain, free).astype(np.int8)


def _rows_of_last(last: Last, rows: IndexArray) -> Last:
    """Return the last step of some points alone, `rows` ascending; they are numbered from zero."""
    touching, guard, depth, opposed = last.guard_states
    new_row = np.full(len(last.patch), -1, np.int32)
    new_row[rows] = np.arange(len(rows), dtype=np.int32)
    chosen = np.flatnonzero(new_row[touching] >= 0)
    return Last(
        last.points_B[rows],
        last.patch[rows],
        last.uv[rows],
        last.last_patch[rows],
        last.safe_distance[rows],
        GuardStates(new_row[touching[chosen]], guard[chosen], depth[chosen], opposed[chosen]),
    )
