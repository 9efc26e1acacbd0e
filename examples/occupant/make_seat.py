"""Write the cushion of the seat: a block of foam, sheared so that it rises to the front, as VTU.

    python make_seat.py seat.vtu

Lengths in mm; its top passes below the pelvis of the dummy, whose H-point is the origin.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

LOW, HIGH = np.array([[-230.0, -210.0, -274.0], [310.0, 210.0, -124.0]])
"""Corners of the block where x = PIVOT; there z is that of its bottom and its top."""
PIVOT = -60.0
RISE = 0.2126
"""Slope of top and bottom, 12 degrees."""
COUNTS = (9, 7, 2)
"""Hexahedra along x, y and z."""


def cushion(counts: tuple[int, int, int] = COUNTS) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and hexahedra (m, 8)."""
    axes = [
        np.linspace(low, high, count + 1)
        for low, high, count in zip(LOW, HIGH, counts, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    points[..., 2] += RISE * (points[..., 0] - PIVOT)
    number = np.arange(points[..., 0].size).reshape(points.shape[:3])
    square = ((0, 0), (1, 0), (1, 1), (0, 1))
    corners = [
        number[i : i + counts[0], j : j + counts[1], k : k + counts[2]]
        for k in (0, 1)
        for i, j in square
    ]
    return points.reshape(-1, 3), np.stack(corners, axis=-1).reshape(-1, 8)


def write_seat(path: Path) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, hexahedra = cushion()
    meshio.write_points_cells(path, points, [("hexahedron", hexahedra)])


if __name__ == "__main__":
    write_seat(Path(sys.argv[1] if len(sys.argv) > 1 else "seat.vtu"))
