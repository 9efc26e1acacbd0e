"""Shapes written with OpenCASCADE and read back: closed forms for areas, volumes and topology."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.trim_area import patch_areas
from contiga.io.cad.occ_geometry import quiet


def write_step(path: Any, *shapes: Any, unit: str = "MM") -> Any:
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    with quiet():
        writer = STEPControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        for shape in shapes:
            writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
        Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def write_iges(path: Any, shape: Any, unit: str) -> Any:
    from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer

    with quiet():
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer(unit, 1)
        writer.AddShape(shape)
        writer.ComputeModel()
        writer.Write(str(path))
    return path


def box(a: float = 1.0, b: float = 2.0, c: float = 3.0) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    return BRepPrimAPI_MakeBox(a, b, c).Shape()


def cylinder(radius: float, height: float, angle: float = 2.0 * math.pi, at: float = 0.0) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    axes = gp_Ax2(gp_Pnt(at, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0), gp_Dir(0.6, 0.8, 0.0))
    return BRepPrimAPI_MakeCylinder(axes, radius, height, angle).Shape()


def cut(shape: Any, tool: Any) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(shape, tool).Shape()


def moved(shape: Any, angle: float, by: tuple[float, float, float]) -> Any:
    """`shape` as an instance: turned about z, then moved, by its location only."""
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    turn, shift = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0)), angle)
    shift.SetTranslation(gp_Vec(*by))
    return shape.Moved(TopLoc_Location(shift.Multiplied(turn)))


def outward(body: cg.Body) -> bool:
    """Whether all normals point away from the middle of a convex body."""
    middle = body.bounds().mean(axis=0)
    for patch in body.patches:
        uv = [[np.mean(patch.domain[0]), np.mean(patch.domain[1])]]
        if (patch.normal(uv) @ (patch.evaluate(uv) - middle)[0])[0] <= 0.0:
            return False
    return True


def test_box_has_six_whole_faces_twelve_shared_edges_and_normals_outward(tmp_path):
    body = cg.read_cad(write_step(tmp_path / "box.step", box()))
    assert len(body.patches) == 6
    assert all(loops is None for loops in body.trims)
    assert len(body.edges) == 12
    assert all(len({use.patch for use in edge.uses}) == 2 for edge in body.edges)
    assert body.area() == pytest.approx(22.0, rel=1e-14)
    assert body.volume() == pytest.approx(6.0, rel=1e-14)
    assert outward(body)
    assert np.allclose(body.bounds(), [[0, 0, 0], [1, 2, 3]], atol=1e-14)


def assert_edges_run_as_noted(body: cg.Body) -> None:
    for edge in body.edges:
        ends = edge.curve.evaluate(np.array(edge.curve.domain))
        for use in edge.uses:
            (u0, u1), (v0, v1) = body.patches[use.patch].domain
            sides = [[(u0, v0), (u0, v1)], [(u1, v0), (u1, v1)]]
            sides += [[(u0, v0), (u1, v0)], [(u0, v1), (u1, v1)]]
            on = body.patches[use.patch].evaluate(np.array(sides[use.index]))
            assert np.allclose(on[::-1] if use.reversed else on, ends, atol=1e-12)


def test_shared_edges_of_a_box_run_along_both_faces_in_the_noted_sense(tmp_path):
    assert_edges_run_as_noted(cg.read_cad(write_step(tmp_path / "box.step", box())))


def loose(shape: Any, *, turned: int = -1) -> Any:
    """Every face of `shape` on its own, with edges of its own; face `turned` inside out."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS_Compound

    builder, made = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(made)
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    number = 0
    while explorer.More():
        face = BRepBuilderAPI_Copy(explorer.Current()).Shape()
        builder.Add(made, face.Reversed() if number == turned else face)
        explorer.Next()
        number += 1
    return made


@pytest.mark.parametrize("turned", [-1, 0, 4])
def test_loose_faces_of_a_box_share_their_edges_and_face_one_way(tmp_path, turned):
    body = cg.read_cad(write_step(tmp_path / "box.step", loose(box(), turned=turned)))
    assert len(body.patches) == 6
    assert [len(edge.uses) for edge in body.edges] == 12 * [2]
    assert body.volume() == pytest.approx(6.0, rel=1e-14)
    assert outward(body)
    assert_edges_run_as_noted(body)


def test_faces_that_do_not_touch_keep_edges_of_their_own(tmp_path):
    apart = moved(box(), 0.0, (1.0 + 1e-4, 0.0, 0.0))
    body = cg.read_cad(write_step(tmp_path / "two.step", loose(box()), loose(apart)))
    assert [len(edge.uses) for edge in body.edges] == 24 * [2]


def test_an_edge_that_meets_two_in_turn_is_shared_with_both(tmp_path):
    # Two small plates along one side of a long one.
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.gp import gp_Pln
    from OCP.TopoDS import TopoDS_Compound

    builder, made = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(made)
    for u0, u1, v0, v1 in ((0, 2, 0, 1), (0, 1, 1, 2), (1, 2, 1, 2)):
        builder.Add(made, BRepBuilderAPI_MakeFace(gp_Pln(), u0, u1, v0, v1).Face())
    body = cg.read_cad(write_step(tmp_path / "plates.step", made))
    assert sorted(len(edge.uses) for edge in body.edges) == [*(7 * [1]), 2, 3]
    contact = cg.Contact(body, cg.Slave([[0.5, 0.9, 0.1]], area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.step(contact.start([[0.5, 0.9, 0.1]]), [[0.5, 0.9, -0.05]])
    state = contact.step(state, [[0.5, 1.2, -0.05]])
    assert state.status[0] == cg.ContactStatus.OLD


@pytest.mark.parametrize("unit", ["MM", "M", "INCH"])
def test_step_in_any_unit_is_the_same_box(tmp_path, unit):
    path = write_step(tmp_path / "box.step", box(), unit=unit)
    assert cg.read_cad(path).unit == {"MM": "mm", "M": "m", "INCH": "in"}[unit]
    assert np.allclose(cg.read_cad(path, unit="mm").bounds()[1], [1, 2, 3], rtol=1e-12)


def test_iges_in_inches_is_converted(tmp_path):
    path = write_iges(tmp_path / "box.iges", box(25.4, 50.8, 76.2), "IN")
    body = cg.read_cad(path)
    assert body.unit == "in"
    assert np.allclose(body.bounds()[1], [1, 2, 3], rtol=1e-12)
    assert cg.read_cad(path, unit="mm").area() == pytest.approx(22.0 * 25.4**2, rel=1e-12)


def test_instances_of_an_assembly_stand_where_they_are_placed(tmp_path):
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    part = box()
    builder, inner, outer = BRep_Builder(), TopoDS_Compound(), TopoDS_Compound()
    builder.MakeCompound(inner)
    builder.MakeCompound(outer)
    builder.Add(inner, moved(part, 0.0, (10.0, 0.0, 0.0)))
    builder.Add(inner, moved(part, math.pi / 2, (0.0, 20.0, 0.0)))
    builder.Add(outer, moved(inner, math.pi / 2, (0.0, 0.0, 5.0)))
    builder.Add(outer, part)
    body = cg.read_cad(write_step(tmp_path / "assembly.step", outer))
    assert len(body.patches) == 18
    assert len(body.edges) == 36
    assert body.volume() == pytest.approx(18.0, rel=1e-12)
    # (x, y, z) → (−y, x, z + 5) takes the first instance to x −2…0, y 10…11 and the second,
    # itself turned, to x −21…−20, y −2…0.
    boxes = [cg.Body(body.patches[6 * i : 6 * i + 6]).bounds() for i in range(3)]
    expected = [
        [[-2, 10, 5], [0, 11, 8]],
        [[-21, -2, 5], [-20, 0, 8]],
        [[0, 0, 0], [1, 2, 3]],
    ]
    for wanted in expected:
        assert any(np.allclose(found, wanted, atol=1e-12) for found in boxes), wanted


@pytest.mark.parametrize("angle", [0.5 * math.pi, 1.5 * math.pi, 2.0 * math.pi])
def test_cylinder_strips_become_whole_patches_cut_to_their_angle(tmp_path, angle):
    body = cg.read_cad(write_step(tmp_path / "c.step", cylinder(2.0, 3.0, angle)))
    areas = patch_areas(body)
    side = [k for k, patch in enumerate(body.patches) if patch.is_rational]
    assert len(side) == 1
    assert body.trims[side[0]] is None
    assert areas[side[0]] == pytest.approx(2.0 * 3.0 * angle, rel=1e-12)
    assert body.volume() == pytest.approx(0.5 * angle * 4.0 * 3.0, rel=1e-9)
    # The domain is the angle itself, though the rational parameter is not.
    assert np.ptp(body.patches[side[0]].domain[0]) == pytest.approx(angle, rel=1e-12)


def test_full_cylinder_has_a_seam_that_one_patch_uses_twice(tmp_path):
    body = cg.read_cad(write_step(tmp_path / "c.step", cylinder(2.0, 3.0)))
    seams = [e for e in body.edges if len(e.uses) == 2 and e.uses[0].patch == e.uses[1].patch]
    assert len(seams) == 1
    assert {use.index for use in seams[0].uses} == {0, 1}


def primitives() -> dict[str, tuple[Any, float, float]]:
    """Shape, area, volume."""
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )

    pi, slant = math.pi, math.hypot(2.0, 3.0)
    return {
        "sphere": (BRepPrimAPI_MakeSphere(2.0).Shape(), 16 * pi, 32 * pi / 3),
        "cone to its apex": (
            BRepPrimAPI_MakeCone(2.0, 0.0, 3.0).Shape(),
            pi * 2 * slant + 4 * pi,
            4 * pi,
        ),
        "torus": (BRepPrimAPI_MakeTorus(3.0, 1.0).Shape(), 12 * pi**2, 6 * pi**2),
    }


@pytest.mark.parametrize("name", ["sphere", "cone to its apex", "torus"])
def test_closed_surfaces_have_their_area_and_volume(tmp_path, name):
    shape, area, volume = primitives()[name]
    body = cg.read_cad(write_step(tmp_path / "p.step", shape))
    assert body.area() == pytest.approx(area, rel=1e-9)
    assert body.volume() == pytest.approx(volume, rel=1e-9)
    round_ones = [k for k, patch in enumerate(body.patches) if patch.is_rational]
    assert all(body.trims[k] is None for k in round_ones)


@pytest.mark.parametrize("start", [0.0, 0.3, 1.0, 2.0, 3.0, 4.5])
def test_whole_turns_are_exact_wherever_they_start(tmp_path, start):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.Geom import Geom_ToroidalSurface
    from OCP.gp import gp_Ax3

    torus = Geom_ToroidalSurface(gp_Ax3(), 3.0, 1.0)
    face = BRepBuilderAPI_MakeFace(
        torus, start, start + 2 * math.pi, 0.7 * start, 0.7 * start + 2 * math.pi, 1e-7
    ).Face()
    body = cg.read_cad(write_step(tmp_path / "t.step", face))
    assert len(body.patches) == 1
    assert body.area() == pytest.approx(12 * math.pi**2, rel=1e-10)
    uv = np.random.default_rng(0).random((200, 2))
    low, high = np.array(body.patches[0].domain).T
    x, y, z = body.patches[0].evaluate(low + uv * (high - low)).T
    assert np.abs(np.hypot(np.hypot(x, y) - 3.0, z) - 1.0).max() < 1e-13


def test_hole_across_the_seam_of_a_cylinder_is_cut_out_once(tmp_path):
    # A bore along the seam's direction (0.6, 0.8): both ends of the domain are cut.
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    bore = BRepPrimAPI_MakeCylinder(
        gp_Ax2(gp_Pnt(0.0, 0.0, 1.5), gp_Dir(0.6, 0.8, 0.0)), 0.5, 10.0
    ).Shape()
    body = cg.read_cad(write_step(tmp_path / "s.step", cut(cylinder(2.0, 3.0), bore)))
    tables = body.trim_tables
    outer = [
        k
        for k, patch in enumerate(body.patches)
        if patch.is_rational
        and np.allclose(np.hypot(*patch.control_points[0, 0, :2]), 2.0)
        and body.trims[k] is not None
    ]
    assert len(outer) == 1
    patch = body.patches[outer[0]]
    low, high = np.array(patch.domain).T
    uv = low + np.random.default_rng(0).random((4000, 2)) * (high - low)
    x, y, z = patch.evaluate(uv).T
    along, aside = 0.6 * x + 0.8 * y, -0.8 * x + 0.6 * y
    off = np.hypot(aside, z - 1.5) - 0.5
    kept = (off > 0.0) | (along < 0.0)
    clear = np.abs(off) > 1e-5
    assert np.array_equal(points_in_trim(tables, outer[0], uv)[clear], kept[clear])
    assert (~kept).sum() > 50


def test_annulus_has_two_loops_and_its_area(tmp_path):
    body = cg.read_cad(write_step(tmp_path / "a.step", cut(cylinder(2.0, 1.0), cylinder(1.0, 1.0))))
    flat = [k for k, patch in enumerate(body.patches) if patch.degrees == (1, 1)]
    assert [len(body.trims[k]) for k in flat] == [2, 2]
    assert np.allclose(patch_areas(body)[flat], 3.0 * math.pi, rtol=1e-10)


def test_trims_of_reversed_faces_are_mirrored_with_them(tmp_path):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    axes = gp_Ax2(gp_Pnt(0.3, 0.7, -1.0), gp_Dir(0.0, 0.0, 1.0))
    bore = BRepPrimAPI_MakeCylinder(axes, 0.2, 9.0).Shape()
    body = cg.read_cad(write_step(tmp_path / "b.step", cut(box(), bore)))
    pierced = [k for k, loops in enumerate(body.trims) if loops is not None]
    assert len(pierced) == 2
    for k in pierced:
        low, high = np.array(body.patches[k].domain).T
        uv = low + np.random.default_rng(k).random((2000, 2)) * (high - low)
        x, y, z = body.patches[k].evaluate(uv).T
        outside = np.hypot(x - 0.3, y - 0.7) > 0.2
        assert np.array_equal(points_in_trim(body.trim_tables, k, uv), outside)
        assert body.patches[k].normal(uv[:1])[0, 2] == pytest.approx(1.0 if z[0] > 1 else -1.0)
    assert body.volume() == pytest.approx(6.0 - 0.12 * math.pi, rel=1e-9)


def test_oblique_cut_of_a_cylinder_has_the_area_of_the_closed_form(tmp_path):
    # Height 3 + x under the plane z = 3 + x: mean height 3, so area 2πr·3 on the side.
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeHalfSpace
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt

    plane = gp_Pln(gp_Pnt(0.0, 0.0, 3.0), gp_Dir(-1.0, 0.0, 1.0))
    face = BRepBuilderAPI_MakeFace(plane).Face()
    above = BRepPrimAPI_MakeHalfSpace(face, gp_Pnt(0.0, 0.0, 100.0)).Solid()
    body = cg.read_cad(write_step(tmp_path / "o.step", cut(cylinder(1.0, 6.0), above)))
    side = next(k for k, patch in enumerate(body.patches) if patch.is_rational)
    assert body.trims[side] is not None
    assert patch_areas(body)[side] == pytest.approx(6.0 * math.pi, rel=1e-7)
    assert body.volume() == pytest.approx(3.0 * math.pi, rel=1e-7)


def test_mirrored_part_keeps_its_normals_outward(tmp_path):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf

    mirror = gp_Trsf()
    mirror.SetMirror(gp_Ax2(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(1.0, 0.0, 0.0)))
    shape = BRepBuilderAPI_Transform(cut(cylinder(2.0, 3.0), cylinder(1.0, 3.0, at=0.5)), mirror)
    body = cg.read_cad(write_step(tmp_path / "m.step", shape.Shape()))
    assert body.volume() == pytest.approx(3.0 * math.pi * 3.0, rel=1e-8)


def test_reading_prints_nothing(tmp_path, capfd):
    write_step(tmp_path / "b.step", box())
    write_iges(tmp_path / "b.iges", box(), "MM")
    capfd.readouterr()
    cg.read_cad(tmp_path / "b.step")
    cg.read_cad(tmp_path / "b.iges")
    assert capfd.readouterr() == ("", "")
