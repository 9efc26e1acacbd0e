"""Cook's panel: skew elements in shear and bending, compressible and nearly incompressible."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.at_rest import resting
from contiga_validation.closed_forms.case import Answer, Cases, relative
from contiga_validation.closed_forms.foam import bricks
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import comparison

CASES = Cases(GROUP)

ELASTIC = cg.materials.Elastic(young=1.0, poisson=1.0 / 3.0)
RUBBER = cg.materials.NeoHooke(young=240.565, poisson=0.4999)
LOADS = 1e-5, 1e-2
"""Loads in plane stress and in plane strain, small as for linear theory: displacements are a few
1e-4 of the width."""
MIDDLE = 23.965
"""Displacement of the middle of the right side over the load, in plane stress (refined meshes of
many authors; R. D. Cook's own is 23.9)."""
INCOMPRESSIBLE = 7.671, 8.039
"""Displacements of the middle and of the upper corner of the right side over a hundredth of the
load, in plane strain with ν = 0.4999, by quadratic triangles with pressures; finer meshes still add
a thousandth."""


class Raised(NamedTuple):
    """Vertical displacements over the load on the right side."""

    middle: float
    """Displacement of its middle."""
    corner: float
    """Displacement of its upper corner."""


def panel(cells: int, *, strain: bool, tolerance: float) -> Raised:
    """Return the displacements of one layer of `cells` × `cells` hexahedra, fixed at the left side.

    The load is vertical, over the right side. In plane `strain`, of rubber, both faces are held
    across; in plane stress, of elastic material, one is, and the other is free.
    """
    material, load = (RUBBER, LOADS[1]) if strain else (ELASTIC, LOADS[0])
    line, thick = np.linspace(0.0, 1.0, cells + 1), 48.0 / cells
    points, elements = bricks((line, line, np.array([0.0, thick])))
    x, y, z = points.T
    points = np.stack([48.0 * x, 44.0 * x + (44.0 - 28.0 * x) * y, z], axis=1)
    sides = elements[:, [1, 2, 6, 5]]
    right = sides[(points[sides, 0] == 48.0).all(axis=1)]
    fixed = np.zeros(points.shape, np.bool_)
    fixed[x == 0.0, :2] = True
    fixed[:, 2] = strain | (z == 0.0)
    up = cg.motion.NodalForce(
        [0.0, load * thick, 0.0], on={"plane": ([48.0, 0.0, 0.0], [1.0, 0.0, 0.0])}
    )
    motion = cg.motion.Deforming(material=material, density=1.0, fixed=fixed, loads=up)
    slave = cg.Slave(points, right, elements={"hexahedron": elements})
    displacements = resting(slave, motion, tolerance).slaves["it"].points[:, 1] - points[:, 1]
    end = x == 1.0
    return Raised(
        float(displacements[end & (y == 0.5)].mean() / load),
        float(displacements[end & (y == 1.0)].mean() / load),
    )


@CASES.add(
    "matter-cook",
    "Cook's panel in plane stress",
    "u = 23.965 F/(E t) in the middle of the right side, ν = 1/3",
    "48 wide, 44 high at the left, 16 at the right, from 44 to 60; one layer of hexahedra of "
    "one point each, under a small load. Meshes of 2 to 16 cells a side.",
)
def _elastic() -> Answer:
    meshes = np.array([2, 4, 8, 16])
    raised = np.array([panel(int(n), strain=False, tolerance=1e-4).middle for n in meshes])
    checks = (
        relative("middle of the right side, 16 × 16 cells", raised[-1], MIDDLE, 8e-3),
        relative("from 8 × 8 and 16 × 16", (4.0 * raised[-1] - raised[-2]) / 3.0, MIDDLE, 2e-3),
    )
    draw = comparison(
        ("cells along a side", "way over load"),
        [("published", np.array([2.0, 16.0]), np.full(2, MIDDLE))],
        [("hexahedra", meshes.astype(np.float64), raised)],
    )
    return Answer(checks, draw)


@CASES.add(
    "matter-cook-volume",
    "Cook's panel that keeps its volume",
    "u = 7.671 and 8.039 at F = 100, E = 240.565, ν = 0.4999",
    "The same panel in plane strain, linear as well: what locks goes up by a quarter of it.",
)
def _kept() -> Answer:
    meshes = np.array([2, 6])
    raises = [panel(int(n), strain=True, tolerance=2e-3) for n in meshes]
    raised = 100.0 * np.array(raises)
    checks = tuple(
        relative(f"{name}, 6 × 6 cells", raised[-1, k], INCOMPRESSIBLE[k], 0.06)
        for k, name in enumerate(("middle of the right side", "its upper corner"))
    )
    ends = np.array([2.0, 6.0])
    draw = comparison(
        ("cells along a side", "way at F = 100"),
        [(f"published, {name}", ends, np.full(2, INCOMPRESSIBLE[k]))
         for k, name in enumerate(("middle", "corner"))],
        [(name, meshes.astype(np.float64), raised[:, k])
         for k, name in enumerate(("middle", "corner"))],
    )  # fmt: skip
    return Answer(checks, draw)
