"""Light on the pixels of a z-buffer, in one pass: array operations take ten times as long."""

from __future__ import annotations

import math

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import inner, kernel


@kernel()
def add_bends(depth, step, size, total):
    """Add to `total` (h, w) the depths of every other pixel of `depth` behind its neighbours.

    Neighbours are `step` of these pixels away, in four opposite pairs, each difference clipped to
    ±`size`. A
    pair adds 0 if a depth of it is infinite, or it is beyond the border.
    """
    height, width = total.shape
    for direction in range(4):
        rows = 0 if direction == 0 else step
        columns = (step, 0, step, -step)[direction]
        margin = abs(columns)
        for row in range(rows, height - rows):
            for column in range(margin, width - margin):
                z = depth[2 * row, 2 * column]
                z_a = depth[2 * (row + rows), 2 * (column + columns)]
                z_b = depth[2 * (row - rows), 2 * (column - columns)]
                if z_b < math.inf and z_a < math.inf:
                    step_b = min(max(z - z_b, -size), size)
                    total[row, column] += step_b + min(max(z - z_a, -size), size)


@inner()
def normal_at(buffer, corners, axes, row, column):
    """Return the unit normal at a covered pixel in camera `axes` (3, 3), turned to the eye.

    It is returned as three numbers: right, down, and away from the eye. It is interpolated from
    the normals at `corners` of facets (m, 3, 3), zero if these cancel; without facets (m = 0) it is
    that of a ball.
    """
    a, b = buffer.a[row, column], buffer.b[row, column]
    if corners.shape[0] == 0:
        return a, b, -math.sqrt(max(1.0 - a * a - b * b, 0.0))
    t, c = buffer.owner[row, column], 1.0 - a - b
    x = a * corners[t, 0, 0] + b * corners[t, 1, 0] + c * corners[t, 2, 0]
    y = a * corners[t, 0, 1] + b * corners[t, 1, 1] + c * corners[t, 2, 1]
    z = a * corners[t, 0, 2] + b * corners[t, 1, 2] + c * corners[t, 2, 2]
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    away = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
    scale = -1.0 / length if away > 0.0 else 1.0 / length
    right = scale * (axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z)
    down = scale * (axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z)
    return right, down, scale * away


@kernel()
def paint(buffer, corners, eye, hollow, nearest, colours, opacity, picture):
    """Blend a layer over `picture` (h, w, 3) where it is not behind `nearest` (h, w).

    `corners` are those of `normal_at`; positive entries of `hollow` (⌈h/2⌉, ⌈w/2⌉) darken.
    `colours` (k, 3) belong to the pixels that it covers in turn, or (1, 3) to all. `eye` (5, 3) has
    the axes of the camera, and in these the directions to the main light and half-way between it
    and the eye.
    """
    height, width = nearest.shape
    k_colour, stride = 0, 0 if colours.shape[0] == 1 else 1
    for row in range(height):
        for column in range(width):
            if buffer.owner[row, column] < 0:
                continue
            colour, k_colour = colours[k_colour], k_colour + stride
            if buffer.depth[row, column] > nearest[row, column]:
                continue
            x, y, z = normal_at(buffer, corners, eye, row, column)
            diffuse = max(0.0, x * eye[3, 0] + y * eye[3, 1] + z * eye[3, 2])
            gloss = max(0.0, x * eye[4, 0] + y * eye[4, 1] + z * eye[4, 2])
            sky = 0.5 - 0.5 * y
            bend = hollow[row // 2, column // 2]
            shade = 1.0 - 0.75 * max(bend, 0.0)  # brighter ridges would blur sharp edges
            away = 1.0 - min(max(-z, 0.0), 1.0)
            factor = (0.46 + 0.24 * sky + 0.46 * diffuse) * shade
            added = 0.10 * gloss**40 + 0.18 * away**3
            for k in range(3):
                light = min(max(colour[k] * factor + added, 0.0), 1.0)
                background = picture[row, column, k]
                picture[row, column, k] = opacity * light + (1.0 - opacity) * background


@kernel()
def veil(buffer, corners, axes, colour, picture):
    """Blend `colour` (3,) into `picture` (h, w, 3) at a layer: 5 % face-on, 43 % edge-on."""
    height, width, _ = picture.shape
    for row in range(height):
        for column in range(width):
            if buffer.owner[row, column] < 0:
                continue
            z = normal_at(buffer, corners, axes, row, column)[2]
            away = 1.0 - min(max(-z, 0.0), 1.0)
            cover = 0.05 + 0.38 * (away * away)
            for k in range(3):
                background = picture[row, column, k]
                picture[row, column, k] = (1.0 - cover) * background + cover * colour[k]
