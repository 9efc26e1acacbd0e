"""Compute the derivatives of the forces on points, one block each."""

from __future__ import annotations

from contiga.jit import kernel
from contiga.jit.scratch import scratch


@kernel(error_model="numpy")
def normal_blocks(points, change, tangent, blocks, start, stop):
    """Fill `blocks` (k, 3, m) from start to stop with the derivatives of F n, body axes.

    They are n (∂F/∂λ dλ + ∂F/∂λ̇ dλ̇) + F dn; the bracket is written into `tangent.force_change`.
    `points` are `ContactRows`, `change` is an `InputChange`, `tangent` is a `_NormalTangent`.
    """
    path, velocity = points.path, points.velocity
    paths, velocities = change.path.shape[0], change.velocity.shape[0]
    for i in range(start, stop):
        slope, rate_slope, force = tangent.slope[i], tangent.rate[i], tangent.force[i]
        for c in range(blocks.shape[2]):
            force_change = slope * change.depth[i, c]
            if rate_slope != 0.0:
                if velocity.shape[0] > 0:
                    for b in range(3):
                        force_change -= rate_slope * velocity[i, b] * change.normal[i, b, c]
                        if velocities > 0:
                            speed = change.velocity[min(i, velocities - 1), b, c]
                            force_change -= rate_slope * points.normal[i, b] * speed
                elif points.old[i]:
                    force_change += rate_slope * change.depth[i, c] / tangent.dt
                else:
                    approach = 0.0
                    for b in range(3):
                        approach += points.normal[i, b] * change.path[min(i, paths - 1), b, c]
                        approach += path[i, b] * change.normal[i, b, c]
                    force_change -= rate_slope * approach / tangent.dt
            tangent.force_change[i, c] = force_change
            for b in range(3):
                blocks[i, b, c] = (
                    points.normal[i, b] * force_change + force * change.normal[i, b, c]
                )


@kernel()
def to_world(blocks, pose, start, stop):
    """Overwrite the blocks K start … stop of (k, 3, 3) with R K Rᵀ, for a (4, 4) pose."""
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
