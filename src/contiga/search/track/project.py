"""Feet of points on a body: the closest points, or feet continued from the last step."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.codes import DONE
from contiga.arrays.layout import as_points
from contiga.arrays.query_checks import NO_PROJECTION, checked_feet, checked_mode, checked_out
from contiga.arrays.threads import run_ranges, thread_count
from contiga.arrays.workspace import Workspace
from contiga.geometry.faces import Faces
from contiga.jit import straight
from contiga.records import FloatArray, Projection, SurfacePlaces
from contiga.search.certify.kernels import branch_nb
from contiga.search.certify.neighbourhoods import with_neighbourhoods
from contiga.search.closest.closest import closest_of_rows
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of
from contiga.search.track.kernels import track_nb
from contiga.search.track.kernels.lanes_nb import RECORD_SIZE
from contiga.search.track.track_records import Path, PendingBuffer

MIN_CHUNK, MAX_CHUNK = 2048, 16384
"""Rows of a chunk: with fewer a thread does not pay, with more their data leave the cache."""
CHUNKS_PER_THREAD = 4
"""Number of chunks per thread, so that no thread waits long for another."""
ROWS_PER_ELEMENT = 64
"""Least number of rows per element in a chunk: with fewer, many lanes are empty."""
NO_POINTS = np.zeros((0, 3))
"""Previous points that are not given."""
_workspace = Workspace()
_buffer = PendingBuffer()


def project(
    body: Faces,
    points: ArrayLike,
    start: Projection | None = None,
    mode: str = "global",
    out: Projection | None = None,
) -> Projection:
    """Return the feet of `points` on `body`.

    Parameters
    ----------
    body : the faces
    points : (n, 3) float64, length, body frame
    start : the `Projection` of the same points one step ago; needed by mode "track". Rows without
        a foot (patch −1) are projected globally.
    mode : "global" for the closest point of the body (branch and bound over its hierarchy),
        "track" for the local minimum continued from `start` (safeguarded Newton that walks over
        elements, seams and edges)
    out : a `Projection` of n rows that is filled and returned, to avoid new memory at every step;
        it may be `start`

    Returns
    -------
    Projection
        Feet exact to 1e-12 of the body's size in the tangential direction. A row that fails is
        marked in `status`, never dropped.

    Raises
    ------
    InputError
        Points not of shape (n, 3), an unknown mode, "track" without a fitting `start`, an `out`
        that does not fit.

    Notes
    -----
    Newton's method for point inversion: Piegl & Tiller, The NURBS Book, ch. 6. On kinks the sign
    of the gap follows the angle-weighted sum of the adjoining normals. Past a border the global
    mode gives the distance, with the normal along it; a tracked foot there keeps the surface's own
    normal, so that a point held at a border is not pushed sideways.
    """
    p_B = as_points(points)
    is_global = checked_mode(mode)
    if is_global:
        feet = checked_out(out, p_B, None)
        feet.certified[:] = 0
        closest_of_rows(tables_of(body), p_B, np.arange(len(p_B), dtype=np.int32), feet)
        return feet
    last, feet = checked_feet(start, out, p_B, len(body.patches), "patch")
    track(tables_of(body), p_B, SurfacePlaces(last.patch, last.uv), feet, last)
    return feet


def track(
    tables: Tables,
    p_B: FloatArray,
    starts: SurfacePlaces,
    out: Projection,
    before: FloatArray | Projection | None = None,
) -> None:
    """Write feet of `p_B` (n, 3), continued from `starts` (n rows), to `out`.

    Rows of patch −1 get their closest points. With `before`, the previous points (n, 3) or the
    previous feet, feet are certified if the quick proof of `branch_nb` shows that they are on the
    branch of stationary points from their start. A row whose walk reaches no minimum gets the
    status BRANCH_EVENT and the closest point.
    """
    n, certify = len(p_B), before is not None
    if certify:
        tables = with_neighbourhoods(tables)
    size = rows_per_chunk(n, len(tables.elements.table))
    last_feet = before if isinstance(before, Projection) else NO_PROJECTION
    last_points = before if isinstance(before, np.ndarray) else NO_POINTS
    path = Path(last_points, p_B, last_feet)
    rows = min(size, n)
    track_chunks = straight(track_nb.track_chunks)

    def chunks(first: int, last: int) -> None:
        records = _workspace.rows(rows, RECORD_SIZE)
        pending = _buffer.of(min((last - first) * size, n))
        m = track_chunks(tables, path, starts, size, records, pending, out, (first, last))
        if (pending.flags[:m] != DONE).any():
            straight(track_nb.continue_pending)(tables, p_B, pending, m, out)
        if m and certify:
            straight(branch_nb.certify_rows)(tables, p_B, pending, m, out)

    run_ranges(chunks, ceil(n / size), 1)


def rows_per_chunk(n: int, elements: int) -> int:
    """Return the number of rows per chunk for n rows on a surface of `elements` elements.

    Elements get `ROWS_PER_ELEMENT` rows if there are enough, and threads equal numbers of chunks,
    so that threads finish together. The number is at least `MIN_CHUNK`, so the only chunk may be
    larger than n.
    """
    share = n / thread_count()
    target = max(
        min(share / CHUNKS_PER_THREAD, MAX_CHUNK),
        min(ROWS_PER_ELEMENT * elements, share),
        MIN_CHUNK,
    )
    chunks = max(round(share / target), 1)
    return max(ceil(share / chunks), MIN_CHUNK)
