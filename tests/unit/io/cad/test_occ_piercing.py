"""Faces that go through themselves on an axis: refused whole, read where they are one part."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests import occ_rig

import contiga as cg
from contiga.errors import FileError
from contiga.io.cad.occ_piercing import self_intersection

MAJOR, MINOR = 1.0, 2.0
HALF = math.acos(-MAJOR / MINOR)
"""The meridian circle meets the axis at ± this angle."""


def written(path: Path, shape: Any) -> Path:
    made = occ_rig.Rig()
    made.product(shape, "it")
    return made.write(path)


def section(v: float) -> float:
    """∫ of π ρ² dz along the meridian circle, from the equator to v."""
    terms = (
        MAJOR**2 * math.sin(v)
        + MAJOR * MINOR * (v + 0.5 * math.sin(2 * v))
        + MINOR**2 * (math.sin(v) - math.sin(v) ** 3 / 3)
    )
    return math.pi * MINOR * terms


@pytest.mark.parametrize("unit", ["mm", "cm"])
def test_a_torus_that_reaches_over_its_axis_is_refused_with_the_place(tmp_path, unit):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    path = written(tmp_path / "apple.step", BRepPrimAPI_MakeTorus(MAJOR, MINOR).Shape())
    z = math.sqrt(3.0) * (1.0 if unit == "mm" else 0.1)
    with pytest.raises(FileError, match=rf"face 1: .*through itself.*, {z:.6g}\)"):
        cg.read_cad(path, unit=unit)


@pytest.mark.parametrize(("low", "high"), [(-HALF, HALF), (HALF, 2.0 * math.pi - HALF)])
def test_its_outer_and_its_inner_part_are_read(tmp_path, low, high):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    shape = BRepPrimAPI_MakeTorus(MAJOR, MINOR, low, high).Shape()
    body = cg.read_cad(written(tmp_path / "part.step", shape))
    assert body.closed
    assert abs(body.volume()) == pytest.approx(abs(section(high) - section(low)), rel=1e-6)


def test_a_torus_beside_its_axis_and_one_that_touches_it_are_read(tmp_path):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    for major, minor in ((3.0, 1.0), (2.0, 2.0)):
        body = cg.read_cad(
            written(tmp_path / "t.step", BRepPrimAPI_MakeTorus(major, minor).Shape())
        )
        assert body.volume() == pytest.approx(2.0 * (math.pi * minor) ** 2 * major, rel=1e-6)


def meridian(points: list[tuple[float, float]]) -> Any:
    """A Bézier curve in (x, z), turned about z."""
    from OCP.collections import Array1_gp_Pnt
    from OCP.Geom import Geom_BezierCurve, Geom_SurfaceOfRevolution
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    poles = Array1_gp_Pnt(1, len(points))
    for k, (x, z) in enumerate(points):
        poles.SetValue(k + 1, gp_Pnt(x, 0.0, z))
    axis = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    return Geom_SurfaceOfRevolution(Geom_BezierCurve(poles), axis)


def test_a_meridian_that_crosses_its_axis_is_found_and_one_that_ends_there_is_not():
    whole = np.array([[0.0, 0.0], [2.0 * math.pi, 1.0]])
    ends = meridian([(0.0, -1.0), (2.0, -1.0), (1.0, 2.0), (0.0, 2.0)])
    assert self_intersection(ends, whole) is None
    crosses = meridian([(1.0, -1.0), (-0.5, 0.5), (-2.0, 2.0)])
    assert self_intersection(crosses, whole) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert self_intersection(crosses, whole * [1.0, 0.3]) is None
