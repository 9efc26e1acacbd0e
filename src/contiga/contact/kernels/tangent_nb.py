"""Derivatives of the forces on points, one 3 × 3 block each."""

from __future__ import annotations

from contiga.jit import kernel
from contiga.jit.scratch import scratch


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


@kernel()
def to_world(blocks, pose, start, stop):
    """Turn the blocks start … stop (k, 3, 3) to R K Rᵀ, for a (4, 4) pose."""
    half = scratch(3, 3)
    for i in range(start, stop):
        for a in range(3):
            for b in range(3):
                half[a, b] = (
                    blocks[i, a, 0] * pose[b, 0]
                    + blocks[i, a, 1] * pose[b, 1]
                    + blocks[i, a, 2] * pose[b, 2]
                )
        for a in range(3):
            for b in range(3):
                blocks[i, a, b] = (
                    pose[a, 0] * half[0, b] + pose[a, 1] * half[1, b] + pose[a, 2] * half[2, b]
                )
