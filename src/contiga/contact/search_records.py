"""Define the records of the search of a step: options, last step, work arrays and results."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import as_numbers
from contiga.contact.loads import UNGUARDED, Column, Guards, GuardStates, guard_states_of
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

# Default depth of contact behind the faces of an open body, as a share of its size.
OPEN_DEPTH = 0.1
# Share of the body's size by which a path may deviate from its chord. A point that enters no deeper
# and leaves again within the step may be missed; one that is in contact at the end is not.
BULGE = 1e-5
# Distance from the surface below which a point counts as on it: a share of the body's size (the
# accuracy of feet) and of its coordinates (their rounding).
SAME_PLACE = 4e-12
ROUNDING = 32.0 * np.finfo(np.float64).eps
# Share of the body's size up to which a path is short: the last foot is then near the new one.
SHORT_PATH = 2e-3
# Share of the body's size within which feet are the same.
SAME_FOOT = 1e-9
# Points per chunk of a thread.
CHUNK = 32768


class Limits(NamedTuple):
    """Options and lengths of the search, as kernels need them."""

    closed: bool
    """Whether the body is closed, so that points are inside or outside."""
    nearest: bool
    """Whether the nearest wall that is not opposite pushes; else the wall of entry pushes."""
    hold: bool
    """Whether points that slide over a border stay in contact at its closest point."""
    penetration: bool
    """Whether the search is by penetration: points inside are in contact."""
    band: float
    """Distance below which rounding decides whether a point is inside, length."""
    short_path: float
    """Longest path after which the last foot is still near the new one, length."""
    depth: float
    """Largest penetration that a search by penetration accepts, length."""
    same_foot: float
    """Distance within which feet are the same, length."""


@dataclass(frozen=True)
class Options:
    """Options of the search of a contact; see `Limits`."""

    penetration: bool
    hold: bool
    through: bool
    """Whether points that tunnelled are held at the wall of entry."""
    nearest: bool
    depth: float
    """Largest depth of contact, length; infinite without a limit."""
    closed: bool
    size: float
    """Size of the body, length."""
    band: float
    balls: bool = True
    """Whether touching balls at feet are used: building them takes time and saves searches."""
    bulge: float = BULGE
    """Allowed deviation of a path from its chords, as a share of the size."""
    half: FloatArray | None = None
    """(n,) half the thickness of shells, the distance of contact; None without thickness."""

    @cached_property
    def limits(self) -> Limits:
        """The options for kernels."""
        return Limits(
            closed=self.closed,
            nearest=self.nearest,
            hold=self.hold,
            penetration=self.penetration,
            band=self.band,
            short_path=SHORT_PATH * self.size,
            depth=self.depth,
            same_foot=SAME_FOOT * self.size,
        )


def options_of(
    flags: tuple[bool, bool, bool, bool],
    depth: float | None,
    closed: bool,
    master: Master,
    half: FloatArray | None,
) -> Options:
    """Return the options of a contact with `master`.

    `flags` are `penetration`, `hold`, `through` and `nearest`; see `reach_of` for `depth`.
    """
    size, bounds = master.size, as_numbers(master.bounds(), "bounds")
    depth = reach_of(depth, closed, size)
    band = SAME_PLACE * size + ROUNDING * float(np.abs(bounds).max())
    return Options(*flags, depth, closed, size, band, half=half)


def reach_of(depth: float | None, closed: bool, size: float) -> float:
    """Return the largest depth of contact, length: `depth` if given.

    Else it is infinite in a closed body, and the share `OPEN_DEPTH` of the size of an open one.
    """
    if depth is not None:
        return depth
    return np.inf if closed else OPEN_DEPTH * size


class Last(NamedTuple):
    """The state after the last step, as far as the search needs it."""

    points_B: FloatArray
    """(n, 3) positions, body axes."""
    patch: IntArray
    """(n,) as in `State`, like the next three fields."""
    uv: FloatArray
    last_patch: IntArray
    safe_distance: FloatArray
    guard_states: GuardStates
    """Guards and depths of the points in contact."""


class Step(NamedTuple):
    """Paths of n points in a step, body axes, with their state before it."""

    before: FloatArray
    """(n, 3) positions before the step."""
    now: FloatArray
    """(n, 3) positions at its end."""
    path_length: FloatArray
    """(n,) length; infinite if the point was not finite before. On a surface that changes its
    shape, relative to its rigid motion, plus the largest travel of the surface beside that."""
    inside_since_start: BoolArray
    """(n,) True for free points that have been inside since the start."""
    last_patch: IntArray
    """(n,) patch of the last known foot of free points, −1 without one."""
    uv: FloatArray
    """(n, 2) its parameters."""
    guard_states: GuardStates
    """Guards and depths of the points that were in contact."""


class Workspace(NamedTuple):
    """Work arrays of the search of a step over n points: 90 bytes per point, kept by the contact.

    Rows of points that are not examined, or have no foot, are undefined.
    """

    uv: FloatArray
    """(n, 2) parameters of feet; the next four fields also describe feet."""
    point: FloatArray
    normal: FloatArray
    gap: FloatArray
    status: ByteArray
    path_length: FloatArray
    """(n,), see `Step`, as the next field."""
    inside_since_start: BoolArray
    rows: IntArray
    """(2, n) lists of points."""

    @classmethod
    def of(cls, n: int) -> Workspace:
        """Allocate a new one."""
        point, normal = np.empty((2, n, 3))
        gap, path_length = np.empty((2, n))
        status, inside = np.empty(n, np.int8), np.empty(n, np.bool_)
        uv, rows = np.empty((n, 2)), np.empty((2, n), np.int32)
        return cls(uv, point, normal, gap, status, path_length, inside, rows)


class WorkspacePool:
    """A pool of workspaces of one size; each step takes one and gives it back.

    Allocating new memory at every step takes longer than much of the work in it.
    """

    def __init__(self) -> None:
        self._free: list[Workspace] = []

    def __reduce__(self) -> tuple[type[WorkspacePool], tuple[()]]:
        return WorkspacePool, ()  # copies and pickles start empty

    def take(self, n: int) -> Workspace:
        """Return a free workspace, all of which are for n points; allocate one if there is none."""
        try:
            return self._free.pop()
        except IndexError:
            return Workspace.of(n)

    def give(self, workspace: Workspace) -> None:
        """Take back a workspace that is no longer needed."""
        self._free.append(workspace)


class Columns(NamedTuple):
    """Results of a search for all n points that a state keeps, in new or reused arrays.

    Rows that are not written hold −1 (last_patch, patch, feature) and zero, or the results of an
    earlier step.
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


class PlacementArrays(NamedTuple):
    """Input and output of the kernels that place n moved points and list those to examine.

    The kernels reset results of an earlier step in the columns: as in all states, parameters of
    points without a patch are zero.
    """

    before: FloatArray
    """(n, 3) the points in body axes, moved with the rigid part of the surface's motion."""
    now: FloatArray
    """(n, 3) the points in body axes."""
    last: Last
    active: BoolArray
    """(n,) whether each point takes part."""
    columns: Columns
    """Results, filled in."""
    path_length: FloatArray
    """(n,), see `Step`, as the next field; filled in for points that are listed."""
    inside_since_start: BoolArray
    rows: IntArray
    """(2, n) lists that each chunk fills from its own first row: points in contact, and free points
    that may have reached the surface."""
    counts: IndexArray
    """(chunks, 2) lengths of the lists."""
    surface_travel: float = 0.0
    """Largest travel of a surface point relative to the rigid motion, length; zero for a constant
    shape."""


class Detection(NamedTuple):
    """Results of the search for n points.

    Feet are in body axes. Points without contact have patch and feature −1 and certified 0; their
    other values are undefined.
    """

    status: ByteArray
    feet: Projection
    safe_distance: FloatArray
    """(n,) path length up to which each point need not be examined; see `State.safe_distance`."""
    last_patch: IntArray
    """(n,) patch of the last known foot of free points, −1 without one; `uv` has its parameters."""
    uv: FloatArray
    """(n, 2) parameters of all feet, free points included; zero without a foot."""
    touching: IntArray
    """(k,) the points in contact, ascending."""
    guards: Guards = UNGUARDED
    """Guards of the points in contact that another wall than the nearest pushes."""

    @classmethod
    def into(cls, workspace: Workspace, columns: Columns) -> Detection:
        """Make the results for points without feet in these arrays."""
        status, safe_distance, last_patch, uv, patch, feature, certified = columns
        own_uv, point, normal, gap, own_status, *_ = workspace
        feet = Projection(patch, own_uv, point, normal, gap, feature, own_status, certified)
        return cls(status, feet, safe_distance, last_patch, uv, workspace.rows[0, :0])

    def last(self, points_B: FloatArray) -> Last:
        """Return the input of the next step's search; the points are now at points_B (n, 3)."""
        feet = self.feet.patch, self.uv, self.last_patch
        return Last(points_B, *feet, self.safe_distance, self.guard_states)

    @property
    def guard_states(self) -> GuardStates:
        """Guards and depths of the points in contact."""
        rows = self.touching
        depth = Column(rows, np.maximum(-self.feet.gap[rows], 0.0))
        return guard_states_of(depth, self.feet.normal[rows], self.guards)


class Rows(NamedTuple):
    """The points that a step must examine, ascending."""

    touching: IntArray
    """Points in contact before the step."""
    free: IntArray
    """Free points that may have reached the surface."""


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
        """The surface at the end of the step."""

    @property
    def surface_before(self) -> ShapedSurface:
        """The surface before the step."""

    @property
    def rigid(self) -> FloatArray:
        """The rigid part (4, 4) of its motion in the step, body axes, by 90° at most."""

    @property
    def travel(self) -> float:
        """Largest distance of a surface point from its place by `rigid` alone, length."""

    def moved(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return points (k, 3), given before the step, after the surface has carried them along."""

    def turned(self, feet: SurfacePlaces, points: FloatArray, directions: FloatArray) -> FloatArray:
        """Return unit vectors `directions` (k, 3) at places, rotated with the surface."""

    def last_crossings(self, a_B: FloatArray, b_B: FloatArray) -> tuple[Hit, ByteArray]:
        """Return the last crossings of points from `a_B` to `b_B` while the surface changes.

        They are places on its shape now; see `Surface.last_crossings`.
        """


class StepSearch(NamedTuple):
    """The search of one step: surface, paths, last feet and results."""

    surface: Surface
    step: Step
    last: SurfacePlaces
    """Feet of all points at the last step."""
    detected: Detection
    """Results, filled in by the stages that decide on points."""
    options: Options
    shape: ChangedShape | None = None
    """Change of the surface in the step; None for a constant shape."""

    def last_crossings(self, rows: IntArray) -> tuple[Hit, ByteArray]:
        """Return the last crossings of points `rows` with the surface, which may change shape."""
        before, now = self.step.before, self.step.now
        if self.shape is None:
            return self.surface.last_crossings(before, now, rows)
        return self.shape.last_crossings(before[rows], now[rows])

    def path_starts(self, rows: IndexArray) -> FloatArray:
        """Return points (len(rows), 3) before the step, carried along with their feet.

        Paths relative to the surface at the end of the step begin there.
        """
        before = self.step.before[rows]
        if self.shape is None:
            return before
        feet = SurfacePlaces(self.last.patch[rows], self.last.uv[rows])
        return self.shape.moved(feet, before)


def listed(rows: IntArray, counts: IndexArray) -> IntArray:
    """Return the lists of rows of chunks as one; `counts` are their lengths.

    Each list begins at its chunk's first row of `rows`; a single list is a view.
    """
    if len(counts) == 1:
        return rows[: counts[0]]
    parts = [rows[c * CHUNK : c * CHUNK + count] for c, count in enumerate(counts)]
    return np.concatenate(parts or [rows])
