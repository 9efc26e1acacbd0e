"""Small bodies and slaves that have of everything what kernels tell apart."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

import contiga as cg
from contiga.geometry.edges import UNTRIMMED, BodyEdge, EdgeUse

LID, FILLET = 0, 1
"""Patches of `puck` that are joined over a trim."""
TOP = 3
"""The natural side v1."""


@cache
def puck() -> cg.Body:
    """Closed: a trimmed lid, a fillet, a wall and a base with a pole; smooth, and with a crease."""
    edge = cg.shapes.circle(radius=0.7, centre=(0.0, 0.0, 0.5))
    lid = cg.shapes.plane(width=2.0, length=2.0, centre=(0.0, 0.0, 0.5))
    around = cg.shapes.circle(radius=0.35, centre=(0.5, 0.5, 0.0))
    rise = [[1.0, 0.0, 0.2], [1.0, 0.0, 0.5], [0.7, 0.0, 0.5]]
    quarter = cg.NurbsCurve(2, [0, 0, 0, 1, 1, 1], rise, [1.0, np.sqrt(0.5), 1.0])
    fillet = cg.shapes.revolved(quarter)
    wall = cg.shapes.cylinder(radius=1.0, height=0.7, centre=(0.0, 0.0, -0.15))
    base = cg.shapes.disc(radius=1.0, centre=(0.0, 0.0, -0.5), axis=(0.0, 0.0, -1.0))
    uses = (EdgeUse(LID, 0, 0, False), EdgeUse(FILLET, UNTRIMMED, TOP, False))
    seam = BodyEdge(edge, 1e-9, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body(
        [lid, fillet, wall, base],
        trims=[[[around]], None, None, None],
        edges=[seam],
        name="puck",
    )


@cache
def plate() -> cg.Body:
    """Open: a bicubic plate of polynomials with a round hole."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
    outer = [cg.shapes.line((*a, 0.0), (*b, 0.0)) for a, b in pairwise(corners)]
    hole = [cg.shapes.circle(radius=0.15, centre=(0.5, 0.5, 0.0))]
    surface = cg.shapes.bumpy_plate(width=2.0, length=2.0, amplitude=0.05)
    return cg.Body([surface], trims=[[outer, hole]], name="plate")


def sheet(n: int = 13, side: float = 2.4, height: float = 0.0) -> cg.Slave:
    """Quadrilaterals with thickness and mass."""
    face = cg.shapes.plane(width=side, length=side, centre=(0.0, 0.0, height))
    row = np.arange(n * n).reshape(n, n)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    each = np.ones(n * n)
    return cg.Slave(
        cg.clouds.sample(face, n, n),
        quads.reshape(-1, 4),
        thickness=0.5 * each,
        mass=1e-3 * each,
        name="sheet",
    )


def cloud(n: int = 13, side: float = 1.2) -> cg.Slave:
    """The nodes of such a sheet, and no facets."""
    each = np.ones(n * n)
    return cg.Slave(sheet(n, side).points, area=1e-2 * each, thickness=0.5 * each)
