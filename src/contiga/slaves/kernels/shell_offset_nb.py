"""Points off the mid-surface of a shell, along the normals of its facets."""

from __future__ import annotations

from math import sqrt

from contiga.jit import inlined, kernel


@inlined()
def _area_normal(nodal, facets, f):
    """(x₁ − x₀) × (x₂ − x₀) of facet f: twice its area along its normal."""
    a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
    x1, x2 = nodal[b, 0] - nodal[a, 0], nodal[c, 0] - nodal[a, 0]
    y1, y2 = nodal[b, 1] - nodal[a, 1], nodal[c, 1] - nodal[a, 1]
    z1, z2 = nodal[b, 2] - nodal[a, 2], nodal[c, 2] - nodal[a, 2]
    return y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2


@inlined()
def _move(out, row, normal, way):
    """Move point `row` of `out` by `way` along `normal`; where that is zero, it stays."""
    square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]
    if square > 0.0:
        part = way / sqrt(square)
        for axis in range(3):
            out[row, axis] += part * normal[axis]


@kernel()
def move_facet_points(nodal, facets, offset, out, start, stop):
    """Move points f n + k of `out` by offset[f n + k] along the normal of their facet f, of the
    facets start … stop with n points each."""
    count = len(offset) // len(facets)
    for f in range(start, stop):
        normal = _area_normal(nodal, facets, f)
        for row in range(f * count, (f + 1) * count):
            _move(out, row, normal, offset[row])


@kernel()
def move_nodes(nodal, facets, offset, total, out):
    """Move rows of `out` by offset[row] along the mean normal of the facets around each node,
    weighed by area; `total` (n, 3) is for the sums."""
    total[:] = 0.0
    for f in range(len(facets)):
        normal = _area_normal(nodal, facets, f)
        for corner in range(3):
            for axis in range(3):
                total[facets[f, corner], axis] += normal[axis]
    for row in range(len(offset)):
        _move(out, row, (total[row, 0], total[row, 1], total[row, 2]), offset[row])
