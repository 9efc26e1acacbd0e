"""The search on a closed master of a user's own, of which only closest points are known.

Where a path crosses the surface is found by steps as long as the distance to it: the distance
changes by no more than the way (Hart, Sphere tracing, 1996).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.ordered import row_lengths, row_products
from contiga.errors import GeometryError
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    FootSlopes,
    Hit,
    IndexArray,
    IntArray,
    KnownSides,
    Projection,
    SurfacePlaces,
    empty_projection,
)
from contiga.statuses import Feature, Status

ClosestPoints: TypeAlias = Callable[[FloatArray], tuple[ArrayLike, ArrayLike]]
"""From points (n, 3), body axes, to their closest points (n, 3) and unit normals there (n, 3)."""

SHORTEST = 2.0**-10
"""Part of a path that a search for crossings goes on by at least. What comes in and leaves again
within it may be missed."""
DIFFERENCE = float(np.cbrt(np.finfo(np.float64).eps))
"""Step of differences, as a share of the coordinates."""
HALVINGS = 60
"""By which a crossing is found to the last bits of its place on the path."""


def closest_point_search(closest_points: ClosestPoints) -> Surface:
    """Make the `surface` of a `Master` of one's own, whose closest points are known.

    The surface must be closed, or bound a half-space or the like: each point lies inside or
    outside. Feet count as proved. On bodies that are thinner than a penetration the nearest wall
    pushes, wherever a point came in.

    Parameters
    ----------
    closest_points : from points (n, 3), body axes, to their closest points on the surface (n, 3)
        and the unit normals there (n, 3), which point outward. At an edge a normal says on which
        side its point is. A point without a closest one has NaN there

    Raises
    ------
    GeometryError
        In a search: the answer is not two arrays (n, 3).

    Examples
    --------
    >>> import contiga as cg
    >>> class Ball(cg.Master):
    ...     '''A ball about the origin, by its formula.'''
    ...     def __init__(self, radius: float) -> None:
    ...         self.radius = radius
    ...     def bounds(self):
    ...         return self.radius * np.array([[-1.0] * 3, [1.0] * 3])
    ...     @property
    ...     def surface(self):
    ...         return cg.closest_point_search(self.closest_points)
    ...     def closest_points(self, points):
    ...         normals = points / np.linalg.norm(points, axis=1)[:, None]
    ...         return self.radius * normals, normals
    >>> pad = cg.Slave([[0.0, 0.0, 1.1]], area=[0.5])
    >>> contact = cg.Contact(Ball(1.0), pad, law=cg.PenaltyLaw(100.0))
    >>> state = contact.step(contact.start(pad.points), pad.points - [0.0, 0.0, 0.2])
    >>> round(state.max_penetration, 12), state.total_force.round(9).tolist()
    (0.1, [0.0, 0.0, 10.0])
    """
    return ClosestPointSearch(closest_points)


class ClosestPointSearch(NamedTuple):
    """A `Surface` that knows its closest points and nothing else; see `closest_point_search`."""

    closest_points: ClosestPoints

    @property
    def closed(self) -> bool:
        """True: a point is inside or outside."""
        return True

    @property
    def n_elements(self) -> int:
        """Number of elements: one."""
        return 1

    @property
    def nbytes(self) -> int:
        """Zero: there are no tables."""
        return 0

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
    ) -> None:
        """Closest points; what is known of their distances would save nothing."""
        if len(rows) == 0:
            return
        points = p_B[rows]
        foot, normal = self._checked(points)
        away = points - foot
        gap = np.copysign(row_lengths(away), row_products(away, normal))
        found = np.isfinite(gap)
        out.patch[rows] = np.where(found, 0, -1)
        out.uv[rows] = 0.0
        out.point[rows], out.normal[rows], out.gap[rows] = foot, normal, gap
        out.feature[rows] = Feature.FACE
        out.status[rows] = np.where(found, Status.OK, Status.MAX_ITERATIONS)
        out.certified[rows] = found

    def _checked(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what `closest_points` answers; refuse it where a row is no point and normal."""
        answer = self.closest_points(points)
        try:
            foot, normal = (np.asarray(part, dtype=np.float64) for part in answer)
        except (TypeError, ValueError):
            foot = normal = np.zeros(0)
        if not foot.shape == normal.shape == points.shape:
            raise GeometryError(
                "must answer closest points and normals, a row a point",
                where="closest_points",
                found=f"shapes {foot.shape} and {normal.shape}",
                allowed=f"two arrays {points.shape}",
            )
        return foot, normal

    def closest_facing(
        self,
        p_B: FloatArray,
        guards: FloatArray,
        limits: FacingLimits,
        starts: SurfacePlaces,
        out: Projection,
    ) -> None:
        """Closest points, of walls that do not face away; farther ones are not known."""
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), out)
        facing = row_products(out.normal, guards) >= limits.cosine
        facing &= (out.gap <= 0.0) & (-out.gap >= limits.near)
        facing &= -out.gap <= limits.far
        out.status[~facing] = Status.MAX_ITERATIONS

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Closest points, wherever feet were."""
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), out)

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """By central differences of normals, which miss by 1e-10 of what they turn by."""
        out.depth[...] = -feet.normal
        step = DIFFERENCE * float(np.abs(p_B).max(initial=0.0))
        for j in range(3):
            way = step * np.eye(3)[j]
            ahead, behind = self._checked(p_B + way)[1], self._checked(p_B - way)[1]
            out.normal[:, :, j] = (ahead - behind) / (2.0 * step)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """First crossings from outside to inside."""
        a, b = a_B[rows], b_B[rows]
        share, _ = self._first_change(a, b, entries_only=True)
        return _hits(a, b, share)

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Crossings of either sense nearest to the ends: the first ones on the way back."""
        a, b = a_B[rows], b_B[rows]
        back, sense = self._first_change(b, a, entries_only=False)
        return _hits(a, b, 1.0 - back), (-sense).astype(np.int8)

    def _first_change(
        self, start: FloatArray, end: FloatArray, *, entries_only: bool
    ) -> tuple[FloatArray, ByteArray]:
        """Return where paths first change sides, as a share (n,) of the way, and in which sense.

        The share is NaN where a path does not change sides. The sense is 1 on the way in, −1 on the
        way out.
        """
        n, length = len(start), row_lengths(end - start)
        share, sense = np.full(n, np.nan), np.zeros(n, np.int8)
        at, gap = np.zeros(n), np.nan_to_num(self._gaps(start), nan=0.0)
        left = np.flatnonzero((length > 0.0) & np.isfinite(length))
        while len(left):
            step = np.maximum(np.abs(gap[left]) / length[left], SHORTEST)
            to = np.minimum(at[left] + step, 1.0)
            new = self._gaps(_along(start, end, left, to))
            unknown = np.isnan(new)  # such a place does not change the side
            new[unknown] = np.copysign(1e-300, gap[left][unknown])
            change = (gap[left] > 0.0) != (new > 0.0)
            change &= (gap[left] > 0.0) | (not entries_only)
            rows = left[change]
            share[rows] = self._halved(start, end, rows, at[rows], to[change])
            sense[rows] = np.where(gap[rows] > 0.0, 1, -1)
            at[left], gap[left] = to, new
            left = left[~change & (to < 1.0)]
        return share, sense

    def _halved(
        self,
        start: FloatArray,
        end: FloatArray,
        rows: IndexArray,
        low: FloatArray,
        high: FloatArray,
    ) -> FloatArray:
        """Shares of the way between `low` and `high` at which paths `rows` change sides."""
        if len(rows) == 0:
            return low
        before = self._gaps(_along(start, end, rows, low)) > 0.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            same = (self._gaps(_along(start, end, rows, middle)) > 0.0) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return high

    def _gaps(self, p_B: FloatArray) -> FloatArray:
        feet = empty_projection(len(p_B))
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), feet)
        return feet.gap

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """The distances themselves; zero where there is no closest point."""
        lengths[rows] = np.nan_to_num(np.abs(self._gaps(p_B[rows])), nan=0.0)

    def sides(self, p_B: FloatArray, rows: IntArray) -> KnownSides:
        """Nothing is known at once."""
        return KnownSides(np.zeros(len(rows), np.int8), np.zeros(len(rows)))

    def clear_ways(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Nothing is known at once."""
        return np.zeros(len(rows), dtype=bool)

    @property
    def contact_tables(self) -> None:
        """Nothing is known at once."""


def _along(start: FloatArray, end: FloatArray, rows: IndexArray, share: FloatArray) -> FloatArray:
    """Return (k, 3) at shares of the ways of some paths."""
    return np.asarray(start[rows] + share[:, None] * (end[rows] - start[rows]))


def _hits(a: FloatArray, b: FloatArray, share: FloatArray) -> Hit:
    """Hits of paths at shares of their ways, NaN for none."""
    hit = np.isfinite(share)
    status = np.where(hit, Status.OK, Status.NO_HIT).astype(np.int8)
    uv = np.where(hit[:, None], 0.0, np.nan) * np.ones(2)
    point = _along(a, b, np.arange(len(a)), share)
    return Hit(share, np.where(hit, 0, -1).astype(np.int32), uv, point, status)
