"""Writes the bonnet of the headform study as STEP, and beside it where heads are to hit it as CSV.

    python make_bonnet.py bonnet.step [SPACING]

The skin is one curved B-spline face, made and cut by OpenCASCADE: two vents and a slot go through
it. Targets stand on a grid of about SPACING mm (100 if left out), in ``targets.csv``: rays straight
down find the points of the exact surface, and a ray through a hole finds none. Lengths in mm, x to
the rear, z up.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import contiga as cg
from contiga_validation.rivals.headform import cut, cylinder, write_step

LENGTH, WIDTH = 900.0, 1300.0
RISE, CROWN, BEAD = 120.0, 55.0, 9.0
VENTS = ((690.0, -300.0), (690.0, 300.0))
VENT_RADIUS = 55.0
SLOT = (150.0, -170.0, 55.0, 340.0)
"""Corner of least x and y, and lengths along x and y."""
MARGIN = 90.0
"""From the border of the part to the first targets."""
SPACING = 100.0


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the skin: it rises to the rear, falls to the sides, and has two beads along it."""
    side = (2.0 * y / WIDTH) ** 2
    beads = BEAD * np.exp(-(((np.abs(y) - 420.0) / 60.0) ** 2))
    return RISE * np.sin(0.5 * np.pi * x / LENGTH) - CROWN * side * (1.0 + 0.8 * side) + beads


def skin() -> Any:
    """The bicubic face through points of `height`, its normal upwards."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.collections import Array2_gp_Pnt
    from OCP.GeomAbs import GeomAbs_C2
    from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
    from OCP.gp import gp_Pnt

    x, y = np.linspace(0.0, LENGTH, 10), np.linspace(-WIDTH / 2, WIDTH / 2, 27)
    points = Array2_gp_Pnt(1, len(x), 1, len(y))
    for i, j in np.ndindex(len(x), len(y)):
        points.SetValue(i + 1, j + 1, gp_Pnt(x[i], y[j], float(height(x[i], y[j]))))
    surface = GeomAPI_PointsToBSplineSurface(points, 3, 3, GeomAbs_C2, 0.01).Surface()
    return BRepBuilderAPI_MakeFace(surface, 1e-6).Face()


def bonnet() -> Any:
    """The skin with its holes."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    part = skin()
    for x, y in VENTS:
        part = cut(part, cylinder((x, y, -200.0), (0.0, 0.0, 1.0), VENT_RADIUS, 600.0))
    x, y, dx, dy = SLOT
    return cut(part, BRepPrimAPI_MakeBox(gp_Pnt(x, y, -200.0), dx, dy, 600.0).Shape())


def targets(body: cg.Body, spacing: float) -> np.ndarray:
    """(n, 3) points of the surface under a grid: where rays straight down first hit it."""
    x = np.linspace(MARGIN, LENGTH - MARGIN, round((LENGTH - 2.0 * MARGIN) / spacing) + 1)
    half = 0.5 * WIDTH - MARGIN
    y = np.linspace(-half, half, round(2.0 * half / spacing) + 1)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    above = np.column_stack([grid, np.full(len(grid), 500.0)])
    hit = body.first_hit(above, above - [0.0, 0.0, 1000.0])
    return hit.point[np.isfinite(hit.fraction)]


def main(path: Path, spacing: float) -> None:
    """Write both files."""
    write_step(bonnet(), path)
    found = targets(cg.read_cad(path), spacing)
    rows = ["x [mm],y [mm],z [mm]", *(",".join(map(repr, row)) for row in found.tolist())]
    path.with_name("targets.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    print(f"{path}: {len(found)} targets")


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "bonnet.step"),
        float(sys.argv[2]) if len(sys.argv) > 2 else SPACING,
    )
