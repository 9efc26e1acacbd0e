"""Find points that may come to the surface on paths that bulge: two passes over all of them."""

from __future__ import annotations

import math

from contiga.arrays.kernels.vector_nb import cross
from contiga.jit import inner, kernel


@inner(error_model="numpy")
def _way(before, now, k):
    """Return the distance that point k has moved; infinite or NaN if a coordinate is not finite."""
    x, y, z = now[k, 0] - before[k, 0], now[k, 1] - before[k, 1], now[k, 2] - before[k, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel(error_model="numpy")
def farthest(path, most, size, start, stop):
    """Fill rows start … stop of `most` (chunks, 2), of as many chunks of `size` points of `path`.

    Of points whose ways are finite: the farthest way, and the largest coordinate before or now.
    `path` is a `Motion`.
    """
    for c in range(start, stop):
        chunk = slice(c * size, (c + 1) * size)
        before, now = path.before[chunk], path.now[chunk]
        far = x = y = z = 0.0
        for k in range(now.shape[0]):
            way = _way(before, now, k)
            if way < math.inf:
                far = max(far, way)
                x = max(x, abs(before[k, 0]), abs(now[k, 0]))
                y = max(y, abs(before[k, 1]), abs(now[k, 1]))
                z = max(z, abs(before[k, 2]), abs(now[k, 2]))
        most[c, 0] = far
        most[c, 1] = max(x, y, z)


@kernel(error_model="numpy")
def within_reach(path, known, bulge, lists, size, start, stop):
    """List the points that come to the surface if their paths bulge by so much.

    `path` is a `Motion`, `known` are `LastPlaces`, and `lists` the `ChunkLists` of chunks of `size`
    points, to be filled.
    """
    patch, distance, active = known.patch, known.safe_distance, known.active
    rows, counts = lists.rows, lists.counts
    for c in range(start, stop):
        n = first = c * size
        for k in range(first, min(first + size, patch.shape[0])):
            touching = patch[k] >= 0
            if not touching and not active[k]:
                continue
            way = _way(path.before, path.now, k)
            clearance = 0.0 if touching else abs(distance[k])
            if way < math.inf and clearance <= way + bulge:
                rows[n] = k
                n += 1
        counts[c] = n - first


@inner(error_model="numpy")
def _length(a):
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@inner(error_model="numpy")
def _turning(turn, velocity, p):
    """Return |ω × ξ(p)| of the screw with this turn ω and the velocity of its origin."""
    c = cross(turn, p)
    field = (velocity[0] + c[0], velocity[1] + c[1], velocity[2] + c[2])
    return _length(cross(turn, field))


@kernel(error_model="numpy")
def bulges(turn, velocity, start, end, bulge):
    """Fill `bulge` (n,) with bounds of how far paths from `start` to `end` leave their chords: see
    `contact.curved.bulge_of`."""
    w, v = (turn[0], turn[1], turn[2]), (velocity[0], velocity[1], velocity[2])
    for k in range(start.shape[0]):
        a = (start[k, 0], start[k, 1], start[k, 2])
        b = (end[k, 0], end[k, 1], end[k, 2])
        way = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
        most = max(_turning(w, v, a), _turning(w, v, b))
        bulge[k] = 0.125 * (most + 2.0 * _length(cross(w, way)))
