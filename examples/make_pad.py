"""The face of a foam pad as a mesh of 60 × 60 quadrilaterals, written as VTU.

A gently hollow sheet of 200 × 220 mm standing across the x axis, hollow towards the headform of
`make_headform.py`. Lengths in mm. The foam behind it is not meshed: its thickness and its
stress-strain curve stand in the case file.

    python make_pad.py pad.vtu
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

N_QUADS = 60
WIDTH, HEIGHT = 200.0, 220.0
X_CENTRE, Z_CENTRE = 108.0, 8.0
CURVATURE_Y, CURVATURE_Z = 1.0 / 700.0, 1.0 / 1500.0


def pad_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Points ((N_QUADS + 1)², 3) and quadrilaterals (N_QUADS², 4), seen from the headform."""
    y, z = np.meshgrid(
        np.linspace(-WIDTH / 2, WIDTH / 2, N_QUADS + 1),
        np.linspace(-HEIGHT / 2, HEIGHT / 2, N_QUADS + 1),
        indexing="ij",
    )
    x = X_CENTRE - 0.5 * CURVATURE_Y * y**2 - 0.5 * CURVATURE_Z * z**2
    points = np.stack([x, y, z + Z_CENTRE], axis=-1).reshape(-1, 3)
    number = np.arange((N_QUADS + 1) ** 2).reshape(N_QUADS + 1, N_QUADS + 1)
    corners = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    return points, np.stack(corners, axis=-1).reshape(-1, 4)


def write_pad(path: Path) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, quads = pad_mesh()
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("quad", quads)])


if __name__ == "__main__":
    write_pad(Path(sys.argv[1] if len(sys.argv) > 1 else "pad.vtu"))
