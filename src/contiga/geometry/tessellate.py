"""Triangles from a surface, to a chord tolerance or by the thesis' control-net rule.

Both give a tensor grid of parameters that holds every knot, so a patch has no cracks; seams and
collapsed sides are welded. ``chord_grid`` and ``net_grid`` give the grid itself to callers that
drop trimmed parts.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from contiga.errors import GeometryError, InputError
from contiga.geometry.bezier import BezierGrid, extract
from contiga.geometry.kernels.chord_nb import elements_within
from contiga.geometry.spline_like import SurfaceLike
from contiga.records import FloatArray
from contiga.triangles.trimesh import TriMesh

MAX_CELLS = 20_000_000
"""Largest number of cells of a grid, two triangles each."""
_WELD_TOL = 1e-12
_N_SAMPLES = 4
"""Samples of the curvature in each direction of an element."""
_CUT_FACTOR = 1.15
"""Factor on the cuts of an element for which the proof fails."""


def tessellate(
    surface: SurfaceLike, tol: float, method: Literal["net", "chord"] = "chord"
) -> TriMesh:
    """Return triangles on `surface`, anticlockwise seen from its free side.

    Parameters
    ----------
    surface : the patch
    tol : for ``"chord"`` a length: no point of the surface is farther from the triangles. For
        ``"net"`` an area: see `net_grid`.
    method : ``"chord"`` or ``"net"``

    Raises
    ------
    InputError
        The tolerance is not positive, or the method unknown.
    GeometryError
        The tolerance needs more than 40 million triangles.
    """
    check_request(tol, method)
    return grid_mesh(surface, *GRIDS[method](surface, tol))


def check_request(tol: float, method: str) -> None:
    """Raise InputError for a tolerance that is not positive or an unknown method."""
    _check_tolerance(tol)
    if method not in GRIDS:
        raise InputError("not a method", where="method", found=method, allowed="'net', 'chord'")


def grid_mesh(surface: SurfaceLike, u: FloatArray, v: FloatArray) -> TriMesh:
    """Return the mesh over a grid `u` × `v`: two triangles a cell, cut from (i, j) to (i+1, j+1).

    Sides that meet (a seam) share vertices and a collapsed side is one vertex, so that a closed
    patch gives a closed mesh. They meet within 1e-12 of the largest coordinate. Triangles with a
    vertex twice are left out.
    """
    points = surface.evaluate(np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2))
    ids = np.arange(u.size * v.size).reshape(u.size, v.size)
    grid = points.reshape(*ids.shape, 3)
    weld_distance = _WELD_TOL * float(np.abs(points).max())

    def coincide(first: FloatArray, second: FloatArray) -> bool:
        return bool(np.abs(first - second).max() <= weld_distance)

    if coincide(grid[0], grid[-1]):
        ids[-1] = ids[0]
    if coincide(grid[:, 0], grid[:, -1]):
        ids[:, -1] = ids[:, 0]
    for side in (np.s_[0, :], np.s_[-1, :], np.s_[:, 0], np.s_[:, -1]):
        if coincide(grid[side], grid[side][:1]):
            ids[side] = ids[side].min()
    a, b, c, d = ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
    has_area = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    used, new = np.unique(triangles[has_area], return_inverse=True)
    return TriMesh(points[used], new.reshape(-1, 3).astype(np.int32))


def chord_grid(surface: SurfaceLike, tol: float) -> tuple[FloatArray, FloatArray]:
    """Return parameters (u, v) of a grid whose triangles stay within the distance `tol`.

    Counts come from the curvature at samples (Filip, Magedson and Markot 1986: a triangle with
    legs a and b in parameters misses by about ``(a²|S_uu| + 2ab|S_uv| + b²|S_vv|) / 8``, of
    which only parts across the surface and its iso-lines matter). Each cell is then proved to be
    within `tol` by its control points, and cut finer until it is.

    Raises
    ------
    InputError
        The tolerance is not positive and finite.
    GeometryError
        It needs more than `MAX_CELLS` cells.
    """
    _check_tolerance(tol)
    size = float(np.ptp(surface.bounds(), axis=0).max())
    # The proof's own rounding must not count as a miss.
    allowed = tol + 1e-13 * size
    coefs, u_breaks, v_breaks = extract(surface.translated(-surface.bounds().mean(axis=0)))
    bend = _sampled_bends(surface, u_breaks, v_breaks)
    rows, columns = np.ones(bend.shape[1]), np.ones(bend.shape[2])
    while True:
        uu, vv = bend[0] / rows[:, None] ** 2, bend[2] / columns**2
        excess = (uu + 2.0 * bend[1] / (rows[:, None] * columns) + vv) / (8.0 * tol)
        if (excess <= 1.0).all():
            break
        # The direction that adds more to a bad cell is cut finer, by about the missing factor.
        by_row = np.where((excess > 1.0) & (uu >= vv), excess, 0.0).max(axis=1)
        by_column = np.where((excess > 1.0) & (uu <= vv), excess, 0.0).max(axis=0)
        rows, columns = _finer(rows, by_row), _finer(columns, by_column)
        _check_size(float(rows.sum()), float(columns.sum()), tol)
    unproved = np.ones((rows.size, columns.size), dtype=np.bool_)
    while True:
        elements_within(coefs, rows.astype(np.int64), columns.astype(np.int64), allowed, unproved)
        if not unproved.any():
            return _subdivided(u_breaks, rows), _subdivided(v_breaks, columns)
        uu, vv = bend[0] / rows[:, None] ** 2, bend[2] / columns**2
        cut_row = (unproved & (uu >= vv)).any(axis=1)
        cut_column = (unproved & (uu <= vv)).any(axis=0)
        rows = np.where(cut_row, np.maximum(rows + 1.0, np.floor(_CUT_FACTOR * rows)), rows)
        finer_columns = np.maximum(columns + 1.0, np.floor(_CUT_FACTOR * columns))
        columns = np.where(cut_column, finer_columns, columns)
        _check_size(float(rows.sum()), float(columns.sum()), tol)
        unproved |= cut_row[:, None] | cut_column


def _sampled_bends(surface: SurfaceLike, u: FloatArray, v: FloatArray) -> FloatArray:
    """Return (3, nu, nv) largest |S_uu| across u-lines, |n·S_uv| and |S_vv| across v-lines.

    They are those at 5 × 5 samples of each element, for parameters that run from 0 to 1 in it;
    samples without a normal have no twist.
    """
    # No samples on the borders: derivatives there may belong to the next element.
    shares = np.concatenate([[1e-6], np.arange(1, _N_SAMPLES) / _N_SAMPLES, [1.0 - 1e-6]])
    samples = [(b[:-1, None] + np.diff(b)[:, None] * shares).ravel() for b in (u, v)]
    uv = np.stack(np.meshgrid(*samples, indexing="ij"), -1).reshape(-1, 2)
    D = surface.derivatives(uv, 2)
    twist = np.abs((surface.normal(uv) * D[:, 1, 1]).sum(axis=1))
    values = np.array([_across(D[:, 2, 0], D[:, 1, 0]), twist, _across(D[:, 0, 2], D[:, 0, 1])])
    values = np.nan_to_num(values, nan=0.0)
    blocks = values.reshape(3, u.size - 1, shares.size, v.size - 1, shares.size)
    a, b = np.diff(u)[:, None], np.diff(v)
    return np.asarray(blocks.max(axis=(2, 4)) * np.array([a**2 + 0 * b, a * b, b**2 + 0 * a]))


def _across(second: FloatArray, first: FloatArray) -> FloatArray:
    """Return (k,) lengths of the parts of `second` normal to `first`.

    Where `first` is zero they are the lengths of `second`.
    """
    square = (first * first).sum(axis=1, keepdims=True)
    dot_product = (second * first).sum(axis=1, keepdims=True)
    share = np.divide(dot_product, square, out=np.zeros_like(dot_product), where=square > 0.0)
    return np.asarray(np.linalg.norm(second - share * first, axis=1))


def net_grid(surface: SurfaceLike, tol: float) -> tuple[FloatArray, FloatArray]:
    """Return parameters (u, v) at which pieces end once Σ|A_net − A_base| < `tol` (Eq. 4.8).

    The surface is split into Bézier pieces and these again, by knot insertion (Algorithm 3);
    A_net and A_base (Algorithms 2 and 4) are taken of each piece and their differences summed,
    because those of one curved patch need not meet. Splits run through the whole patch, so the
    mesh of the piece corners has no cracks. Each round halves the rows and columns that add at
    least a quarter of the largest difference. The rule cannot see a twist: a bilinear piece is its
    own net, so its difference is zero at any size. Raises the errors of `chord_grid`.
    """
    _check_tolerance(tol)
    grid = extract(surface)
    while True:
        net, base, bend_u, bend_v = _piece_measures(grid)
        difference = np.abs(net - base)
        if difference.sum() < tol:
            return grid.u_breaks, grid.v_breaks
        bend_sum = bend_u + bend_v
        share = np.divide(bend_u, bend_sum, out=np.full_like(bend_sum, 0.5), where=bend_sum > 0.0)
        by_row = (difference * share).sum(axis=1)
        by_column = (difference * (1.0 - share)).sum(axis=0)
        worst = max(by_row.max(), by_column.max())
        u = _bisected(grid.u_breaks, by_row >= 0.25 * worst)
        v = _bisected(grid.v_breaks, by_column >= 0.25 * worst)
        _check_size(u.size, v.size, tol)
        grid = extract(surface, u[1:-1], v[1:-1])


GRIDS = {"chord": chord_grid, "net": net_grid}
"""Function that returns the grid of parameters, by method."""


def net_area(surface: SurfaceLike) -> float:
    """Return the area of the triangulated control net (Algorithms 2 and 4 of the thesis)."""
    return float(_triangulated(surface.control_points).sum())


def base_area(surface: SurfaceLike) -> float:
    """Return the area of the two corner triangles of each element, summed.

    Algorithm 4 takes the corners of the whole patch, whose area is zero on a closed one; here
    they are those of each Bézier element.
    """
    return float(_piece_measures(extract(surface))[1].sum())


def _piece_measures(
    grid: BezierGrid,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return (nu, nv) each: net area, base area, mean excess of the net's lines in u, and in v."""
    points = grid.coefs[..., :3] / grid.coefs[..., 3:]
    net = _triangulated(points).sum(axis=(-2, -1))
    base = _triangulated(points[:, :, :: points.shape[2] - 1, :: points.shape[3] - 1])
    return (
        net,
        base.sum(axis=(-2, -1)),
        _bend(points),
        _bend(points.swapaxes(2, 3)),
    )


def _bend(points: FloatArray) -> FloatArray:
    """Return the mean excess of the net's lines along axis 2 over their chords, length."""
    legs = np.linalg.norm(np.diff(points, axis=2), axis=-1).sum(axis=2)
    chords = np.linalg.norm(points[:, :, -1] - points[:, :, 0], axis=-1)
    return np.asarray((legs - chords).mean(axis=-1))


def _triangulated(points: FloatArray) -> FloatArray:
    """Return areas (..., n − 1, m − 1) of the cells of nets (..., n, m, 3), two triangles each."""
    a, b = points[..., :-1, :-1, :], points[..., 1:, :-1, :]
    c, d = points[..., 1:, 1:, :], points[..., :-1, 1:, :]
    first = np.linalg.norm(np.cross(b - a, c - a), axis=-1)
    second = np.linalg.norm(np.cross(c - a, d - a), axis=-1)
    return np.asarray(0.5 * (first + second))


def _finer(counts: FloatArray, excess: FloatArray) -> FloatArray:
    """Return `counts` times √excess, up to twice, at least one more; the same for no excess."""
    factor = np.clip(np.sqrt(excess), 1.0, 2.0)
    return np.where(excess > 0.0, np.maximum(counts + 1.0, np.floor(counts * factor)), counts)


def _subdivided(breaks: FloatArray, counts: FloatArray) -> FloatArray:
    """Return `breaks` with each interval divided in equal parts, `counts` of them."""
    parts = [
        np.linspace(low, high, int(n) + 1)[:-1]
        for low, high, n in zip(breaks[:-1], breaks[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, breaks[-1:]])


def _bisected(breaks: FloatArray, marked: NDArray[np.bool_]) -> FloatArray:
    """Return `breaks` with the middles of the marked intervals."""
    middles = 0.5 * (breaks[:-1] + breaks[1:])
    return np.sort(np.concatenate([breaks, middles[marked]]))


def _check_tolerance(tol: float) -> None:
    """Raise InputError unless `tol` is positive and finite."""
    if not (math.isfinite(tol) and tol > 0.0):
        raise InputError("a tolerance must be positive", where="tol", found=tol)


def _check_size(rows: float, columns: float, tol: float) -> None:
    """Raise GeometryError for a grid with more than `MAX_CELLS` cells."""
    if rows * columns > MAX_CELLS:
        raise GeometryError(
            f"this tolerance needs more than {2 * MAX_CELLS} triangles",
            where="tol",
            found=tol,
            remedy="Take a larger one",
        )
