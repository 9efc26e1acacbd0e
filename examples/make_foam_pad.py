"""The foam behind the face of `make_pad.py` as a mesh of hexahedra, written as VTU.

    python make_foam_pad.py foam_pad.vtu

As many millimetres thick along x as the case of the pad says, everywhere. Lengths in mm.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

THICKNESS = 60.0
COUNTS = (5, 16, 18)
"""Hexahedra along x, y and z."""
WIDTH, HEIGHT = 200.0, 220.0
X_CENTRE, Z_CENTRE = 108.0, 8.0
CURVATURE_Y, CURVATURE_Z = 1.0 / 700.0, 1.0 / 1500.0
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def foam_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and hexahedra (m, 8), corners in the order of VTK."""
    nx, ny, nz = COUNTS
    depth, y, z = np.meshgrid(
        np.linspace(0.0, THICKNESS, nx + 1),
        np.linspace(-WIDTH / 2, WIDTH / 2, ny + 1),
        np.linspace(-HEIGHT / 2, HEIGHT / 2, nz + 1),
        indexing="ij",
    )
    face = X_CENTRE - 0.5 * CURVATURE_Y * y**2 - 0.5 * CURVATURE_Z * z**2
    points = np.stack([face + depth, y, z + Z_CENTRE], axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corners = [number[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in CORNERS]
    return points, np.stack(corners, axis=1)


def write_foam(path: Path) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, hexahedra = foam_mesh()
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("hexahedron", hexahedra)])


if __name__ == "__main__":
    write_foam(Path(sys.argv[1] if len(sys.argv) > 1 else "foam_pad.vtu"))
