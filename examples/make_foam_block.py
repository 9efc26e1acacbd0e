"""A block of foam as a mesh of hexahedra, 100 × 100 × 60 mm on the plane z = 0, written as VTU.

python make_foam_block.py foam_block.vtu
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

SIDES = (100.0, 100.0, 60.0)
COUNTS = (10, 10, 6)
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def block_mesh(counts: tuple[int, int, int] = COUNTS) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and hexahedra (m, 8), corners in the order of VTK: 847 and 600 of COUNTS."""
    lines = [np.linspace(0.0, side, n + 1) for side, n in zip(SIDES, counts, strict=True)]
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    points[:, :2] -= 0.5 * np.array(SIDES[:2])
    number = np.arange(len(points)).reshape([n + 1 for n in counts])
    nx, ny, nz = counts
    corners = [number[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in CORNERS]
    return points, np.stack(corners, axis=1)


def write_block(path: Path, counts: tuple[int, int, int] = COUNTS) -> None:
    """Write a mesh of `counts` hexahedra along its axes, in the format of the suffix of `path`."""
    import meshio

    points, hexahedra = block_mesh(counts)
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("hexahedron", hexahedra)])


if __name__ == "__main__":
    write_block(Path(sys.argv[1] if len(sys.argv) > 1 else "foam_block.vtu"))
