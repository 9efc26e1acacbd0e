"""A small picture of a triangulation, for notebooks."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IntArray
from contiga.rendering import shading
from contiga.rendering.camera import look

COLOUR = np.array([0.62, 0.70, 0.78])
TOLERANCE = 1e-3
"""Chord tolerance of the drawn triangles, over the size of the object."""
_SIZE = (300, 400)
"""Rows and columns."""
_SAMPLES = 2
"""Pixels drawn per pixel shown, in each direction."""
_TOWARDS, _UP = np.array([-0.55, 0.75, -0.45]), np.array([0.0, 0.0, 1.0])
_EDGE_BIAS = 2e-3
"""Depth by which an edge may lie behind the surface, over the size of the scene."""


def picture_of(points: FloatArray, triangles: IntArray) -> bytes:
    """Return a shaded picture (PNG, 400 x 300 pixels) of triangles with borders and creases.

    Parameters
    ----------
    points : (n, 3), length; only corners of triangles are framed
    triangles : (m, 3) rows of `points`, one or more
    """
    rows, columns = (_SAMPLES * n for n in _SIZE)
    corners = points[np.unique(triangles)]
    camera = look(_TOWARDS, _UP, corners, (rows, columns))
    size = float(np.ptp(corners, axis=0).max())
    picture = np.ones((rows, columns, 3), dtype=np.float32)
    layer = shading.mesh_layer(camera, points, triangles)
    shading.paint(picture, layer, COLOUR, size, layer.buffer.depth)
    edges = shading.drawn_edges(points, triangles)
    picture[shading.line_ink(camera, points, edges, layer.buffer.depth, _EDGE_BIAS * size)] *= 0.55
    return png((255.0 * shading.shrunk(picture, _SAMPLES)).round().astype(np.uint8))


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Return `pixels` (h, w, 3) encoded as PNG, without a package for pictures.

    Each row is stored as its difference to the row above (filter 2), which compresses well where
    colours change slowly.
    """
    height, width = pixels.shape[:2]
    rows = np.full((height, 1 + 3 * width), 2, dtype=np.uint8)
    rows[:, 1:] = np.diff(pixels.reshape(height, -1), axis=0, prepend=np.uint8(0))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
