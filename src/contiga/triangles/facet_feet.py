"""Feet of points on a mesh: the closest points, or feet continued from the last step."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import as_points
from contiga.arrays.query_checks import checked_feet, checked_mode, checked_out
from contiga.arrays.threads import run_ranges
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray, Projection
from contiga.statuses import Feature, Status
from contiga.triangles.facet_records import WalkStarts
from contiga.triangles.facet_tables import Tables, tables_of
from contiga.triangles.facets import NORMALS, Facets
from contiga.triangles.kernels import closest_nb, facet_walk_nb, order_nb
from contiga.triangles.triangle_arrays import TriangleArrays

MIN_POINTS, MIN_TRACKED = 512, 4096
"""Numbers of rows below which a second thread does not pay."""
MIN_SORTED_POINTS = 64
"""Number of rows below which sorting along a space-filling curve costs more than it saves."""
N_SAMPLES, MAX_STEP_RATIO = 256, 16.0
"""Number of pairs of successive points, and the ratio of their distance to the spread of n
points over √n below which points are sorted already, as nodes of a mesh are. Sorting them would
cost a fifth of the search."""


def project(
    mesh: TriangleArrays,
    points: ArrayLike,
    start: Projection | None = None,
    mode: str = "global",
    normals: str | None = None,
    out: Projection | None = None,
) -> Projection:
    """Return feet on `mesh`; `patch` is the triangle, `uv` the barycentric coordinates.

    Parameters
    ----------
    mesh : the triangles
    points : (n, 3) float64, length, the mesh's frame
    start : the `Projection` of the same points one step ago; needed by mode "track". Rows without
        a foot (patch −1) are projected globally.
    mode : "global" for the closest point of the mesh, "track" for the local minimum that walking
        over adjoining triangles from `start` ends at
    normals : "facet" for the triangle's normal inside it, and on an edge or a corner the direction
        to the point, on the side of the angle-weighted normals; "vertex" for the angle-weighted
        normals of the vertices, interpolated. The mesh's own kind if omitted.
    out : a `Projection` of n rows that is filled and returned; it may be `start`

    Returns
    -------
    Projection
        foot = (1 − u − v) A + u B + v C of the triangle's corners. The gap is the signed distance
        to the foot, whatever the normals; a tracked foot on a border has the height over its
        triangle's plane for a gap, as on a body. A row that fails is marked in `status`.

    Raises
    ------
    InputError
        Points not of shape (n, 3), an unknown mode or kind of normals, "track" without a fitting
        `start`, an `out` that does not fit.
    MeshError
        The mesh has no triangle with an area.
    """
    p_M = as_points(points)
    smooth = is_smooth(mesh, normals)
    is_global = checked_mode(mode)
    tables = tables_of(mesh)
    if is_global:
        feet = checked_out(out, p_M, None)
        feet.certified[:] = 0
        closest_of_rows(tables.facets, p_M, np.arange(len(p_M), dtype=np.int32), smooth, feet)
        return feet
    last, feet = checked_feet(start, out, p_M, len(mesh.triangles), "triangle")
    # A foot is its own foot, so it shows as well as its point whether it was inside a triangle.
    inner_feet = np.where((last.feature == Feature.FACE)[:, None], last.point, np.nan)
    feet.certified[:] = 0
    track(tables, p_M, (last.patch, inner_feet), smooth, feet)
    return feet


def is_smooth(mesh: TriangleArrays, normals: str | None) -> bool:
    """Return whether normals are interpolated: the kind is "vertex", by default the mesh's.

    Raises InputError for another kind than "facet" and "vertex".
    """
    kind = mesh.normal_kind if normals is None else normals
    if kind not in NORMALS:
        raise InputError(
            "unknown kind of normals", where="normals", found=kind, allowed='"facet", "vertex"'
        )
    return kind == "vertex"


def track(
    tables: Tables,
    p_M: FloatArray,
    start: tuple[IntArray, FloatArray | None],
    smooth: bool,
    out: Projection,
) -> None:
    """Write feet of `p_M`, continued from the triangles start[0] (n,), to all rows of `out`.

    Rows of −1, or on a triangle without area, are searched globally. start[1] are the last
    positions of the points (n, 3), None if unknown: without them no continued foot is certified.
    """
    facets = tables.facets
    patch, before = start
    slots = np.where(patch >= 0, tables.slot[patch], -1)
    starts = WalkStarts(slots, np.zeros((0, 3)) if before is None else before)
    query = facets, p_M, starts, smooth, out
    run_ranges(facet_walk_nb.project_tracked, len(p_M), MIN_TRACKED, *query)
    closest_of_rows(facets, p_M, np.flatnonzero(slots < 0).astype(np.int32), smooth, out)


def closest_of_rows(
    facets: Facets, p_M: FloatArray, rows: IntArray, smooth: bool, out: Projection
) -> None:
    """Write the closest points of p_M[rows] to the same rows of `out`.

    The order of the search is along a space-filling curve if the points are not sorted in space;
    the results do not depend on it.
    """
    if len(rows) > MIN_SORTED_POINTS and not _is_sorted_in_space(p_M, rows):
        # The sorting grid is a cube around the mesh.
        low = facets.box[0].reshape(2, 3, -1)[0].min(axis=1)
        size = float(facets.scale[0])
        rows = order_nb.along_space(p_M, rows, low - 0.1 * size, 1.2 * size)
    run_ranges(closest_nb.project_global, len(rows), MIN_POINTS, facets, p_M, rows, smooth, out)


def _is_sorted_in_space(p_M: FloatArray, rows: IntArray) -> bool:
    """Return whether the median distance of successive points is below 16/√n of their extent.

    Fewer than 2 `N_SAMPLES` pairs are tested. Pairs that are not finite are left out; True if no
    pair remains.
    """
    step = max(1, len(rows) // N_SAMPLES)
    first = rows[: len(rows) - 1 : step]
    p, q = p_M[first], p_M[rows[1::step][: len(first)]]
    is_finite = np.isfinite(p).all(axis=1) & np.isfinite(q).all(axis=1)
    if not is_finite.any():
        return True
    p, q = p[is_finite], q[is_finite]
    distance = float(np.median(np.linalg.norm(q - p, axis=1)))
    return bool(distance * np.sqrt(len(rows)) < MAX_STEP_RATIO * np.ptp(p, axis=0).max())


def contains(mesh: TriangleArrays, points: ArrayLike) -> NDArray[np.bool_]:
    """Return (n,) whether points are inside a closed mesh, or behind an open one's nearest facet.

    The sign of the gap at the closest point decides; a point on the surface counts as inside. A
    point beside an open mesh, with its closest point on the border, is not behind the mesh, nor is
    a point that is not finite.

    Parameters
    ----------
    mesh : the triangles
    points : (n, 3) float64, length, the mesh's frame
    """
    feet = project(mesh, points)
    return (feet.gap <= 0.0) & (feet.status == Status.OK)
