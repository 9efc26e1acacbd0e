"""Feet of points on a body: the closest points, or those continued from the last step."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.errors import InputError
from contiga.geometry.faces import Faces
from contiga.num.arrays import as_points
from contiga.num.query_checks import checked_mode, checked_patches
from contiga.num.threads import run_ranges, thread_count
from contiga.records import FloatArray, IntArray, Projection, empty_projection
from contiga.search.branch import certify
from contiga.search.kernels import project_nb
from contiga.search.table_types import Tables
from contiga.search.tables import tables_of
from contiga.statuses import Status

# Rows (one by one) and blocks (sixteen at a time) below which a second thread does not pay.
POINTS = 256
BLOCKS = 512
CHUNK = 32768
"""Rows binned together at most, on a body with few elements: what they use stays near."""
MOST_IN_CHUNKS = 512
"""Elements above which a chunk would have too few rows in each."""


def project(
    body: Faces, points: ArrayLike, start: Projection | None = None, mode: str = "global"
) -> Projection:
    """Feet of `points` on `body`.

    Parameters
    ----------
    points : (n, 3) float64, length, body frame
    start : the `Projection` of the same points one step ago; needed by mode "track". Rows without
        a foot (patch −1) are projected globally.
    mode : "global" for the closest point of the body (branch and bound over its hierarchy),
        "track" for the local minimum continued from `start` (safeguarded Newton that walks over
        elements, seams and edges)

    Returns
    -------
    Projection
        Feet exact to 1e-12 of the body's size in the tangential direction. A row that fails is
        marked in `status`, never dropped.

    Raises
    ------
    InputError
        Points not of shape (n, 3), an unknown mode, "track" without a fitting `start`.

    Notes
    -----
    Newton's method for point inversion: Piegl & Tiller, The NURBS Book, ch. 6. On kinks the sign
    of the gap follows the angle-weighted sum of the adjoining normals. Past a border the global
    mode gives the distance, with the normal along it; a tracked foot there keeps the surface's own
    normal, so that a point held at a border is not pushed sideways.
    """
    p_B = as_points(points)
    is_global = checked_mode(mode)
    tables = tables_of(body)
    out = empty_projection(len(p_B))
    if is_global:
        closest_of_rows(tables, p_B, np.arange(len(p_B), dtype=np.int32), out)
        return out
    patch, uv = _checked_start(start, len(p_B), len(body.patches))
    assert start is not None
    track(tables, p_B, (patch, uv), out, points_of(start))
    return out


def points_of(feet: Projection) -> FloatArray:
    """(n, 3) the points that the feet are of; NaN where they do not tell.

    A tracked foot held at a border has the surface's own normal, which does not lead to the point.
    """
    points = feet.point + feet.gap[:, None] * feet.normal
    told = (feet.status == Status.OK) | (feet.status == Status.BRANCH_EVENT)
    points[~told] = np.nan
    return np.ascontiguousarray(points)


def _checked_start(start: Projection | None, n: int, patches: int) -> tuple[IntArray, FloatArray]:
    patch = checked_patches(start, n, patches, "patch")
    assert start is not None
    uv = np.ascontiguousarray(start.uv, dtype=np.float64)
    if uv.shape != (n, 2):
        raise InputError(
            "start must have one row a point", where="start", found=uv.shape, allowed=f"uv ({n}, 2)"
        )
    return patch, uv


def track(
    tables: Tables,
    p_B: FloatArray,
    starts: tuple[IntArray, FloatArray],
    out: Projection,
    before: FloatArray | None = None,
) -> None:
    """Continue the feet starts = (patch, uv) to `p_B`, into `out`; rows of patch −1 globally.

    With `before` (n, 3), where the points were, the feet are certified: shown to be on the branch
    of stationary points that leads from their start. Where the branch ends on the way, the row is
    a BRANCH_EVENT with the closest point for a foot, or, at the inner side of a fold, with the one
    that goes on in the other face.
    """
    patch, uv = starts
    results = (out, np.zeros(len(p_B), np.uint8))
    count = len(tables.elements.table)
    if count <= MOST_IN_CHUNKS:
        size = max(ceil(len(p_B) / thread_count()), BLOCKS)
        size = ceil(size / ceil(size / CHUNK))
        chunks = ceil(len(p_B) / size)
        run_ranges(project_nb.project_chunks, chunks, 1, tables, p_B, starts, size, results)
    else:
        bins = bin_by_element(tables, patch, uv)
        run_ranges(project_nb.project_lanes, len(bins[1]), BLOCKS, tables, p_B, uv, bins, results)
    # Feet that have left their element: once more, from where they are, sorted by the new one.
    feet = (out.patch, out.uv)
    flagged = (tables.grid, feet, results[1], project_nb.GO_ON, count, 0, len(p_B))
    bins = project_nb.bin_rows(*flagged)
    run_ranges(project_nb.project_lanes, len(bins[1]), BLOCKS, tables, p_B, out.uv, bins, results)
    rows = np.flatnonzero(results[1]).astype(np.int32)
    run_ranges(project_nb.project_tracked, len(rows), POINTS, tables, p_B, starts, rows, out)
    lost = np.flatnonzero(patch < 0).astype(np.int32)
    closest_of_rows(tables, p_B, lost, out)
    if before is not None:
        ended = certify(tables, (before, p_B), starts, out)
        closest_of_rows(tables, p_B, ended, out)
        found = out.status[ended] != Status.MAX_ITERATIONS
        out.status[ended[found]] = Status.BRANCH_EVENT


def closest_of_rows(
    tables: Tables,
    p_B: FloatArray,
    rows: IntArray,
    out: Projection,
    within: FloatArray | None = None,
) -> None:
    """Closest points of p_B[rows] into the same rows of `out`.

    `within` (len(rows),) are distances to feet that are known, infinite where none is.
    """
    if within is None:
        within = np.full(len(rows), np.inf)
    run_ranges(project_nb.project_global, len(rows), POINTS, tables, p_B, rows, within, out)


def bin_by_element(
    tables: Tables, patch: IntArray, uv: FloatArray
) -> tuple[IntArray, NDArray[np.int64]]:
    """Rows that have a foot, ordered by element, and blocks of them for the lanes."""
    parts = project_nb.SORT_PARTS if len(patch) > POINTS else 1
    counts = np.zeros((project_nb.SORT_PARTS, len(tables.elements.table)), np.int64)
    element = np.empty(len(patch), np.int32)
    grain = project_nb.SORT_PARTS // parts
    run_ranges(
        project_nb.count_parts,
        project_nb.SORT_PARTS,
        grain,
        tables.grid,
        patch,
        uv,
        element,
        counts,
    )
    start = project_nb.first_places(counts)
    order = np.empty(int(start[-1]), np.int32)
    run_ranges(project_nb.place_parts, project_nb.SORT_PARTS, grain, element, counts, order)
    return order, project_nb.blocks_of(start)
