"""Parameters of points on a surface, continuous over the seams of a closed one."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.arrays.ordered import solve
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.loops import whole_periods
from contiga.records import FloatArray

MAX_STEPS = 30
"""Largest number of Gauss-Newton steps."""
STEP_TOL = 1e-14
"""Newton's steps below this share of the surface's size are rounding."""
ON_TOL = 1e-7
"""Points nearer to the surface than this share of its size lie on it."""
POLE_TOL = 1e-9
"""Speed at a pole, as a share of the typical speed of the parameter."""
N_TYPICAL = 9
"""Points in each direction at which the typical speed is measured."""
N_STARTS = 6
"""Number of nearest grid points from which a search starts."""
PER_SPAN = 4
"""Points of the grid for each knot span, times the degree."""
MIN_GRID, MAX_GRID = 33, 161
"""Smallest and largest number of grid points in each direction."""
SEAM_TOL = 1e-6
"""Sides nearer to each other than this share of the surface's size are one."""
N_SIDE = 65
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
        self.periods = np.zeros(2)
        """Period in u and v, 0 if the sides across it are not one curve."""
        for axis in range(2):
            sides = []
            for end in (self.low, self.high):
                uv = np.empty((N_SIDE, 2))
                uv[:, axis] = end[axis]
                uv[:, 1 - axis] = np.linspace(self.low[1 - axis], self.high[1 - axis], N_SIDE)
                sides.append(surface.evaluate(uv))
            gap = np.linalg.norm(sides[0] - sides[1], axis=1).max()
            near = SEAM_TOL * self.size
            if gap <= near and np.ptp(sides[0], axis=0).max() > near:
                self.periods[axis] = self.high[axis] - self.low[axis]
        self._tree: Any = None
        self._grid = np.empty((0, 2))
        self._typical_speed: FloatArray | None = None

    def wrap(self, uv: FloatArray) -> FloatArray:
        """Return parameters (n, 2) within the domain, shifted by whole turns or clamped."""
        safe = np.where(self.periods > 0.0, self.periods, 1.0)
        shifted = self.low + np.mod(uv - self.low, safe)
        return np.clip(np.where(self.periods > 0.0, shifted, uv), self.low, self.high)

    def points(self, uv: FloatArray) -> FloatArray:
        """Return the points (n, 3) at parameters, which may be shifted by whole turns."""
        return self.surface.evaluate(self.wrap(uv))

    def speed(self, uv: FloatArray) -> FloatArray:
        """Return |S_u| and |S_v| (n, 2) at parameters, which may be shifted by whole turns."""
        first = self.surface.derivatives(self.wrap(uv), 1)
        return np.linalg.norm(np.stack([first[:, 1, 0], first[:, 0, 1]], axis=1), axis=2)

    def is_pole(self, uv: FloatArray) -> np.ndarray:
        """Return a mask (n, 2) of the parameters that are undetermined, as at a pole.

        The speed of such a parameter is at most `POLE_TOL` of the largest on a coarse grid.
        """
        if self._typical_speed is None:
            axes = [np.linspace(*ends, N_TYPICAL) for ends in self.surface.domain]
            grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
            self._typical_speed = self.speed(grid).max(axis=0)
        return np.asarray(self.speed(uv) <= POLE_TOL * self._typical_speed)

    def project_from(self, uv: FloatArray, points: FloatArray) -> FloatArray:
        """Return the parameters (n, 2) of the feet of `points` (n, 3), by Gauss-Newton from `uv`.

        In closed directions they are not wrapped, in others clamped to the domain. A step is at
        most a tenth of the domain. After `MAX_STEPS` a row is left where it is, converged or not.
        """
        span = self.high - self.low
        is_open = self.periods == 0.0
        uv = uv.copy()
        rows = np.arange(len(uv))
        for _ in range(MAX_STEPS):
            first = self.surface.derivatives(self.wrap(uv[rows]), 1)
            residual = points[rows] - first[:, 0, 0]
            step = _gauss_newton_step(first[:, 1, 0], first[:, 0, 1], residual)
            new = uv[rows] + np.clip(step, -0.1 * span, 0.1 * span)
            new = np.where(is_open, np.clip(new, self.low, self.high), new)
            speed = np.linalg.norm(first[:, [1, 0], [0, 1]], axis=2)
            step_length = (np.abs(new - uv[rows]) * speed).max(axis=1)
            uv[rows] = new
            rows = rows[step_length > STEP_TOL * self.size]
            if len(rows) == 0:
                break
        return uv

    def project(self, points: FloatArray) -> FloatArray:
        """Return the parameters (n, 2), within the domain, of the feet of `points` (n, 3).

        A foot is the closest of those found by Gauss-Newton from the `N_STARTS` nearest points of
        a grid; it is sought no further once it is within `ON_TOL` of the size.
        """
        if self._tree is None:
            # The import takes long, and most files need no search.
            from scipy.spatial import cKDTree

            axes = []
            for degree, knots in zip(self.surface.degrees, self.surface.knots, strict=True):
                breaks = np.unique(knots)
                count = int(np.clip(PER_SPAN * degree * (len(breaks) - 1) + 1, MIN_GRID, MAX_GRID))
                places = np.linspace(0, len(breaks) - 1, count)
                axes.append(np.interp(places, range(len(breaks)), breaks))
            self._grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
            self._tree = cKDTree(self.surface.evaluate(self._grid))
        _, starts = self._tree.query(points, k=N_STARTS)
        feet = np.empty((len(points), 2))
        distances = np.full(len(points), np.inf)
        for k in range(N_STARTS):
            # If the nearest grid point leads to the point itself, no other start is better.
            rows = np.flatnonzero(distances > ON_TOL * self.size)
            uv = self.wrap(self.project_from(self._grid[starts[rows, k]], points[rows]))
            distance = np.linalg.norm(self.points(uv) - points[rows], axis=1)
            is_better = distance < distances[rows]
            feet[rows[is_better]] = uv[is_better]
            distances[rows[is_better]] = distance[is_better]
        return feet

    def unwrap(self, uv: FloatArray) -> FloatArray:
        """Return parameters (n, 2) along a path, each within half a turn of the one before.

        At a pole a parameter becomes that of the nearest row of the path off the pole, of two the
        earlier one; this is written into `uv`, too.
        """
        at_pole = self.is_pole(uv)
        rows = np.arange(len(uv))
        for axis in range(2):
            regular = np.flatnonzero(~at_pole[:, axis])
            if 0 < len(regular) < len(uv):
                nearest = regular[np.abs(rows[:, None] - regular).argmin(axis=1)]
                uv[:, axis] = uv[nearest, axis]
        step = np.diff(uv, axis=0)
        step -= whole_periods(step, self.periods)
        return np.concatenate([uv[:1], uv[0] + np.cumsum(step, axis=0)])

    def unroll(self, box: FloatArray) -> NurbsSurface:
        """Return the surface as a patch that contains `box` (2, 2), which may span several turns.

        Directions that are not closed stay as they are. A closed one has as many whole turns as the
        box needs: a single one is kept whole, shifted if need be, several are cut down to the box,
        or to one turn from its low bound on if that is longer.
        """
        surface = self.surface
        for axis in np.flatnonzero(self.periods > 0.0).tolist():
            low, high = float(box[0, axis]), float(box[1, axis])
            a, b = surface.domain[axis]
            period = b - a
            slack = 1e-9 * period
            first = int(np.floor((low + slack - a) / period))
            last = max(int(np.ceil((high - slack - a) / period)), first + 1)
            patch = surface if axis == 0 else surface.transposed()
            U, V = patch.knots
            net, weights = patch.control_points, patch.weights
            turns = [
                patch if k == 0 else NurbsSurface(patch.degrees, (U + k * period, V), net, weights)
                for k in range(first, last)
            ]
            joined = turns[0]
            for turn in turns[1:]:
                knots, net, weights = join_splines(
                    patch.degrees[0],
                    (joined.knots[0], joined.control_points, joined.weights),
                    (turn.knots[0], turn.control_points, turn.weights),
                )
                joined = NurbsSurface(patch.degrees, (knots, V), net, weights)
            if len(turns) > 1:
                # One turn is kept if that is enough, so that no part of the surface is doubled.
                (start, end), v = joined.domain
                u = max(low, start), min(max(high, low + period), end)
                joined = joined.restricted(u, v)
            surface = joined if axis == 0 else joined.transposed()
        return surface


def _gauss_newton_step(
    tangent_u: FloatArray, tangent_v: FloatArray, residual: FloatArray
) -> FloatArray:
    """Return the least-squares coefficients (n, 2) of two tangents (n, 3) for residuals (n, 3).

    The coefficient of a tangent without length, as at a pole, is 0. If sin² of the angle between
    the tangents is at most 1e-14, each takes half of the residual along it.
    """
    tangents = np.stack([tangent_u, tangent_v], axis=1)
    length = np.linalg.norm(tangents, axis=2)
    safe = np.maximum(length, 1e-300)
    tangents = tangents / safe[..., None]
    share = np.einsum("nki,ni->nk", tangents, residual)
    cosine = np.einsum("ni,ni->n", tangents[:, 0], tangents[:, 1])
    sine = 1.0 - cosine**2
    is_regular = sine > 1e-14
    solved = (share - cosine[:, None] * share[:, ::-1]) / np.where(is_regular, sine, 1.0)[:, None]
    step: FloatArray = np.where(is_regular[:, None], solved, 0.5 * share) / safe
    return np.where(length > 0.0, step, 0.0)


def flat_image(surface: NurbsSurface, edge: NurbsCurve) -> NurbsCurve | None:
    """Return the exact p-curve of `edge` on a parallelogram; None for other patches.

    Points off the plane are projected along its normal, at any distance. A parallelogram without
    area gives None, too.
    """
    points = surface.control_points
    if surface.degrees != (1, 1) or points.shape[:2] != (2, 2) or surface.is_rational:
        return None
    (u0, u1), (v0, v1) = surface.domain
    sides = np.stack([points[1, 0] - points[0, 0], points[0, 1] - points[0, 0]], axis=1)
    size = np.linalg.norm(sides, axis=0).max()
    twist = np.linalg.norm(points[1, 1] - points[0, 0] - sides.sum(axis=1))
    product = sides.T @ sides
    if twist > 1e-12 * size or np.linalg.det(product) <= 1e-20 * size**4:
        return None
    matrix = np.diag([u1 - u0, v1 - v0]) @ solve(product, sides.T)  # from places to parameters
    uv = np.array([u0, v0]) + (edge.control_points - points[0, 0]) @ matrix.T
    return NurbsCurve(edge.degree, edge.knots, uv, edge.weights)


def restrict_patch(patch: NurbsSurface, box: FloatArray) -> NurbsSurface:
    """Return a patch cut down to `box` (2, 2); bounds within 1e-9 of the domain's are the domain's.

    If all are, or lie outside, it is `patch` itself.
    """
    low, high = np.array(patch.domain).T
    near = 1e-9 * (high - low)
    a = np.where(box[0] - low <= near, low, box[0])
    b = np.where(high - box[1] <= near, high, box[1])
    if (a == low).all() and (b == high).all():
        return patch
    return patch.restricted((float(a[0]), float(b[0])), (float(a[1]), float(b[1])))


Spline = tuple[FloatArray, FloatArray, FloatArray | None]
"""Knots, control points and weights of a curve, or of a patch along u."""


def join_splines(degree: int, first: Spline, second: Spline) -> Spline:
    """Return (knots, points, weights) of two splines as one: the second follows on the first.

    Both have degree `degree`; the second begins with the last knot and point of the first. Weights
    of the second are scaled to agree at the joint; the result has None unless both have some.
    """
    knots = np.concatenate([first[0][:-1], second[0][degree + 1 :]])
    points = np.concatenate([first[1], second[1][1:]])
    weights = None
    if first[2] is not None and second[2] is not None:
        share = np.ravel(first[2][-1] / second[2][0])[:1]
        weights = np.concatenate([first[2], second[2][1:] * share])
    return knots, points, weights
