"""Query a grid of known sides: the side of a point, and whether a path is clear of the surface.

A cell without surface is convex, and no surface is within `skin` of it either. A lower bound of the
distance from a point in it to the surface is the distance to the cell's sides, plus `skin`, plus
the cells to the next one that may contain surface. A path that stays in such cells crosses nothing.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel
from contiga.search.sides.kernels.side_grid_nb import FIRST_WORD, NO_BITS, ONE, SPLIT

MAX_STEPS = 64
"""Number of cells of a path above which it does not count as clear."""


@inner()
def _in_cells(grid, p):
    """Return the coordinates of a point in cells of the grid."""
    o = grid.origin
    return (p[0] - o[0]) / grid.size, (p[1] - o[1]) / grid.size, (p[2] - o[2]) / grid.size


@inner()
def _distance_to_side(x, parts):
    """Return the distance, in cells, from a place to the nearest side of its part of a cell.

    `parts` is the number of parts along a cell.
    """
    distance = 1.0
    for c in range(3):
        y = x[c] * parts
        y -= math.floor(y)
        distance = min(distance, y, 1.0 - y)
    return distance / parts


@inner()
def side_at(grid, x):
    """Return the side of a place x, in units of cells: 1 outside, −1 inside, 0 unknown.

    Also returns a lower bound of the distance to the surface, in cells, without `skin`, zero if the
    side is unknown; the number of parts along the cell, 0 outside the grid; and its word, −1 if it
    has none.
    """
    if not (
        0.0 <= x[0] < grid.cell.shape[0]
        and 0.0 <= x[1] < grid.cell.shape[1]
        and 0.0 <= x[2] < grid.cell.shape[2]
    ):
        square = 0.0
        for c in range(3):
            gap = max(-x[c], x[c] - grid.cell.shape[c], 0.0)
            square += gap * gap
        return grid.outer_side, math.sqrt(square), 0.0, -1
    i, j, k = int(x[0]), int(x[1]), int(x[2])
    value = grid.cell[i, j, k]
    if value < FIRST_WORD:
        if value == 0:
            return 0, 0.0, 1.0, -1
        side = 1 if value > 0 else -1
        return side, abs(value) - 1.0 + _distance_to_side(x, 1.0), 1.0, -1
    word = value - FIRST_WORD
    bit = 16 * int((x[0] - i) * SPLIT) + 4 * int((x[1] - j) * SPLIT) + int((x[2] - k) * SPLIT)
    mask = ONE << np.uint64(bit)
    if grid.masks[word, 0] & mask != NO_BITS:
        return -1, _distance_to_side(x, float(SPLIT)), float(SPLIT), word
    if grid.masks[word, 1] & mask != NO_BITS:
        return 1, _distance_to_side(x, float(SPLIT)), float(SPLIT), word
    return 0, 0.0, float(SPLIT), word


@kernel()
def sides(grid, points, rows, side, reach, start, stop):
    """Write the sides of points[rows[start:stop]] to `side`, and their safe distances to `reach`.

    Row i belongs to rows[i]. A safe distance is a lower bound of the distance from the surface, a
    length. Both are zero where the side is unknown, and for points that are not finite.
    """
    for i in range(start, stop):
        k = rows[i]
        p = (points[k, 0], points[k, 1], points[k, 2])
        side[i] = 0
        reach[i] = 0.0
        if math.isfinite(p[0] + p[1] + p[2]):
            point_side, distance, _, _ = side_at(grid, _in_cells(grid, p))
            side[i] = point_side
            if point_side != 0:
                reach[i] = distance * grid.size + grid.skin


@kernel()
def places(grid, points, rows, out_sides, out_places, start, stop):
    """Write the `sides` of points[rows[start:stop]], and a piece of the surface near each.

    Sides and safe distances go to `out_sides` (Sides), patch and parameters of the pieces to
    `out_places` (SurfacePlaces), row i for rows[i]. Only points of unknown side in cells that may
    contain surface get a piece; the patch of all others is −1.
    """
    side, reach = out_sides.side, out_sides.reach
    patch, uv = out_places.patch, out_places.uv
    sides(grid, points, rows, side, reach, start, stop)
    for i in range(start, stop):
        k = rows[i]
        p = (points[k, 0], points[k, 1], points[k, 2])
        piece = -1
        if side[i] == 0 and math.isfinite(p[0] + p[1] + p[2]):
            word = side_at(grid, _in_cells(grid, p))[3]
            if word >= 0:
                piece = grid.piece[word]
        patch[i] = -1
        uv[i, 0] = uv[i, 1] = 0.0
        if piece >= 0:
            patch[i] = grid.patch[piece]
            uv[i, 0], uv[i, 1] = grid.uv[piece, 0], grid.uv[piece, 1]


@kernel()
def clear_paths(grid, before, now, rows, clear, start, stop):
    """Write whether the paths before[rows] → now[rows] are known to meet no surface to `clear`.

    Row i belongs to rows[i]. False for paths through places of unknown side, of more than
    `MAX_STEPS` cells, or that are not finite.
    """
    skin = grid.skin / grid.size
    for i in range(start, stop):
        k = rows[i]
        clear[i] = False
        a = _in_cells(grid, (before[k, 0], before[k, 1], before[k, 2]))
        b = _in_cells(grid, (now[k, 0], now[k, 1], now[k, 2]))
        d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
        length = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
        if not math.isfinite(length):
            continue
        if length > 0.0:
            d = (d[0] / length, d[1] / length, d[2] / length)
        t = 0.0
        for _ in range(MAX_STEPS):
            x = (a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2])
            side, distance, parts, _ = side_at(grid, x)
            if side == 0:
                break
            # It is clear to the end of the part, and for `skin` beyond it.
            if parts > 0.0:
                exit = math.inf
                for c in range(3):
                    low = math.floor(x[c] * parts) / parts
                    if d[c] > 0.0:
                        exit = min(exit, (low + 1.0 / parts - x[c]) / d[c])
                    elif d[c] < 0.0:
                        exit = min(exit, (low - x[c]) / d[c])
                distance = max(distance, max(exit, 0.0))
            t += distance + 0.5 * skin
            if t >= length:
                clear[i] = True
                break
