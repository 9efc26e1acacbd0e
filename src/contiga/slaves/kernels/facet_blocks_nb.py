"""Sparse matrices of 3 × 3 blocks: of points that are nodes, and of points between these."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def mark(places, faces, used):
    """Mark the blocks between corners of `faces` (r,) in `used` (blocks,); `places` (f, c, c) says
    which."""
    count = places.shape[1]
    for i in range(faces.shape[0]):
        for a in range(count):
            for b in range(count):
                used[places[faces[i], a, b]] = 1


@kernel()
def add(blocks, faces, points, shape, places, out):
    """Add N_a N_b K of each block K (r, 3, 3) to the blocks (m, 3, 3) between corners a and b.

    It belongs to the point `points` (r,) of the rule on the face `faces` (r,), of shape functions N
    (n, c); `places` (f, c, c) says which block is which. In this order, one after the other.
    """
    count = shape.shape[1]
    for i in range(faces.shape[0]):
        f, k = faces[i], points[i]
        for a in range(count):
            for b in range(count):
                weight, place = shape[k, a] * shape[k, b], places[f, a, b]
                for c in range(3):
                    out[place, c, 0] += weight * blocks[i, c, 0]
                    out[place, c, 1] += weight * blocks[i, c, 1]
                    out[place, c, 2] += weight * blocks[i, c, 2]
