"""Bodies and meshes that many tests stand on."""

from __future__ import annotations

import numpy as np

import contiga as cg

Corner = tuple[float, float, float]


def box(low: Corner, high: Corner) -> cg.Body:
    """A closed box of six plane patches."""
    (a, b, c), (d, e, f) = low, high
    face = cg.shapes.bilinear
    return cg.Body(
        [
            face((a, b, f), (d, b, f), (a, e, f), (d, e, f)),
            face((a, b, c), (a, e, c), (d, b, c), (d, e, c)),
            face((a, b, c), (d, b, c), (a, b, f), (d, b, f)),
            face((a, e, c), (a, e, f), (d, e, c), (d, e, f)),
            face((a, b, c), (a, b, f), (a, e, c), (a, e, f)),
            face((d, b, c), (d, e, c), (d, b, f), (d, e, f)),
        ]
    )


def grid_quads(n: int) -> np.ndarray:
    """(m, 4) quadrilaterals between n × n points that were laid out row by row."""
    row = np.arange(n * n).reshape(n, n)
    corners = (row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:])
    return np.stack(corners, axis=-1).reshape(-1, 4)


def square_sheet(side: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n², 3) and quadrilaterals of a square in z = 0 about the origin."""
    return cg.clouds.sample(cg.shapes.plane(width=side, length=side), n, n), grid_quads(n)
