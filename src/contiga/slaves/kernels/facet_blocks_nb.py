"""Sparse matrices of 3 × 3 blocks between the nodes, for quadrature points."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def mark(block_rows, faces, used):
    """Set `used` (m,) to 1 for the blocks between all pairs of corners of `faces` (r,).

    `block_rows` (f, c, c) has the row in `used` of each pair of corners of a face.
    """
    count = block_rows.shape[1]
    for i in range(faces.shape[0]):
        for a in range(count):
            for b in range(count):
                used[block_rows[faces[i], a, b]] = 1


@kernel()
def add(blocks, faces, points, shape, block_rows, out):
    """Add N_a N_b K of each of the `blocks` K (r, 3, 3) to `out` (m, 3, 3), for all corners a, b.

    Block i belongs to point `points[i]` of the rule on face `faces[i]`, with shape functions N
    (n, c); `block_rows` (f, c, c) has the row in `out` of each pair of corners. The order of sums
    is fixed.
    """
    count = shape.shape[1]
    for i in range(faces.shape[0]):
        f, k = faces[i], points[i]
        for a in range(count):
            for b in range(count):
                weight, row = shape[k, a] * shape[k, b], block_rows[f, a, b]
                for c in range(3):
                    out[row, c, 0] += weight * blocks[i, c, 0]
                    out[row, c, 1] += weight * blocks[i, c, 1]
                    out[row, c, 2] += weight * blocks[i, c, 2]
