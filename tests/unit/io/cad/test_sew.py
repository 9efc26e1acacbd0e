"""Loose faces: which edges are one does not depend on the order in the file."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import contiga as cg

PI = math.pi


def cap(radii: list[float], z: float, first: float = 0.0) -> Any:
    """A disc or a ring whose circles begin at an angle."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge as Edge
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace as Face
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire as Wire
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pln, gp_Pnt
    from OCP.TopoDS import TopoDS

    way, place = gp_Dir(0, 0, 1), gp_Pnt(0, 0, z)
    axes = gp_Ax2(place, way, gp_Dir(math.cos(first), math.sin(first), 0))
    wires = [Wire(Edge(gp_Circ(axes, radius)).Edge()).Wire() for radius in radii]
    made = Face(gp_Pln(place, way), wires[0], True)
    for wire in wires[1:]:
        made.Add(TopoDS.Wire(wire.Reversed()))
    return made.Face()


def tube(radius: float, z: float, height: float, *degrees: float) -> list[Any]:
    """Pieces of a cylinder between angles."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.gp import gp_Ax3, gp_Cylinder, gp_Dir, gp_Pnt

    round_ = gp_Cylinder(gp_Ax3(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), radius)
    turns = np.radians(degrees).tolist()
    return [BRepBuilderAPI_MakeFace(round_, a, b, 0.0, height).Face() for a, b in pairwise(turns)]


def quad(*corners: tuple[float, float, float]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.gp import gp_Pnt

    polygon = BRepBuilderAPI_MakePolygon()
    for corner in corners:
        polygon.Add(gp_Pnt(*map(float, corner)))
    polygon.Close()
    return BRepBuilderAPI_MakeFace(polygon.Wire()).Face()


def box() -> list[Any]:
    """Four long, one of its walls in two faces."""
    return [
        quad((0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)),
        quad((0, 0, 4), (4, 0, 4), (4, 4, 4), (0, 4, 4)),
        quad((0, 0, 0), (2, 0, 0), (2, 0, 4), (0, 0, 4)),
        quad((2, 0, 0), (4, 0, 0), (4, 0, 4), (2, 0, 4)),
        quad((0, 4, 0), (4, 4, 0), (4, 4, 4), (0, 4, 4)),
        quad((0, 0, 0), (0, 4, 0), (0, 4, 4), (0, 0, 4)),
        quad((4, 0, 0), (4, 4, 0), (4, 4, 4), (4, 0, 4)),
    ]


def shapes() -> dict[str, tuple[list[Any], float]]:
    """Faces and the volume they enclose."""
    ends = [cap([1], 0), cap([1], 3)]
    rings = [cap([1, 0.5], 0, 1.0), cap([1, 0.5], 3, 1.0)]
    halves, thirds = (0, 180, 360), (20, 140, 260, 380)
    return {
        "halves": ([*ends, *tube(1, 0, 3, *halves)], 3 * PI),
        "thirds, the seam within one": ([*ends, *tube(1, 0, 3, *thirds)], 3 * PI),
        "pipe": ([*rings, *tube(1, 0, 3, *halves), *tube(0.5, 0, 3, *halves)], 2.25 * PI),
        "box": (box(), 64.0),
        "halves on thirds": ([*ends, *tube(1, 0, 1, *halves), *tube(1, 1, 2, *thirds)], 3 * PI),
        "whole on halves": ([*ends, *tube(1, 0, 1, *halves), *tube(1, 1, 2, 0, 360)], 3 * PI),
    }


@pytest.mark.parametrize(
    "name", ["halves", "thirds, the seam within one", "pipe", "box", "halves on thirds",
             "whole on halves"],
)  # fmt: skip
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_loose_faces_close_in_any_order(
    name: str, seed: int | None, solids: ModuleType, tmp_path: Path
) -> None:
    faces, volume = shapes()[name]
    if seed is None:
        faces = faces[::-1]  # partial edges first
    else:
        random.Random(seed).shuffle(faces)
    path = solids.write(solids.compound(faces), tmp_path / "part.step")
    body = cg.read_cad(path)
    assert body.openings.flaws == []
    assert body.closed
    assert body.mass_properties(1.0).mass == pytest.approx(volume, rel=1e-9)
    assert max(edge.gap for edge in body.edges) < 1e-7
