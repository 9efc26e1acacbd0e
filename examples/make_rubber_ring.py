"""A ring of rubber of square section as a mesh of hexahedra about the x axis, written as VTU.

    python make_rubber_ring.py rubber_ring.vtu

Lengths in mm.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

RADIUS, SIDE = 30.0, 8.0
"""Of the middle of the section, and of the section."""
AROUND, ACROSS = 60, 2
"""Hexahedra around the ring and along each side of its section."""
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def ring_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and hexahedra (m, 8), corners in the order of VTK."""
    across = np.linspace(-0.5 * SIDE, 0.5 * SIDE, ACROSS + 1)
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    x, radius, turn = np.meshgrid(across, RADIUS + across, angle, indexing="ij")
    points = np.stack([x, radius * np.cos(turn), radius * np.sin(turn)], axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(ACROSS + 1, ACROSS + 1, AROUND)
    closed = np.concatenate([number, number[:, :, :1]], axis=2)
    corners = [
        closed[a : a + ACROSS, b : b + ACROSS, c : c + AROUND].ravel() for a, b, c in CORNERS
    ]
    return points, np.stack(corners, axis=1)


def write_ring(path: Path) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, hexahedra = ring_mesh()
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("hexahedron", hexahedra)])


if __name__ == "__main__":
    write_ring(Path(sys.argv[1] if len(sys.argv) > 1 else "rubber_ring.vtu"))
