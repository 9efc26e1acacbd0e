"""Parameters of points on a surface, continuous over the seams of a closed one."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.arrays.ordered import solve
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.loops import whole_periods
from contiga.records import FloatArray

STEPS = 30
SETTLED = 1e-14
"""Newton's steps below this share of the surface's size are rounding."""
ON = 1e-7
"""Points nearer to the surface than this share of its size lie on it."""
POLE = 1e-9
"""Speed at a pole, as a share of the typical speed of the parameter."""
TYPICAL = 9
"""Points in each direction at which the typical speed is measured."""
STARTS = 6
"""Number of nearest grid points from which a search starts."""
PER_SPAN = 4
"""Points of the grid for each knot span, times the degree."""
MIN_GRID, MAX_GRID = 33, 161
"""Smallest and largest number of grid points in each direction."""
MEET = 1e-6
"""Sides nearer to each other than this share of the surface's size are one."""
SIDE = 65
"""Points of a side for the test whether the surface closes there."""


class Chart:
    """A surface with its parameters, unbounded in closed directions.

    Parameters
    ----------
    surface : the patch
    """

    def __init__(self, surface: NurbsSurface) -> None:
        self.surface = surface
        self.low, self.high = np.array(surface.domain).T
        self.size = float(np.ptp(surface.bounds(), axis=0).max())
        span = self.high - self.low
        self.periods = np.where([_closes(self, axis) for axis in range(2)], span, 0.0)
        self._tree: Any = None
        self._grid = np.empty((0, 2))
        self._typical: FloatArray | None = None

    def wrapped(self, uv: FloatArray) -> FloatArray:
        """Return parameters (n, 2) within the domain, shifted by whole turns or clamped."""
        safe = np.where(self.periods > 0.0, self.periods, 1.0)
        turned = self.low + np.mod(uv - self.low, safe)
        return np.clip(np.where(self.periods > 0.0, turned, uv), self.low, self.high)

    def points(self, uv: FloatArray) -> FloatArray:
        """Return the points (n, 3) at parameters, which may be shifted by whole turns."""
        return self.surface.evaluate(self.wrapped(uv))

    def speed(self, uv: FloatArray) -> FloatArray:
        """Return |S_u| and |S_v| (n, 2)."""
        first = self.surface.derivatives(self.wrapped(uv), 1)
        return np.linalg.norm(np.stack([first[:, 1, 0], first[:, 0, 1]], axis=1), axis=2)

    def lost(self, uv: FloatArray) -> np.ndarray:
        """Return a mask (n, 2) of the parameters that are undetermined, as at a pole."""
        if self._typical is None:
            axes = [np.linspace(*ends, TYPICAL) for ends in self.surface.domain]
            grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
            self._typical = self.speed(grid).max(axis=0)
        return np.asarray(self.speed(uv) <= POLE * self._typical)

    def refined(self, uv: FloatArray, points: FloatArray) -> FloatArray:
        """Return the feet of `points` (n, 3) by Gauss-Newton from `uv` (n, 2), without wrapping."""
        span = self.high - self.low
        open_ways = self.periods == 0.0
        uv = uv.copy()
        rows = np.arange(len(uv))
        for _ in range(STEPS):
            first = self.surface.derivatives(self.wrapped(uv[rows]), 1)
            step = _step(first[:, 1, 0], first[:, 0, 1], points[rows] - first[:, 0, 0])
            new = uv[rows] + np.clip(step, -0.1 * span, 0.1 * span)
            new = np.where(open_ways, np.clip(new, self.low, self.high), new)
            speed = np.linalg.norm(first[:, [1, 0], [0, 1]], axis=2)
            moved = (np.abs(new - uv[rows]) * speed).max(axis=1)
            uv[rows] = new
            rows = rows[moved > SETTLED * self.size]
            if len(rows) == 0:
                break
        return uv

    def located(self, points: FloatArray) -> FloatArray:
        """Return the parameters (n, 2) of the feet of `points`, within the domain."""
        if self._tree is None:
            from scipy.spatial import (
                cKDTree,
            )  # its import takes long, and most files need no search

            self._grid = _grid(self.surface)
            self._tree = cKDTree(self.surface.evaluate(self._grid))
        _, starts = self._tree.query(points, k=STARTS)
        places = np.empty((len(points), 2))
        off = np.full(len(points), np.inf)
        for k in range(STARTS):
            # If the nearest grid point leads to the point itself, no other start is better.
            rows = np.flatnonzero(off > ON * self.size)
            uv = self.wrapped(self.refined(self._grid[starts[rows, k]], points[rows]))
            miss = np.linalg.norm(self.points(uv) - points[rows], axis=1)
            better = miss < off[rows]
            places[rows[better]], off[rows[better]] = uv[better], miss[better]
        return places

    def continued(self, uv: FloatArray) -> FloatArray:
        """Return parameters (n, 2) along a path, each within half a turn of the one before.

        At a pole they go on as beside it.
        """
        lost = self.lost(uv)
        rows = np.arange(len(uv))
        for axis in range(2):
            known = np.flatnonzero(~lost[:, axis])
            if 0 < len(known) < len(uv):
                nearest = known[np.abs(rows[:, None] - known).argmin(axis=1)]
                uv[:, axis] = uv[nearest, axis]
        step = np.diff(uv, axis=0)
        step -= whole_periods(step, self.periods)
        return np.concatenate([uv[:1], uv[0] + np.cumsum(step, axis=0)])

    def unrolled(self, box: FloatArray) -> NurbsSurface:
        """Return the surface as a patch over `box` (2, 2), which may span several turns.

        Directions that are not closed, and those within the domain, stay as they are.
        """
        surface = self.surface
        for axis in np.flatnonzero(self.periods > 0.0):
            surface = _periodic_part(surface, int(axis), float(box[0, axis]), float(box[1, axis]))
        return surface


def _step(along_u: FloatArray, along_v: FloatArray, way: FloatArray) -> FloatArray:
    """Return the least-squares components (n, 2) of vectors (n, 3) along two tangents (n, 3).

    A tangent without length, as at a pole, is not gone along.
    """
    tangents = np.stack([along_u, along_v], axis=1)
    length = np.linalg.norm(tangents, axis=2)
    safe = np.maximum(length, 1e-300)
    tangents = tangents / safe[..., None]
    share = np.einsum("nki,ni->nk", tangents, way)
    cosine = np.einsum("ni,ni->n", tangents[:, 0], tangents[:, 1])
    sine = 1.0 - cosine**2
    apart = sine > 1e-14
    solved = (share - cosine[:, None] * share[:, ::-1]) / np.where(apart, sine, 1.0)[:, None]
    step: FloatArray = np.where(apart[:, None], solved, 0.5 * share) / safe
    return np.where(length > 0.0, step, 0.0)


def flat_image(surface: NurbsSurface, edge: NurbsCurve) -> NurbsCurve | None:
    """Return the exact p-curve of `edge` on a parallelogram; None for other patches."""
    points = surface.control_points
    if surface.degrees != (1, 1) or points.shape[:2] != (2, 2) or surface.is_rational:
        return None
    (u0, u1), (v0, v1) = surface.domain
    along = np.stack([points[1, 0] - points[0, 0], points[0, 1] - points[0, 0]], axis=1)
    size = np.linalg.norm(along, axis=0).max()
    twist = np.linalg.norm(points[1, 1] - points[0, 0] - along.sum(axis=1))
    product = along.T @ along
    if twist > 1e-12 * size or np.linalg.det(product) <= 1e-20 * size**4:
        return None
    matrix = np.diag([u1 - u0, v1 - v0]) @ solve(product, along.T)  # from places to parameters
    uv = np.array([u0, v0]) + (edge.control_points - points[0, 0]) @ matrix.T
    return NurbsCurve(edge.degree, edge.knots, uv, edge.weights)


def cut_down(patch: NurbsSurface, box: FloatArray) -> NurbsSurface:
    """Return a patch over `box` (2, 2); bounds within rounding of its own are its own."""
    low, high = np.array(patch.domain).T
    near = 1e-9 * (high - low)
    a = np.where(box[0] - low <= near, low, box[0])
    b = np.where(high - box[1] <= near, high, box[1])
    if (a == low).all() and (b == high).all():
        return patch
    return patch.restricted((float(a[0]), float(b[0])), (float(a[1]), float(b[1])))


def _closes(chart: Chart, axis: int) -> bool:
    """Return whether the two sides across `axis` are one curve, and no point."""
    other = np.linspace(chart.low[1 - axis], chart.high[1 - axis], SIDE)
    sides = []
    for end in (chart.low, chart.high):
        uv = np.empty((SIDE, 2))
        uv[:, axis], uv[:, 1 - axis] = end[axis], other
        sides.append(chart.surface.evaluate(uv))
    apart = np.linalg.norm(sides[0] - sides[1], axis=1).max()
    near = MEET * chart.size
    return bool(apart <= near and np.ptp(sides[0], axis=0).max() > near)


def _grid(surface: NurbsSurface) -> FloatArray:
    """Return parameters (k, 2) spread over the knot spans of a patch, dense where spans are."""
    axes = []
    for degree, knots in zip(surface.degrees, surface.knots, strict=True):
        breaks = np.unique(knots)
        count = int(np.clip(PER_SPAN * degree * (len(breaks) - 1) + 1, MIN_GRID, MAX_GRID))
        axes.append(np.interp(np.linspace(0, len(breaks) - 1, count), range(len(breaks)), breaks))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def _periodic_part(surface: NurbsSurface, axis: int, low: float, high: float) -> NurbsSurface:
    """Return a closed patch over [low, high] of its periodic parameter.

    If its own domain holds the interval, the patch is unchanged.
    """
    a, b = surface.domain[axis]
    period = b - a
    slack = 1e-9 * period
    first = int(np.floor((low + slack - a) / period))
    last = int(np.ceil((high - slack - a) / period))
    whole = surface if axis == 0 else surface.transposed()
    turns = [_shift(whole, k * period) for k in range(first, max(last, first + 1))]
    joined = turns[0]
    for turn in turns[1:]:
        joined = _join(joined, turn)
    if len(turns) > 1:
        # One turn is kept if that is enough, so that nothing is there twice.
        (start, end), v = joined.domain
        joined = joined.restricted((max(low, start), min(max(high, low + period), end)), v)
    return joined if axis == 0 else joined.transposed()


def _shift(surface: NurbsSurface, by: float) -> NurbsSurface:
    if by == 0.0:
        return surface
    U, V = surface.knots
    return NurbsSurface(surface.degrees, (U + by, V), surface.control_points, surface.weights)


def _join(one: NurbsSurface, two: NurbsSurface) -> NurbsSurface:
    """Join two patches that meet along the end of u of the first."""
    p = one.degrees[0]
    knots = np.concatenate([one.knots[0][:-1], two.knots[0][p + 1 :]])
    points = np.concatenate([one.control_points, two.control_points[1:]])
    weights = None
    if one.weights is not None and two.weights is not None:
        share = (one.weights[-1] / two.weights[0])[:1]
        weights = np.concatenate([one.weights, two.weights[1:] * share])
    return NurbsSurface(one.degrees, (knots, one.knots[1]), points, weights)
