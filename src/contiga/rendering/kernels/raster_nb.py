"""A z-buffer: triangles, balls and lines drawn into arrays of pixels.

Pixels are (row, column) with the row going down the picture; depth grows away from the eye.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import kernel
from contiga.records import FloatArray, IntArray

_EDGE_TOL = -1e-9
"""Smallest barycentric coordinate: with rounding, a pixel on a shared edge is in a triangle."""


class Buffer(NamedTuple):
    """The visible points in each pixel of one layer; h rows, w columns."""

    depth: FloatArray
    """(h, w) distance from the eye along the view direction, infinity in an empty pixel."""
    owner: IntArray
    """(h, w) index of the triangle or ball, −1 in an empty pixel."""
    a: FloatArray
    """(h, w) first barycentric coordinate, or x offset on a ball."""
    b: FloatArray
    """(h, w) second barycentric coordinate, or y offset on a ball."""


def empty_buffer(height: int, width: int) -> Buffer:
    """Return a buffer (height, width) without owners (−1) and with infinite depths."""
    return Buffer(
        np.full((height, width), np.inf),
        np.full((height, width), -1, dtype=np.int32),
        np.zeros((height, width)),
        np.zeros((height, width)),
    )


@kernel()
def draw_triangles(screen, triangles, buffer):
    """Draw (m, 3) `triangles` of the (n, 3) `screen` points (column, row, depth) into `buffer`.

    Of equal depths the first stays. Triangles with a NaN or without area are left out.
    """
    height, width = buffer.depth.shape
    for t in range(triangles.shape[0]):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x0, y0, z0 = screen[p, 0], screen[p, 1], screen[p, 2]
        x1, y1, z1 = screen[q, 0], screen[q, 1], screen[q, 2]
        x2, y2, z2 = screen[r, 0], screen[r, 1], screen[r, 2]
        twice_area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if not (abs(twice_area) > 1e-12):
            continue
        left = max(0, math.ceil(min(x0, x1, x2)))
        right = min(width - 1, math.floor(max(x0, x1, x2)))
        top = max(0, math.ceil(min(y0, y1, y2)))
        bottom = min(height - 1, math.floor(max(y0, y1, y2)))
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                a = ((x1 - column) * (y2 - row) - (x2 - column) * (y1 - row)) / twice_area
                b = ((x2 - column) * (y0 - row) - (x0 - column) * (y2 - row)) / twice_area
                c = 1.0 - a - b
                if min(a, b, c) < _EDGE_TOL:
                    continue
                # 1/z is linear in the picture; z is not, and would bend flat faces at diagonals
                depth = 1.0 / (a / z0 + b / z1 + c / z2)
                if depth < buffer.depth[row, column]:
                    buffer.depth[row, column] = depth
                    buffer.owner[row, column] = t
                    buffer.a[row, column] = a
                    buffer.b[row, column] = b


@kernel()
def draw_balls(screen, radius, scale, buffer):
    """Draw a ball of `radius` pixels around each finite `screen` point (n, 3) into `buffer`.

    `scale` is length per pixel, with which the depths of a ball are computed.
    """
    height, width = buffer.depth.shape
    for k in range(screen.shape[0]):
        x, y, z = screen[k, 0], screen[k, 1], screen[k, 2]
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            continue
        for row in range(max(0, math.ceil(y - radius)), min(height - 1, int(y + radius)) + 1):
            for column in range(max(0, math.ceil(x - radius)), min(width - 1, int(x + radius)) + 1):
                dx, dy = (column - x) / radius, (row - y) / radius
                dz_squared = 1.0 - dx * dx - dy * dy
                if dz_squared < 0.0:
                    continue
                depth = z - scale * radius * math.sqrt(dz_squared)
                if depth < buffer.depth[row, column]:
                    buffer.depth[row, column] = depth
                    buffer.owner[row, column] = k
                    buffer.a[row, column] = dx
                    buffer.b[row, column] = dy


@kernel()
def draw_lines(screen, segments, depth, bias, ink):
    """Mark in `ink` (h, w) the visible pixels of (m, 2) `segments` of `screen` points.

    They are not behind `depth` (h, w) by more than `bias`. Segments with a NaN, or of 1e6 pixels or
    more, are left out.
    """
    height, width = depth.shape
    for s in range(segments.shape[0]):
        p, q = segments[s, 0], segments[s, 1]
        dx = screen[q, 0] - screen[p, 0]
        dy = screen[q, 1] - screen[p, 1]
        length = max(abs(dx), abs(dy))
        if not (length < 1e6):
            continue
        inverse_p, inverse_q = 1.0 / screen[p, 2], 1.0 / screen[q, 2]
        count = int(length) + 1
        for i in range(count + 1):
            t = i / count
            column = round(screen[p, 0] + t * dx)
            row = round(screen[p, 1] + t * dy)
            if 0 <= row < height and 0 <= column < width:
                z = 1.0 / (inverse_p + t * (inverse_q - inverse_p))
                if z <= depth[row, column] + bias:
                    ink[row, column] = True


@kernel()
def values_at_pixels(buffer, triangles, values, pixel_values):
    """Write `values` (n,) of a mesh's points, interpolated, into `pixel_values` (k,).

    The k entries are the covered pixels, row by row; interpolation is linear in the picture.
    """
    height, width = buffer.depth.shape
    k = 0
    for row in range(height):
        for column in range(width):
            t = buffer.owner[row, column]
            if t < 0:
                continue
            p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            a, b = buffer.a[row, column], buffer.b[row, column]
            pixel_values[k] = a * values[p] + b * values[q] + (1.0 - a - b) * values[r]
            k += 1
