"""The search on a closed master of a user's own that provides closest points only.

Sphere tracing finds where a path crosses the surface: steps as long as the distance to it cannot
pass it, because the distance changes by no more than the step (Hart, Sphere tracing, 1996).
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
    Projection,
    Sides,
    SurfacePlaces,
    empty_projection,
)
from contiga.statuses import Feature, Status

ClosestPoints: TypeAlias = Callable[[FloatArray], tuple[ArrayLike, ArrayLike]]
"""From points (n, 3), body axes, to their closest points (n, 3) and unit normals there (n, 3)."""

MIN_STEP = 2.0**-10
"""Least step of a search for crossings, as a share of the path. A path that enters and leaves again
within it may be missed."""
DIFFERENCE_STEP = float(np.cbrt(np.finfo(np.float64).eps))
"""Step of central differences, as a share of the coordinates."""
N_HALVINGS = 60
"""Number of bisections, which find a crossing to the last bits of its place on the path."""


def closest_point_search(closest_points: ClosestPoints) -> Surface:
    """Make the `surface` of a user-defined `Master` from a function for closest points.

    The surface must be closed, or bound a half-space or the like: each point lies inside or
    outside. Feet count as proved. On bodies thinner than a penetration the nearest wall pushes,
    wherever a point entered.

    Parameters
    ----------
    closest_points : from points (n, 3), body axes, to their closest points on the surface (n, 3)
        and the unit normals there (n, 3), which point outward. At an edge the normal decides on
        which side the point is. A point without a closest one has NaN there

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
    """A `Surface` by closest points alone; see `closest_point_search`."""

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
        """Write the closest points of p_B[rows] to the same rows of `out`; `within` is not used.

        A point without a closest one gets patch −1 and the status MAX_ITERATIONS.
        """
        if len(rows) == 0:
            return
        points = p_B[rows]
        foot, normal = self._closest_points(points)
        arm = points - foot
        gap = np.copysign(row_lengths(arm), row_products(arm, normal))
        has_foot = np.isfinite(gap)
        out.patch[rows] = np.where(has_foot, 0, -1)
        out.uv[rows] = 0.0
        out.point[rows], out.normal[rows], out.gap[rows] = foot, normal, gap
        out.feature[rows] = Feature.FACE
        out.status[rows] = np.where(has_foot, Status.OK, Status.MAX_ITERATIONS)
        out.certified[rows] = has_foot

    def _closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the user's closest points and normals; raise `GeometryError` for other shapes."""
        result = self.closest_points(points)
        try:
            foot, normal = (np.asarray(part, dtype=np.float64) for part in result)
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
        """Write the closest points to `out`, and reject those whose wall faces away from its guard.

        Only the closest point is tried; `starts` are not used. A row gets the status
        MAX_ITERATIONS, and keeps its other values, if the cosine between normal and guard is below
        `limits.cosine`, or if the point is outside or beyond the limits of distance.
        """
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), out)
        is_facing = row_products(out.normal, guards) >= limits.cosine
        is_facing &= (
            (out.gap <= 0.0) & (-out.gap >= limits.min_distance) & (-out.gap <= limits.max_distance)
        )
        out.status[~is_facing] = Status.MAX_ITERATIONS

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Write the closest points to `out`, whatever the previous feet."""
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), out)

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """Write derivatives of depth and normal to `out`; the normals' by central differences.

        Their relative error is about 1e-10.
        """
        out.depth[...] = -feet.normal
        step = DIFFERENCE_STEP * float(np.abs(p_B).max(initial=0.0))
        for j in range(3):
            shift = step * np.eye(3)[j]
            _, ahead = self._closest_points(p_B + shift)
            _, behind = self._closest_points(p_B - shift)
            out.normal[:, :, j] = (ahead - behind) / (2.0 * step)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """Return the first crossings from outside to inside; status NO_HIT without one."""
        a, b = a_B[rows], b_B[rows]
        fraction, _ = self._first_change(a, b, entries_only=True)
        return _hits(a, b, fraction)

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Return the last crossings, the first ones of the reversed paths, and their senses.

        A sense is 1 if the path enters there, −1 if it leaves, 0 if it crosses nothing.
        """
        a, b = a_B[rows], b_B[rows]
        from_end, sense = self._first_change(b, a, entries_only=False)
        return _hits(a, b, 1.0 - from_end), (-sense).astype(np.int8)

    def _first_change(
        self, start: FloatArray, end: FloatArray, *, entries_only: bool
    ) -> tuple[FloatArray, ByteArray]:
        """Return the fraction (n,) at which paths first change sides, and in which sense.

        The fraction is NaN if a path does not change sides, or if its length is zero or not finite.
        The sense is 1 if it enters there, −1 if it leaves, 0 without a change. With `entries_only`
        a path that leaves goes on to its first entry.
        """
        n, length = len(start), row_lengths(end - start)
        fraction, sense = np.full(n, np.nan), np.zeros(n, np.int8)
        t, gap = np.zeros(n), np.nan_to_num(self._gaps(start), nan=0.0)
        rows = np.flatnonzero((length > 0.0) & np.isfinite(length))
        while len(rows):
            step = np.maximum(np.abs(gap[rows]) / length[rows], MIN_STEP)
            t_new = np.minimum(t[rows] + step, 1.0)
            gap_new = self._gaps(_points_on(start, end, rows, t_new))
            has_none = np.isnan(gap_new)  # a point without a closest one stays on its side
            gap_new[has_none] = np.copysign(1e-300, gap[rows][has_none])
            changes = (gap[rows] > 0.0) != (gap_new > 0.0)
            changes &= (gap[rows] > 0.0) | (not entries_only)
            crossing = rows[changes]
            fraction[crossing] = self._bisect(start, end, crossing, t[crossing], t_new[changes])
            sense[crossing] = np.where(gap[crossing] > 0.0, 1, -1)
            t[rows], gap[rows] = t_new, gap_new
            rows = rows[~changes & (t_new < 1.0)]
        return fraction, sense

    def _bisect(
        self,
        start: FloatArray,
        end: FloatArray,
        rows: IndexArray,
        low: FloatArray,
        high: FloatArray,
    ) -> FloatArray:
        """Return fractions (k,) from `low` to `high` (k,) at which paths `rows` change sides."""
        if len(rows) == 0:
            return low
        was_outside = self._gaps(_points_on(start, end, rows, low)) > 0.0
        for _ in range(N_HALVINGS):
            middle = 0.5 * (low + high)
            is_same = (self._gaps(_points_on(start, end, rows, middle)) > 0.0) == was_outside
            low, high = np.where(is_same, middle, low), np.where(is_same, high, middle)
        return high

    def _gaps(self, p_B: FloatArray) -> FloatArray:
        """Return the signed distances (n,) of points, NaN without a closest one."""
        feet = empty_projection(len(p_B))
        self.closest(p_B, np.arange(len(p_B), dtype=np.int32), feet)
        return feet.gap

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Write the distances to `lengths[rows]`; zero for points without a closest one."""
        lengths[rows] = np.nan_to_num(np.abs(self._gaps(p_B[rows])), nan=0.0)

    def sides(self, p_B: FloatArray, rows: IntArray) -> Sides:
        """Return no known sides: these need a search."""
        return Sides(np.zeros(len(rows), np.int8), np.zeros(len(rows)))

    def clear_paths(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Return False for all paths: whether one is clear needs a search."""
        return np.zeros(len(rows), dtype=bool)

    @property
    def contact_tables(self) -> None:
        """None: there are no tables."""


def _points_on(start: FloatArray, end: FloatArray, rows: IndexArray, t: FloatArray) -> FloatArray:
    """Return points (k, 3) at fractions t (k,) of the paths `rows`."""
    return np.asarray(start[rows] + t[:, None] * (end[rows] - start[rows]))


def _hits(a: FloatArray, b: FloatArray, fraction: FloatArray) -> Hit:
    """Return hits at fractions of the paths a → b; NaN is a path without one, status NO_HIT."""
    hit = np.isfinite(fraction)
    status = np.where(hit, Status.OK, Status.NO_HIT).astype(np.int8)
    uv = np.where(hit[:, None], 0.0, np.nan) * np.ones(2)
    point = _points_on(a, b, np.arange(len(a)), fraction)
    return Hit(fraction, np.where(hit, 0, -1).astype(np.int32), uv, point, status)
