"""Find points that may reach the surface on curved paths: two passes over all points."""

from __future__ import annotations

import math

from contiga.arrays.kernels.vector_nb import cross
from contiga.jit import inner, kernel


@inner(error_model="numpy")
def _path_length(before, now, k):
    """Return the path length of point k; infinite or NaN if a coordinate is not finite."""
    x, y, z = now[k, 0] - before[k, 0], now[k, 1] - before[k, 1], now[k, 2] - before[k, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel(error_model="numpy")
def largest_paths(path, largest, size, start, stop):
    """Fill rows start … stop of `largest` (chunks, 2), for chunks of `size` points of `path`.

    The columns are the largest finite path length, and the largest coordinate of these points
    before or now. `path` is a `Motion`.
    """
    for c in range(start, stop):
        chunk = slice(c * size, (c + 1) * size)
        before, now = path.before[chunk], path.now[chunk]
        max_length = x = y = z = 0.0
        for k in range(now.shape[0]):
            length = _path_length(before, now, k)
            if length < math.inf:
                max_length = max(max_length, length)
                x = max(x, abs(before[k, 0]), abs(now[k, 0]))
                y = max(y, abs(before[k, 1]), abs(now[k, 1]))
                z = max(z, abs(before[k, 2]), abs(now[k, 2]))
        largest[c, 0] = max_length
        largest[c, 1] = max(x, y, z)


@kernel(error_model="numpy")
def list_within_reach(path, last, bulge, lists, size, start, stop):
    """List the points that may reach the surface if their paths bulge by `bulge`.

    `path` is a `Motion`, `last` are `LastPlaces`, `lists` the `ChunkLists` of chunks of `size`
    points, filled for chunks start … stop. Free points that do not take part, and points that are
    not finite, are not listed.
    """
    patch, distance, active = last.patch, last.safe_distance, last.active
    rows, counts = lists.rows, lists.counts
    for c in range(start, stop):
        n = first = c * size
        for k in range(first, min(first + size, patch.shape[0])):
            touching = patch[k] >= 0
            if not touching and not active[k]:
                continue
            length = _path_length(path.before, path.now, k)
            clearance = 0.0 if touching else abs(distance[k])
            if length < math.inf and clearance <= length + bulge:
                rows[n] = k
                n += 1
        counts[c] = n - first


@inner(error_model="numpy")
def _length(a):
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@inner(error_model="numpy")
def _acceleration_bound(turn, velocity, p):
    """Return |ω × ξ(p)| of the screw with this turn ω and the velocity of its origin."""
    c = cross(turn, p)
    field = (velocity[0] + c[0], velocity[1] + c[1], velocity[2] + c[2])
    return _length(cross(turn, field))


@kernel(error_model="numpy")
def bulges(turn, velocity, start, end, bulge):
    """Fill `bulge` (n,) with bounds of the distances of paths from their chords: see `bulge_of`."""
    w, v = (turn[0], turn[1], turn[2]), (velocity[0], velocity[1], velocity[2])
    for k in range(start.shape[0]):
        a = (start[k, 0], start[k, 1], start[k, 2])
        b = (end[k, 0], end[k, 1], end[k, 2])
        displacement = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
        bound = max(_acceleration_bound(w, v, a), _acceleration_bound(w, v, b))
        bulge[k] = 0.125 * (bound + 2.0 * _length(cross(w, displacement)))
