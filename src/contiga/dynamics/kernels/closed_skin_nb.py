"""The volume that facets close, and what is asked of it in every step.

V = ⅙ Σ x₀·(x₁ × x₂). A node moves the volume by a sixth of the area vectors 2 A n of its facets,
as their other sides close a ring. Facets in blocks of lanes, then sums at nodes in a fixed order:
the same bits on any number of threads.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.matter.kernels.lanes_nb import LANES, gather, total

NORMAL, AREA, SIDES = 0, 3, 4
MEASURES = 5
"""Rows of a block: a sixth of 2 A n, A, and a sixth of the length of all sides."""
VOLUME = 9
"""Row of a bank behind the three corners."""
SIZE = (VOLUME + 1) * LANES


@inner(linked=False)
def _measure(bank, x, y, z, out):
    """Measure the facets of a block; volumes are those of tetrahedra with the point (x, y, z)."""
    normals, areas, sides = out[NORMAL:AREA], out[AREA], out[SIDES]
    for lane in range(LANES):
        ax, ay, az = bank[lane], bank[LANES + lane], bank[2 * LANES + lane]
        bx = bank[3 * LANES + lane] - ax
        by = bank[4 * LANES + lane] - ay
        bz = bank[5 * LANES + lane] - az
        cx = bank[6 * LANES + lane] - ax
        cy = bank[7 * LANES + lane] - ay
        cz = bank[8 * LANES + lane] - az
        nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        normals[0, lane], normals[1, lane], normals[2, lane] = nx / 6.0, ny / 6.0, nz / 6.0
        areas[lane] = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)
        dx, dy, dz = cx - bx, cy - by, cz - bz
        length = math.sqrt(bx * bx + by * by + bz * bz)
        length += math.sqrt(cx * cx + cy * cy + cz * cz)
        length += math.sqrt(dx * dx + dy * dy + dz * dz)
        sides[lane] = length / 6.0
        volume = ((ax - x) * nx + (ay - y) * ny + (az - z) * nz) / 6.0
        bank[VOLUME * LANES + lane] = volume


@kernel()
def measure_facets(points, corners, out, volumes, start, stop):
    """Measure blocks start … stop of facets with `corners` (b, 3, LANES), rows of the points.

    Fills `out` (b, MEASURES, LANES), and `volumes` (b,) of tetrahedra that all have one corner in
    common: the first node, so that all is counted from near.
    """
    bank = scratch(SIZE)
    first = corners[0, 0, 0]
    x, y, z = points[first, 0], points[first, 1], points[first, 2]
    for b in range(start, stop):
        gather(points, corners[b], 3, bank)
        _measure(bank, x, y, z, out[b])
        volumes[b] = total(bank, VOLUME)


@kernel()
def sum_at_nodes(measures, starts, places, gradient, stiffness, start, stop):
    """Sum what facets have at nodes start … stop: ∂V/∂x (k, 3), and bounds (k,) of the row sums of
    ∂²V/∂x². The facets of node n are at `places` starts[n] … starts[n + 1] of the measures."""
    flat = measures.reshape(-1)
    for n in range(start, stop):
        x, y, z, sides = 0.0, 0.0, 0.0, 0.0
        for m in range(starts[n], starts[n + 1]):
            at = places[m]
            x += flat[at]
            y += flat[at + LANES]
            z += flat[at + 2 * LANES]
            sides += flat[at + SIDES * LANES]
        gradient[n, 0] = x
        gradient[n, 1] = y
        gradient[n, 2] = z
        stiffness[n] = sides
