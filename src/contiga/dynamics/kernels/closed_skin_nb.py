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

NORMAL, SIDES, AREA, VOLUME = 9, 12, 13, 14
"""Rows of a bank behind the three corners: a sixth of 2 A n, a sixth of the length of all sides, A,
and the volume of a tetrahedron on the facet."""
SIZE = (VOLUME + 1) * LANES
SIXTH = 1.0 / 6.0
"""To multiply by: divisions take half of the time of a block."""
AT_NODES = 4
"""What is summed at nodes: three numbers of NORMAL, and SIDES."""


@inner(linked=False)
def _measure(bank, x, y, z):
    """Measure the facets of a block, with tetrahedra to the point (x, y, z)."""
    for lane in range(LANES):
        ax, ay, az = bank[lane], bank[LANES + lane], bank[2 * LANES + lane]
        bx = bank[3 * LANES + lane] - ax
        by = bank[4 * LANES + lane] - ay
        bz = bank[5 * LANES + lane] - az
        cx = bank[6 * LANES + lane] - ax
        cy = bank[7 * LANES + lane] - ay
        cz = bank[8 * LANES + lane] - az
        nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        bank[NORMAL * LANES + lane] = SIXTH * nx
        bank[(NORMAL + 1) * LANES + lane] = SIXTH * ny
        bank[(NORMAL + 2) * LANES + lane] = SIXTH * nz
        bank[AREA * LANES + lane] = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)
        dx, dy, dz = cx - bx, cy - by, cz - bz
        length = math.sqrt(bx * bx + by * by + bz * bz)
        length += math.sqrt(cx * cx + cy * cy + cz * cz)
        length += math.sqrt(dx * dx + dy * dy + dz * dz)
        bank[SIDES * LANES + lane] = SIXTH * length
        volume = (ax - x) * nx + (ay - y) * ny + (az - z) * nz
        bank[VOLUME * LANES + lane] = SIXTH * volume


@inner()
def _put(bank, facets, areas):
    """Write what nodes sum facet by facet, and areas."""
    for lane in range(LANES):
        for k in range(AT_NODES):
            facets[lane, k] = bank[(NORMAL + k) * LANES + lane]
        areas[lane] = bank[AREA * LANES + lane]


@kernel()
def measure_facets(points, corners, facets, areas, volumes, start, stop):
    """Measure blocks start … stop of facets with `corners` (b, 3, LANES), rows of the points.

    Fills `facets` (b, LANES, AT_NODES), `areas` (b, LANES), and `volumes` (b,) of tetrahedra that
    all have one corner in common: the first node, so that all is counted from near.
    """
    bank = scratch(SIZE)
    first = corners[0, 0, 0]
    x, y, z = points[first, 0], points[first, 1], points[first, 2]
    for b in range(start, stop):
        gather(points, corners[b], 3, bank)
        _measure(bank, x, y, z)
        _put(bank, facets[b], areas[b])
        volumes[b] = total(bank, VOLUME)


@kernel()
def sum_at_nodes(facets, starts, rows, gradient, stiffness, start, stop):
    """Sum what `facets` (f, AT_NODES) have at nodes start … stop: ∂V/∂x (k, 3), and bounds (k,) of
    the row sums of ∂²V/∂x². The facets of node n are `rows` starts[n] … starts[n + 1]."""
    for n in range(start, stop):
        x, y, z, sides = 0.0, 0.0, 0.0, 0.0
        for m in range(starts[n], starts[n + 1]):
            f = rows[m]
            x += facets[f, 0]
            y += facets[f, 1]
            z += facets[f, 2]
            sides += facets[f, 3]
        gradient[n, 0] = x
        gradient[n, 1] = y
        gradient[n, 2] = z
        stiffness[n] = sides
