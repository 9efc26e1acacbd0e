"""Collect depths, normals, paths and rates of the points in contact: one pass over them."""

from __future__ import annotations

import math

from contiga.jit import inner, kernel


@inner()
def displacement(now, before, k, c):
    """Return the displacement of point k along axis c; zero if a coordinate is not finite."""
    value = now[k, c] - before[k, c]
    return value if math.isfinite(value) else 0.0


@inner()
def row_position(rows, k, j):
    """Return the position of row k in ascending `rows`, or where it would be, searched from j on.

    For ascending rows each search continues from the last result.
    """
    while j < rows.shape[0] and rows[j] < k:
        j += 1
    return j


@kernel(error_model="numpy")
def gather(feet, now, last, dt, out):
    """Fill the columns of `ContactRows` for the points that they list.

    `feet` are the feet and `now` (n, 3) the positions of all points; `last` are `LastDepths`.
    Depths are zero in front of the surface. Without given velocities the rate is the change over
    the step `dt` for old contacts, and the speed of approach for new ones.
    """
    place, last_rows, velocity = 0, last.rows, out.velocity
    for i in range(out.rows.shape[0]):
        k = out.rows[i]
        below = -feet.gap[k]
        out.depth[i] = 0.0 if below <= 0.0 else below
        out.old[i] = last.patch[k] >= 0
        out.switched[i] = last.patch[k] != feet.patch[k] or last.feature[k] != feet.feature[k]
        speed = approach = 0.0
        for c in range(3):
            out.normal[i, c] = feet.normal[k, c]
            out.foot[i, c] = feet.point[k, c]
            out.path[i, c] = displacement(now, last.points, k, c)
            approach += out.path[i, c] * out.normal[i, c]
            if velocity.shape[0] > 0:
                speed += velocity[i, c] * out.normal[i, c]
        inside = 1.0
        if not out.old[i]:
            inside = min(out.depth[i], -approach) / -approach if approach < 0.0 else 0.0
        out.inside[i] = inside
        place = row_position(last_rows, k, place)
        was_listed = place < last_rows.shape[0] and last_rows[place] == k
        if velocity.shape[0] > 0:
            out.rate[i] = -speed
        elif out.old[i]:
            out.rate[i] = (out.depth[i] - (last.depth[place] if was_listed else 0.0)) / dt
        else:
            out.rate[i] = -approach / dt
