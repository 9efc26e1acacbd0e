"""Tracking of a single point, as a thread of a GPU does it.

The mathematics are the same as in the lanes and in the quick certificate, so that the results have
the same bits. A row without a proved foot within its patch is flagged and not changed: the CPU does
the careful walk, creases, edges and the search for closest points. `tables` is any record with
`elements`, `grid`, `trims`, `neighbourhoods` and `scale` as `Tables` has them.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import locate
from contiga.jit import kernel
from contiga.search.certify.kernels.branch_nb import certified_ball, motion_from
from contiga.search.closest.kernels.one_foot_nb import newton_foot, write_certified

FLAGGED = 1
"""Flag of rows that are left to the CPU."""


@kernel()
def track_row(tables, motion, results, k):
    """Track row k from its foot in `results` (FlaggedFeet), which the new foot replaces.

    `motion` is a `PointMotion`. results.back[k] becomes FLAGGED, and the foot stays, if no new foot
    is found here or its neighbourhood does not prove it; else 0.
    """
    before, points = motion.before, motion.now
    out, back = results.feet, results.back
    back[k] = FLAGGED
    patch = out.patch[k]
    a = (before[k, 0], before[k, 1], before[k, 2])
    b = (points[k, 0], points[k, 1], points[k, 2])
    if patch < 0 or not math.isfinite(a[0] + a[1] + a[2] + b[0] + b[1] + b[2]):
        return
    start = (out.uv[k, 0], out.uv[k, 1])
    e = locate(tables.grid, patch, start[0], start[1])[0]
    # Trims are left to the certificate: it clears all of a neighbourhood.
    e, _, uv, record = newton_foot(tables, e, start, b)
    if e < 0:
        return
    relative_motion = motion_from(record.point, record.normal, a, b, tables.scale[1])
    if not certified_ball(tables, (patch, patch), uv, start, relative_motion) > 0.0:
        return
    back[k] = 0
    write_certified(out, k, patch, uv, record)


@kernel()
def pack_flags(back, packed, i):
    """Write which of eight rows are flagged in `back` to byte i of `packed`.

    The flag of the first row is its lowest bit.
    """
    byte = 0
    for bit in range(min(8, len(back) - 8 * i)):
        if back[8 * i + bit] != 0:
            byte |= 1 << bit
    packed[i] = byte


@kernel()
def gather_row(start, rows, to, i):
    """Copy row rows[i] of `start` to row i of `to`, both `RowStarts`."""
    k = rows[i]
    to.patch[i] = start.patch[k]
    for c in range(2):
        to.uv[i, c] = start.uv[k, c]
    for c in range(3):
        to.before[i, c] = start.before[k, c]
        to.now[i, c] = start.now[k, c]


@kernel()
def scatter_row(feet, rows, out, i):
    """Copy row i of the projection `feet` to row rows[i] of `out`."""
    k = rows[i]
    out.patch[k] = feet.patch[i]
    for c in range(2):
        out.uv[k, c] = feet.uv[i, c]
    for c in range(3):
        out.point[k, c] = feet.point[i, c]
        out.normal[k, c] = feet.normal[i, c]
    out.gap[k] = feet.gap[i]
    out.feature[k] = feet.feature[i]
    out.status[k] = feet.status[i]
    out.certified[k] = feet.certified[i]
