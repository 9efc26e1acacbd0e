"""A driver airbag as triangles, written as VTU: two discs sewn together at their rims, nearly flat.

    python make_airbag.py airbag.vtu [rings of triangles]

Lengths in mm; the lower disc lies in the plane z = 0 around the origin, and the upper one above it.
Normals point outward.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

RADIUS = 350.0
"""Radius of the discs as they are cut, mm."""
RISE = 10.0
"""Height of the middle of the upper disc over the lower one, mm: a little volume to begin with."""
RINGS = 16


def disc(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) of a disc of radius 1, 6 k of them on ring k, and its triangles (m, 3) about
    +z."""
    points, first = [np.zeros((1, 2))], [0]
    for k in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(6 * k) / (6 * k)
        points.append(k / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        first.append(first[-1] + max(6 * (k - 1), 1))
    triangles = []
    for k in range(1, rings + 1):
        for sector in range(6):
            outer = [first[k] + (sector * k + j) % (6 * k) for j in range(k + 1)]
            inner = [first[k - 1] + (sector * (k - 1) + j) % max(6 * (k - 1), 1) for j in range(k)]
            triangles += [(inner[j], outer[j], outer[j + 1]) for j in range(k)]
            triangles += [(inner[j], outer[j + 1], inner[j + 1]) for j in range(k - 1)]
    return np.concatenate(points), np.array(triangles)


def airbag_mesh(rings: int = RINGS) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (m, 3)."""
    flat, up = disc(rings)
    inner = len(flat) - 6 * rings
    lower = np.column_stack([RADIUS * flat, np.zeros(len(flat))])
    height = RISE * (1.0 - np.square(flat[:inner]).sum(axis=1))
    upper = np.column_stack([RADIUS * flat[:inner], height])
    number = np.concatenate([len(flat) + np.arange(inner), np.arange(inner, len(flat))])
    return np.concatenate([lower, upper]), np.concatenate([up[:, ::-1], number[up]])


def write_airbag(path: Path, rings: int = RINGS) -> None:
    """Write the mesh in the format of the suffix of `path`."""
    import meshio

    points, triangles = airbag_mesh(rings)
    path.parent.mkdir(parents=True, exist_ok=True)
    meshio.write_points_cells(path, points, [("triangle", triangles)])


if __name__ == "__main__":
    write_airbag(
        Path(sys.argv[1] if len(sys.argv) > 1 else "airbag.vtu"),
        int(sys.argv[2]) if len(sys.argv) > 2 else RINGS,
    )
