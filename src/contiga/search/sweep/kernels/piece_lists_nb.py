"""Pieces of a surface near every voxel of a grid, and a test that a short path is clear of them.

Pieces are those of `side_pieces_nb`: boxes and slabs that contain the surface with its widened
edges. A path that is clear of the pieces near its voxels crosses nothing.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.search.sides.kernels.side_pieces_nb import HIGH, LOW, NORMAL, SLAB_HIGH, SLAB_LOW

MAX_VOXELS = 8
"""Number of voxels of a path above which its pieces are not examined."""
MAX_PIECES = 64
"""Number of pieces of a voxel above which they are not examined."""


@inner()
def _span(piece, side, voxels, c):
    """Return the first voxel along axis c that a piece's box meets, and one past the last voxel."""
    first = math.floor(piece[LOW + c] / side)
    last = math.floor(piece[HIGH + c] / side)
    return int(max(first, 0.0)), int(min(last, voxels[c] - 1.0)) + 1


@kernel()
def list_pieces(pieces, side, voxels, first, listed):
    """Count the pieces that may meet each voxel v in first[v + 1], or list them in `listed`.

    They are listed, not counted, if `listed` has rows. Then first[v] is the row at which the pieces
    of voxel v begin, and becomes the row past their end. `side` is the length of a voxel; the grid
    begins at the origin of the pieces.
    """
    listing = listed.shape[0] > 0
    half = 0.5 * side
    for p in range(pieces.shape[0]):
        piece = pieces[p]
        i0, i1 = _span(piece, side, voxels, 0)
        j0, j1 = _span(piece, side, voxels, 1)
        k0, k1 = _span(piece, side, voxels, 2)
        for i in range(i0, i1):
            for j in range(j0, j1):
                for k in range(k0, k1):
                    height = spread = 0.0
                    for c in range(3):
                        n = piece[NORMAL + c]
                        height += n * ((i, j, k)[c] * side + half)
                        spread += abs(n) * half
                    low, high = height - spread, height + spread
                    if not (low <= piece[SLAB_HIGH] and high >= piece[SLAB_LOW]):
                        continue  # the slab of the piece misses the voxel
                    v = (i * voxels[1] + j) * voxels[2] + k
                    if listing:
                        listed[first[v]] = p
                        first[v] += 1
                    else:
                        first[v + 1] += 1


@inner()
def _misses_piece(piece, a, b, spare):
    """Return whether a segment from a to b certainly misses the box or the slab of a piece.

    Both are widened by `spare`, and compared with the segment's own box and range of heights. False
    does not mean that it meets the piece.
    """
    for c in range(3):
        if min(a[c], b[c]) - spare > piece[HIGH + c] or max(a[c], b[c]) + spare < piece[LOW + c]:
            return True
    at_a = at_b = 0.0
    for c in range(3):
        at_a += piece[NORMAL + c] * a[c]
        at_b += piece[NORMAL + c] * b[c]
    low, high = min(at_a, at_b) - spare, max(at_a, at_b) + spare
    return low > piece[SLAB_HIGH] or high < piece[SLAB_LOW]


@inner()
def is_clear(lists, p, q, spare):
    """Return whether the path p → q is known to cross nothing, to `spare` beyond its ends.

    False if that is unknown: the path passes more than `MAX_VOXELS` voxels or leaves the grid, a
    voxel has more than `MAX_PIECES` pieces, the path may meet a piece or is not finite, or there
    are no lists.
    """
    if not spare <= lists.reach:
        return False
    o = lists.origin
    a = (p[0] - o[0], p[1] - o[1], p[2] - o[2])
    b = (q[0] - o[0], q[1] - o[1], q[2] - o[2])
    n = lists.voxels
    scale = lists.scale
    x0 = (min(a[0], b[0]) - spare) * scale
    y0 = (min(a[1], b[1]) - spare) * scale
    z0 = (min(a[2], b[2]) - spare) * scale
    x1 = (max(a[0], b[0]) + spare) * scale
    y1 = (max(a[1], b[1]) + spare) * scale
    z1 = (max(a[2], b[2]) + spare) * scale
    # Outside the grid, and for a path that is not finite, nothing is known.
    if not (x0 >= 0.0 and y0 >= 0.0 and z0 >= 0.0 and x1 < n[0] and y1 < n[1] and z1 < n[2]):
        return False
    i0, j0, k0 = int(x0), int(y0), int(z0)
    i1, j1, k1 = int(x1) + 1, int(y1) + 1, int(z1) + 1
    if (i1 - i0) * (j1 - j0) * (k1 - k0) > MAX_VOXELS:
        return False
    for i in range(i0, i1):
        for j in range(j0, j1):
            for k in range(k0, k1):
                v = (i * n[1] + j) * n[2] + k
                begin, end = lists.first[v], lists.first[v + 1]
                if end - begin > MAX_PIECES:
                    return False
                for m in range(begin, end):
                    if not _misses_piece(lists.pieces[lists.listed[m]], a, b, spare):
                        return False
    return True
