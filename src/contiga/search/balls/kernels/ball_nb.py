"""Radii of touching balls at feet, looked up in the cells of the elements."""

from __future__ import annotations

from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel


@inner()
def radius_at(balls, grid, patch, u, v, side):
    """Return the proved radius, length, of the ball that touches at (u, v); zero for none.

    `side` is 0 for the inner, 1 for the outer ball. Corner values of the smallest cell are
    interpolated.
    """
    e, s, t = locate(grid, patch, u, v)
    row = balls.elements[e]
    x = (s + 0.5) * row["cells"][0]
    y = (t + 0.5) * row["cells"][1]
    i = min(int(x), row["cells"][0] - 1)
    j = min(int(y), row["cells"][1] - 1)
    node = row["first"] + i * row["stride"] + j
    x -= i
    y -= j
    child = balls.child[node]
    while child >= 0:
        node = child >> 1
        if child & 1 == 0:
            x *= 2.0
            if x >= 1.0:
                x -= 1.0
                node += 1
        else:
            y *= 2.0
            if y >= 1.0:
                y -= 1.0
                node += 1
        child = balls.child[node]
    c = balls.value[node, side]
    r = (1.0 - x) * ((1.0 - y) * c[0] + y * c[1]) + x * ((1.0 - y) * c[2] + y * c[3])
    return max(r, 0.0)


@kernel()
def radii(balls, grid, feet, rows, sides, out, start, stop):
    """Write the radii (`radius_at`) at the feet rows[start:stop] to out[start:stop].

    `feet` are `SurfacePlaces`; `sides` has one side for each of `rows`. Feet without a patch get
    zero.
    """
    patch, uv = feet.patch, feet.uv
    for i in range(start, stop):
        k = rows[i]
        if patch[k] >= 0:
            out[i] = radius_at(balls, grid, patch[k], uv[k, 0], uv[k, 1], sides[i])
        else:
            out[i] = 0.0
