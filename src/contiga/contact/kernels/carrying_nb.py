"""Collect what is known of the points in contact before forces: one pass over them."""

from __future__ import annotations

import math

from contiga.jit import inner, kernel


@inner()
def way_of(now, before, k, c):
    """Return the displacement of point k along axis c; zero if a coordinate is not finite."""
    way = now[k, c] - before[k, c]
    return way if math.isfinite(way) else 0.0


@inner()
def at(rows, k, j):
    """Return where row k stands in ascending `rows`, or would, searched from place j on.

    Asked of ascending rows one after the other, each going on from the last answer.
    """
    while j < rows.shape[0] and rows[j] < k:
        j += 1
    return j


@kernel(error_model="numpy")
def gather(feet, now, last, dt, out):
    """Fill the columns of `ContactRows` for the points that they list.

    `feet` are those of all points, which are `now` (n, 3). `last` is what was at the last step,
    `LastDepths`. Where velocities are not known the rate is the change over the step `dt` of old
    contacts, and of new ones the speed of approach.
    """
    place, deep, velocity = 0, last.rows, out.velocity
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
            out.path[i, c] = way_of(now, last.points, k, c)
            approach += out.path[i, c] * out.normal[i, c]
            if velocity.shape[0] > 0:
                speed += velocity[i, c] * out.normal[i, c]
        inside = 1.0
        if not out.old[i]:
            inside = min(out.depth[i], -approach) / -approach if approach < 0.0 else 0.0
        out.inside[i] = inside
        place = at(deep, k, place)
        there = place < deep.shape[0] and deep[place] == k
        if velocity.shape[0] > 0:
            out.rate[i] = -speed
        elif out.old[i]:
            out.rate[i] = (out.depth[i] - (last.depth[place] if there else 0.0)) / dt
        else:
            out.rate[i] = -approach / dt
