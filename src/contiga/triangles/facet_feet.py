"""Feet of points on a mesh: the closest points, or those continued from the last step."""

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

# Rows below which a second thread does not pay.
POINTS = 512
TRACKED = 4096
# Rows below which an order along space costs more than it saves.
ORDERED = 64
# Pairs that tell whether points come in an order along space already, as nodes of a mesh do:
# neighbours of n points on a surface are a √n-th of the spread apart. Sorting those would cost a
# fifth of the search.
SAMPLED = 256
COHERENT = 16.0


def project(
    mesh: TriangleArrays,
    points: ArrayLike,
    start: Projection | None = None,
    mode: str = "global",
    normals: str | None = None,
    out: Projection | None = None,
) -> Projection:
    """Feet of `points` on `mesh`; `patch` is the triangle, `uv` the barycentric coordinates.

    Parameters
    ----------
    mesh : the triangles
    points : (n, 3) float64, length, the mesh's frame
    start : the `Projection` of the same points one step ago; needed by mode "track". Rows without
        a foot (patch −1) are projected globally.
    mode : "global" for the closest point of the mesh, "track" for the local minimum that walking
        over adjoining triangles from `start` comes to
    normals : "facet": the triangle's; on an edge or a corner the direction to the point, on the
        side the angle-weighted normals say. "vertex": the angle-weighted normals of the vertices,
        interpolated. What the mesh was made with if omitted.
    out : a `Projection` of n rows that is filled and returned; it may be `start`

    Returns
    -------
    Projection
        foot = (1 − u − v) A + u B + v C of the triangle's corners. The gap is the signed distance
        to the foot, whatever the normals; a tracked foot on a border has the gap over its
        triangle's plane, as on a body.

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
    # A foot is its own foot: it tells as well as its point whether it was inside a triangle.
    inside = np.where((last.feature == Feature.FACE)[:, None], last.point, np.nan)
    feet.certified[:] = 0
    track(tables, p_M, (last.patch, inside), smooth, feet)
    return feet


def is_smooth(mesh: TriangleArrays, normals: str | None) -> bool:
    """Return whether normals are those of the vertices, interpolated."""
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
    """Continue the feet on triangles start[0] to the points `p_M`; rows of −1 globally.

    start[1] is where the points were, (n, 3), for feet to be certified.
    """
    facets = tables.facets
    patch, before = start
    slots = np.where(patch >= 0, tables.slot[patch], -1)
    starts = WalkStarts(slots, np.zeros((0, 3)) if before is None else before)
    run_ranges(facet_walk_nb.project_tracked, len(p_M), TRACKED, facets, p_M, starts, smooth, out)
    closest_of_rows(facets, p_M, np.flatnonzero(slots < 0).astype(np.int32), smooth, out)


def closest_of_rows(
    facets: Facets, p_M: FloatArray, rows: IntArray, smooth: bool, out: Projection
) -> None:
    """Closest points of p_M[rows] into the same rows of `out`."""
    if len(rows) > ORDERED and not _is_along_space(p_M, rows):
        rows = order_nb.along_space(p_M, rows, *_grid(facets))
    run_ranges(closest_nb.project_global, len(rows), POINTS, facets, p_M, rows, smooth, out)


def _is_along_space(p_M: FloatArray, rows: IntArray) -> bool:
    """Return whether points follow each other closely already."""
    step = max(1, len(rows) // SAMPLED)
    at = rows[: len(rows) - 1 : step]
    p, q = p_M[at], p_M[rows[1::step][: len(at)]]
    finite = np.isfinite(p).all(axis=1) & np.isfinite(q).all(axis=1)
    if not finite.any():
        return True
    p, q = p[finite], q[finite]
    way = float(np.median(np.linalg.norm(q - p, axis=1)))
    return bool(way * np.sqrt(len(rows)) < COHERENT * np.ptp(p, axis=0).max())


def _grid(facets: Facets) -> tuple[FloatArray, float]:
    """Low corner and width of the cells' cube: the mesh and half its size around."""
    boxes = facets.box[0].reshape(2, 3, -1)
    low = boxes[0].min(axis=1)
    size = float(facets.scale[0])
    return low - 0.1 * size, 1.2 * size


def contains(mesh: TriangleArrays, points: ArrayLike) -> NDArray[np.bool_]:
    """Return (n,) True inside a closed mesh, or behind the nearest facet of an open one.

    Decided by the sign of the gap at the closest point. Points whose closest point is a border of
    an open mesh are behind nothing: False.

    Parameters
    ----------
    mesh : the triangles
    points : (n, 3) float64, length, the mesh's frame
    """
    feet = project(mesh, points)
    return (feet.gap <= 0.0) & (feet.status == Status.OK)
