"""A tyre without a rim as a membrane of triangles about the y axis, written as VTU.

    python make_tyre.py tyre.vtu

Its section is half a circle, and from that on straight sides inward to the beads, which are the
outermost nodes along y. Normals point outward. Lengths in mm, the axle through the origin.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

RADIUS, WIDTH, SIDE = 240.0, 120.0, 40.0
"""Of the circle that the sides end at, of the section, and of the sides."""
FLARE = 4.0
"""By which the beads are further apart than the sides."""
AROUND, TREAD, WALL = 96, 12, 3
"""Cells around, over the half circle, and over each side."""


def section() -> np.ndarray:
    """(k, 2) distances from the axle and places along it, from bead to bead."""
    half = 0.5 * WIDTH
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, TREAD + 1)
    tread = np.stack([RADIUS + half * np.cos(angle), half * np.sin(angle)], axis=1)
    part = np.linspace(0.0, 1.0, WALL + 1)[1:]
    wall = np.stack([RADIUS - SIDE * part, half + FLARE * part], axis=1)
    return np.concatenate([wall[::-1] * [1.0, -1.0], tread, wall])


def tyre_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (m, 3)."""
    radius, along = section().T
    angle = 2.0 * np.pi * np.arange(AROUND)[:, None] / AROUND
    points = np.stack(
        [
            radius * np.cos(angle),
            np.broadcast_to(along, (AROUND, len(along))),
            radius * np.sin(angle),
        ],
        axis=-1,
    )
    number = np.arange(points.size // 3).reshape(AROUND, len(radius))
    after = np.roll(number, -1, axis=0)
    a, b, c, d = number[:, :-1], after[:, :-1], after[:, 1:], number[:, 1:]
    triangles = np.stack([np.stack([a, c, b], -1), np.stack([a, d, c], -1)], axis=2)
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def write_tyre(path: Path) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, triangles = tyre_mesh()
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("triangle", triangles)])


if __name__ == "__main__":
    write_tyre(Path(sys.argv[1] if len(sys.argv) > 1 else "tyre.vtu"))
