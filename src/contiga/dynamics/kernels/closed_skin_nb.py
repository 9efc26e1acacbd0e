"""The volume that facets enclose, with its gradient and bounds of its second derivatives.

V = ⅙ Σ x₀·(x₁ × x₂). The gradient at a node is a sixth of the sum of the area vectors 2 A n of its
facets. Facets are measured in blocks of lanes and summed at nodes in a fixed order, which gives the
same bits on any number of threads.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.matter.kernels.lanes_nb import LANES, gather, total

NORMAL, SIDES, AREA, VOLUME = 9, 12, 13, 14
"""First rows of a bank after the three corners: 2 A n/6, a sixth of the perimeter, A, and the
volume of a tetrahedron on the facet."""
SIZE = (VOLUME + 1) * LANES
SIXTH = 1.0 / 6.0
"""Factor in place of divisions, which would take half of the time of a block."""
AT_NODES = 4
"""Numbers of a facet that are summed at nodes: the three of NORMAL, and SIDES."""


@inner(linked=False)
def _measure(bank, x, y, z):
    """Write the measures of a block's facets into its bank, with tetrahedra to (x, y, z).

    They are the rows NORMAL, SIDES, AREA and VOLUME; volumes are negative where the facet faces
    (x, y, z). The first nine rows of the bank are the coordinates of the three corners.
    """
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


@kernel()
def measure_facets(points, corners, facets, areas, volumes, start, stop):
    """Measure blocks start … stop of facets with `corners` (b, 3, LANES), rows of the points.

    Fills `facets` (b, LANES, AT_NODES), `areas` (b, LANES) and `volumes` (b,), the volumes of
    tetrahedra that share the first node as a corner, which keeps rounding errors small.
    """
    bank = scratch(SIZE)
    first = corners[0, 0, 0]
    x, y, z = points[first, 0], points[first, 1], points[first, 2]
    for b in range(start, stop):
        gather(points, corners[b], 3, bank)
        _measure(bank, x, y, z)
        for lane in range(LANES):
            for k in range(AT_NODES):
                facets[b, lane, k] = bank[(NORMAL + k) * LANES + lane]
            areas[b, lane] = bank[AREA * LANES + lane]
        volumes[b] = total(bank, VOLUME)


@kernel()
def sum_at_nodes(facets, starts, rows, gradient, stiffness, start, stop):
    """Sum `facets` (f, AT_NODES) at nodes start … stop, and write the sums.

    They are the `gradient` ∂V/∂x (k, 3), and the `stiffness` (k,), bounds of the row sums of
    ∂²V/∂x². The facets of node n are `rows` starts[n] … starts[n + 1].
    """
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
