"""The volume that facets close, and what is asked of it in every step."""

from __future__ import annotations

import math

from contiga.jit import kernel


@kernel()
def close(points, rows, corners, gradient, stiffness, areas):
    """Return V = ⅙ Σ x₀·(x₁ × x₂) of facets whose corners are `rows[corners]` of the points.

    Adds ∂V/∂x (k, 3) to `gradient` and bounds of the row sums of ∂²V/∂x² (k,) to `stiffness`, both
    of `rows`, and writes the areas (f,) of the facets. Places count from the middle of the rows,
    for the digits: of a closed surface it makes no other difference.
    """
    mx, my, mz = 0.0, 0.0, 0.0
    for i in range(len(rows)):
        mx += points[rows[i], 0]
        my += points[rows[i], 1]
        mz += points[rows[i], 2]
    mx, my, mz = mx / len(rows), my / len(rows), mz / len(rows)
    volume = 0.0
    for f in range(len(corners)):
        i, j, k = corners[f, 0], corners[f, 1], corners[f, 2]
        ax, ay, az = points[rows[i], 0] - mx, points[rows[i], 1] - my, points[rows[i], 2] - mz
        bx, by, bz = points[rows[j], 0] - mx, points[rows[j], 1] - my, points[rows[j], 2] - mz
        cx, cy, cz = points[rows[k], 0] - mx, points[rows[k], 1] - my, points[rows[k], 2] - mz
        # b × c, c × a, a × b: their sum is twice the facet's area vector.
        ux, uy, uz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        vx, vy, vz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
        wx, wy, wz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        volume += (ax * ux + ay * uy + az * uz) / 6.0
        gradient[i, 0] += ux / 6.0
        gradient[i, 1] += uy / 6.0
        gradient[i, 2] += uz / 6.0
        gradient[j, 0] += vx / 6.0
        gradient[j, 1] += vy / 6.0
        gradient[j, 2] += vz / 6.0
        gradient[k, 0] += wx / 6.0
        gradient[k, 1] += wy / 6.0
        gradient[k, 2] += wz / 6.0
        nx, ny, nz = ux + vx + wx, uy + vy + wy, uz + vz + wz
        areas[f] = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)
        sides = math.sqrt((cx - bx) ** 2 + (cy - by) ** 2 + (cz - bz) ** 2)
        sides += math.sqrt((ax - cx) ** 2 + (ay - cy) ** 2 + (az - cz) ** 2)
        sides += math.sqrt((bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)
        stiffness[i] += sides / 6.0
        stiffness[j] += sides / 6.0
        stiffness[k] += sides / 6.0
    return volume
