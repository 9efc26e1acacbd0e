"""Records that the search of a step hands on: its options, the last step, and its findings."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import as_numbers
from contiga.contact.loads import UNGUARDED, Column, Guards, Holds, holds_of
from contiga.masters.protocol import Master, Surface
from contiga.records import (
    ByteArray,
    FloatArray,
    Hit,
    IndexArray,
    IntArray,
    Projection,
    SurfacePlaces,
)

BoolArray = NDArray[np.bool_]

# Share of its size an open body reaches behind its faces when nothing else is said.
OPEN_DEPTH = 0.1
# Share of the body's size by which a path may be off its chord. A point that comes in no deeper
# than that and leaves again within the step may be missed; what is in contact at its end is not.
BULGE = 1e-5
# Distance from the surface below which a point counts as on it: a share of the body's size (feet
# are that exact) and one of its coordinates (they are rounded).
SAME_PLACE = 4e-12
ROUNDING = 32.0 * np.finfo(np.float64).eps
# A point that went no farther than this share of the body's size has its last foot near by.
SHORT = 2e-3
# Feet closer than this share of the body's size are one.
SAME_FOOT = 1e-9
# Points that a thread goes through at once.
CHUNK = 32768


class Limits(NamedTuple):
    """The options and lengths that decide what becomes of points, as kernels are handed them."""

    closed: bool
    """Whether the body is closed: a point is inside or outside, whatever its foot."""
    nearest: bool
    """The nearest wall that is not opposite pushes; else the one that a point came in by."""
    hold: bool
    """Keep points that slide over a border on its closest point."""
    penetration: bool
    """Search by penetration: points count as in contact where they lie inside."""
    band: float
    """Distance below which rounding decides whether a point is inside, length."""
    far: float
    """Way beyond which the last foot of a point is no longer near by, length."""
    depth: float
    """Deepest penetration that a search by penetration takes for one, length."""
    same_foot: float
    """How far feet that are one may be apart, length."""


@dataclass(frozen=True)
class Options:
    """The options of the search of a contact; as of `Limits`."""

    penetration: bool
    hold: bool
    through: bool
    """Hold points that tunnelled on the wall they came in by."""
    nearest: bool
    depth: float
    closed: bool
    size: float
    """Of the body, length."""
    band: float
    balls: bool = True
    """Ask the balls that touch at feet, which take a while to build and save closest points."""
    bulge: float = BULGE
    """How far a path may be off the chords it is followed by, share of the size."""
    half: FloatArray | None = None
    """(n,) half the thickness of shells, from which on points are in contact; None where contact
    begins at the surface."""

    @cached_property
    def limits(self) -> Limits:
        """The options that kernels are handed."""
        return Limits(
            closed=self.closed,
            nearest=self.nearest,
            hold=self.hold,
            penetration=self.penetration,
            band=self.band,
            far=SHORT * self.size,
            depth=self.depth,
            same_foot=SAME_FOOT * self.size,
        )


def options_of(
    how: tuple[bool, bool, bool, bool],
    depth: float | None,
    closed: bool,
    master: Master,
    half: FloatArray | None,
) -> Options:
    """Make the options of a contact with `master`; `how` are the first four of them."""
    size, bounds = master.size, as_numbers(master.bounds(), "bounds")
    depth = reach_of(depth, closed, size)
    band = SAME_PLACE * size + ROUNDING * float(np.abs(bounds).max())
    return Options(*how, depth, closed, size, band, half=half)


def reach_of(depth: float | None, closed: bool, size: float) -> float:
    """Return how deep contact reaches into a body of this size, length; `depth` if it is given."""
    if depth is not None:
        return depth
    return np.inf if closed else OPEN_DEPTH * size


class Last(NamedTuple):
    """The part of the last step that the search needs."""

    points_B: FloatArray
    patch: IntArray
    uv: FloatArray
    last_patch: IntArray
    safe_distance: FloatArray
    holds: Holds
    """Of the points in contact."""


class Step(NamedTuple):
    """The way of n points in a step, body axes."""

    before: FloatArray
    now: FloatArray
    way: FloatArray
    """(n,) length; beside the rigid motion of a surface that changes its shape, with the way of
    its points beside that; infinite where the point was not finite before."""
    ignored: BoolArray
    """(n,) True of free points that lie inside since the start."""
    last_patch: IntArray
    """(n,) patch of the foot last known of free points, −1 none."""
    uv: FloatArray
    """(n, 2) its parameters."""
    holds: Holds
    """Of the points that were in contact."""


class Workspace(NamedTuple):
    """Memory that the search of a step over n points works in, and of which nothing is kept.

    90 bytes a point, which a contact holds from its first step on.
    Rows of points that are not looked at, or have no foot, mean nothing.
    """

    uv: FloatArray
    """(n, 2), with the four that follow, of feet."""
    point: FloatArray
    normal: FloatArray
    gap: FloatArray
    status: ByteArray
    way: FloatArray
    """(n,), with the next, of a `Step`."""
    ignored: BoolArray
    rows: IntArray
    """(2, n) lists of points."""

    @classmethod
    def of(cls, n: int) -> Workspace:
        """Allocate a new one."""
        point, normal = np.empty((2, n, 3))
        gap, way = np.empty((2, n))
        status, ignored = np.empty(n, np.int8), np.empty(n, np.bool_)
        uv, rows = np.empty((n, 2)), np.empty((2, n), np.int32)
        return cls(uv, point, normal, gap, status, way, ignored, rows)


class Workspaces:
    """Workspaces of one size that are free: steps take one and give it back, each thread its own.

    To ask the system for new memory at every step takes longer than much of what is done in it.
    """

    def __init__(self) -> None:
        self._free: list[Workspace] = []

    def __reduce__(self) -> tuple[type[Workspaces], tuple[()]]:
        return Workspaces, ()  # copies, and what is written to files, start without

    def take(self, n: int) -> Workspace:
        """Lend a workspace for n points."""
        try:
            return self._free.pop()
        except IndexError:
            return Workspace.of(n)

    def give(self, workspace: Workspace) -> None:
        """Take a workspace back when nothing in it is needed any more."""
        self._free.append(workspace)


class Columns(NamedTuple):
    """The results of a search that a state keeps of all of n points: new arrays, or old ones.

    Wherever it is not being written to, last_patch, patch and feature are −1 and the rest is zero,
    or what a search has said of an earlier step.
    """

    status: ByteArray
    safe_distance: FloatArray
    last_patch: IntArray
    uv: FloatArray
    patch: IntArray
    feature: ByteArray
    certified: ByteArray

    @classmethod
    def of(cls, n: int) -> Columns:
        """Allocate new ones."""
        last_patch, patch = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
        feature, status = np.full(n, -1, np.int8), np.zeros(n, np.int8)
        uv, certified = np.zeros((n, 2)), np.zeros(n, np.int8)
        return cls(status, np.zeros(n), last_patch, uv, patch, feature, certified)


class Placing(NamedTuple):
    """Memory in which n points are placed once they have moved, and a list of those to look at.

    What is said of an earlier step in the columns is taken back; as in all states, parameters of
    points without a patch are zero.
    """

    before: FloatArray
    """(n, 3) the points in body axes, moved with the rigid part of the surface's motion."""
    now: FloatArray
    """(n, 3) the points in body axes."""
    last: Last
    active: BoolArray
    """(n,) whether a point takes part."""
    columns: Columns
    """Filled in."""
    way: FloatArray
    """(n,) with the next, of a `Step`; told of points that are listed."""
    ignored: BoolArray
    rows: IntArray
    """(2, n) lists that each chunk fills from its own place: of points in contact, and of free ones
    that may have come to the surface."""
    counts: IndexArray
    """(chunks, 2) how many each has listed."""
    surface_way: float = 0.0
    """Largest way of any point of the surface beside its rigid motion, length: zero of one that
    keeps its shape."""


class Detected(NamedTuple):
    """Outcome of the search for n points.

    Feet in body axes; of points without contact patch and feature are −1, certified is 0, and the
    rest means nothing.
    """

    status: ByteArray
    feet: Projection
    safe_distance: FloatArray
    """(n,) way each point can go before it has to be looked at; see `State.safe_distance`."""
    last_patch: IntArray
    """(n,) patch of the foot last known of free points, −1 none; its parameters are in `uv`."""
    uv: FloatArray
    """(n, 2) parameters of all feet, those of free points included; zeros where there is none."""
    held: IntArray
    """(k,) the points in contact, ascending."""
    opposed: Guards = UNGUARDED
    """Those of them that another wall than the nearest pushes."""

    @classmethod
    def into(cls, workspace: Workspace, columns: Columns) -> Detected:
        """Lay the outcome of points without feet into that memory."""
        status, safe_distance, last_patch, uv, patch, feature, certified = columns
        own_uv, point, normal, gap, own_status, *_ = workspace
        feet = Projection(patch, own_uv, point, normal, gap, feature, own_status, certified)
        return cls(status, feet, safe_distance, last_patch, uv, workspace.rows[0, :0])

    @property
    def holds(self) -> Holds:
        """The holds of the points in contact."""
        deep = Column(self.held, np.maximum(-self.feet.gap[self.held], 0.0))
        return holds_of(deep, self.feet.normal[self.held], self.opposed)


class Rows(NamedTuple):
    """The points that a step has to look at, ascending."""

    touching: IntArray
    """In contact before."""
    near: IntArray
    """Free before, and near enough to the surface to reach it."""


class ShapedSurface(Protocol):
    """A surface in one of its shapes."""

    def closest_from(self, starts: SurfacePlaces, p_B: FloatArray, out: Projection) -> None:
        """Write the closest points of p_B (k, 3) into `out`.

        The search starts from feet on another shape, patch −1 where there is none.
        """


class ChangedShape(Protocol):
    """A surface that has another shape than at the last step."""

    @property
    def surface(self) -> ShapedSurface:
        """The surface as it is."""

    @property
    def surface_before(self) -> ShapedSurface:
        """The surface as it was."""

    @property
    def rigid(self) -> FloatArray:
        """The rigid part (4, 4) of its motion in the step, body axes, by 90° at most."""

    @property
    def way(self) -> float:
        """Largest distance of any of its points from where `rigid` takes it, length."""

    def moved(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return points (k, 3), given before the step, after the surface has carried them along."""

    def turned(self, feet: SurfacePlaces, points: FloatArray, directions: FloatArray) -> FloatArray:
        """Return unit vectors `directions` (k, 3) at such points, rotated with the surface."""

    def last_crossings(self, a_B: FloatArray, b_B: FloatArray) -> tuple[Hit, ByteArray]:
        """Return the last crossings of points from `a_B` to `b_B` while the surface changes.

        They are places on its shape now; see `Surface.last_crossings`.
        """


class StepSearch(NamedTuple):
    """The search of one step: what is asked, of what, and where the answers are written."""

    surface: Surface
    step: Step
    last: SurfacePlaces
    """Feet of all points at the last step."""
    detected: Detected
    """Filled row by row, by whichever stage decides what becomes of a point."""
    options: Options
    shape: ChangedShape | None = None
    """How the surface has changed; None of one that keeps its shape."""

    def last_crossings(self, rows: IntArray) -> tuple[Hit, ByteArray]:
        """Return the last crossings of some points with the surface, which may change meanwhile."""
        before, now = self.step.before, self.step.now
        if self.shape is None:
            return self.surface.last_crossings(before, now, rows)
        return self.shape.last_crossings(before[rows], now[rows])

    def begins(self, rows: IndexArray) -> FloatArray:
        """Return points (len(rows), 3) before the step, carried along to where their feet are now.

        Their paths relative to the surface in its shape now begin there.
        """
        before = self.step.before[rows]
        if self.shape is None:
            return before
        feet = SurfacePlaces(self.last.patch[rows], self.last.uv[rows])
        return self.shape.moved(feet, before)


def listed(rows: IntArray, counts: IndexArray) -> IntArray:
    """Join the rows that chunks have listed, so many each, each chunk from its place in `rows`."""
    if len(counts) == 1:
        return rows[: counts[0]]
    parts = [rows[c * CHUNK : c * CHUNK + count] for c, count in enumerate(counts)]
    return np.concatenate(parts or [rows])
