"""Derivatives of the forces on points, one 3 × 3 block each, and their sparse matrix."""

from __future__ import annotations

from contiga.jit import inner, kernel


@kernel(error_model="numpy")
def normal_blocks(points, slopes, tangent, blocks, start, stop):
    """Fill `blocks` (k, 3, 3) from start to stop with the derivatives of F n, body axes:
    n (∂F/∂λ dλ + ∂F/∂λ̇ dλ̇) + F dn.

    `points` are `ContactRows`, `slopes` are `FootSlopes`, `tangent` is a `NormalTangent`.
    """
    path, velocity = points.path, points.velocity
    for i in range(start, stop):
        own, damped, force = tangent.own[i], tangent.rate[i], tangent.force[i]
        for c in range(3):
            grown = own * slopes.depth[i, c]
            if damped != 0.0:
                if velocity.shape[0] > 0:
                    for b in range(3):
                        grown -= damped * velocity[i, b] * slopes.normal[i, b, c]
                elif points.old[i]:
                    grown += damped * slopes.depth[i, c] / tangent.dt
                else:
                    approach = points.normal[i, c]
                    for b in range(3):
                        approach += path[i, b] * slopes.normal[i, b, c]
                    grown -= damped * approach / tangent.dt
            tangent.grown[i, c] = grown
            for b in range(3):
                blocks[i, b, c] = points.normal[i, b] * grown + force * slopes.normal[i, b, c]


@inner()
def _turned(pose, block, i, a, b):
    """Entry (a, b) of R K Rᵀ."""
    total = 0.0
    for c in range(3):
        row = (
            block[i, c, 0] * pose[b, 0] + block[i, c, 1] * pose[b, 1] + block[i, c, 2] * pose[b, 2]
        )
        total += pose[a, c] * row
    return total


@kernel()
def to_world(blocks, pose, out, start, stop):
    """R K Rᵀ of the blocks start … stop (k, 3, 3), for a (4, 4) pose."""
    for i in range(start, stop):
        for a in range(3):
            for b in range(3):
                out[i, a, b] = _turned(pose, blocks, i, a, b)


@kernel()
def block_rows(rows, blocks, data, indices, start, stop):
    """Write blocks start … stop of points `rows`, ascending, as rows of a sparse matrix: `data` and
    `indices` (9 k,), nine numbers a point, row by row."""
    for i in range(start, stop):
        for a in range(3):
            for b in range(3):
                data[9 * i + 3 * a + b] = blocks[i, a, b]
                indices[9 * i + 3 * a + b] = 3 * rows[i] + b
