"""read_cad: the door, G+Smo, 3DM, and all that can be wrong with a file."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning, FileError, UnitError
from contiga.io.cad.loops import PCurve, align_loops, chain_pcurves, ends, rectangle_sides
from contiga.io.cad.warp import AngleMap, identity, map_pcurve
from contiga.masters.body_summary import body_summary

PATCH = """
 <Geometry type="TensorBSpline2" id="{id}">
  <Basis type="TensorBSplineBasis2">
   <Basis type="BSplineBasis" index="0"><KnotVector degree="1">0 0 2 2</KnotVector></Basis>
   <Basis type="BSplineBasis" index="1"><KnotVector degree="1">0 0 1 1</KnotVector></Basis>
  </Basis>
  <coefs geoDim="3">{coefs}</coefs>
 </Geometry>"""
ONE = PATCH.format(id=0, coefs="0 0 0  2 0 0  0 1 0  2 1 0")
NEXT = PATCH.format(id=1, coefs="4 0 1  2 0 0  4 1 1  2 1 0")


def xml(path: Path, *parts: str) -> Path:
    path.write_text("<?xml version='1.0'?><xml>" + "".join(parts) + "</xml>")
    return path


def test_gismo_coefs_run_first_along_the_first_direction(tmp_path):
    body = cg.read_cad(xml(tmp_path / "a.xml", ONE))
    assert body.name == "a"
    assert body.unit is None
    patch = body.patches[0]
    assert patch.domain == ((0, 2), (0, 1))
    assert np.allclose(patch.evaluate([[2.0, 0.0], [0.0, 1.0]]), [[2, 0, 0], [0, 1, 0]])
    assert np.allclose(patch.normal([[1.0, 0.5]]), [[0, 0, 1]])


def test_gismo_patches_that_meet_share_an_edge(tmp_path):
    body = cg.read_cad(xml(tmp_path / "a.xml", ONE, NEXT))
    shared = [edge for edge in body.edges if len(edge.uses) == 2]
    assert len(shared) == 1
    assert len(body.edges) == 7
    assert {(use.patch, use.index) for use in shared[0].uses} == {(0, 1), (1, 1)}
    assert {use.reversed for use in shared[0].uses} == {False}


def test_gismo_weights_make_a_quarter_cylinder(tmp_path):
    w = math.sqrt(0.5)
    text = f"""
     <Geometry type="TensorNurbs2"><Basis type="TensorNurbsBasis2"><Basis>
      <Basis index="0"><KnotVector degree="2">0 0 0 1 1 1</KnotVector></Basis>
      <Basis index="1"><KnotVector degree="1">0 0 1 1</KnotVector></Basis></Basis>
      <weights>1 {w!r} 1 1 {w!r} 1</weights></Basis>
      <coefs geoDim="3">1 0 0  1 1 0  0 1 0  1 0 3  1 1 3  0 1 3</coefs></Geometry>"""
    body = cg.read_cad(xml(tmp_path / "q.xml", text))
    assert body.area() == pytest.approx(1.5 * math.pi, rel=1e-12)


def test_gismo_numbers_are_converted_only_if_their_unit_is_given(tmp_path):
    path = xml(tmp_path / "a.xml", ONE)
    plain = cg.read_cad(path, unit="mm")
    assert plain.unit is None
    assert plain.bounds()[1, 0] == 2.0
    inches = cg.read_cad(path, unit="mm", file_unit="in")
    assert inches.unit == "mm"
    assert inches.bounds()[1, 0] == pytest.approx(50.8)
    assert cg.read_cad(path, file_unit="in").unit == "in"


def test_gismo_geometry_of_other_kinds_is_left_out_with_a_warning(tmp_path):
    path = xml(tmp_path / "a.xml", ONE, "<Geometry type='THBSpline2'></Geometry>")
    with pytest.warns(ContigaWarning, match="THBSpline2"):
        assert len(cg.read_cad(path).patches) == 1


STEP_HEAD = "ISO-10303-21;\nHEADER;\nENDSEC;\n"
BAD = {
    "empty.step": ("", "empty.step: the file is empty"),
    "empty.3dm": ("", "the file is empty"),
    "text.step": ("solid cube\n", "not a STEP file; found 'solid cube"),
    "cut.step": (STEP_HEAD + "DATA;\n#1=CARTESIAN_POINT('',(0.,0.", "no faces found|damaged"),
    "void.step": (STEP_HEAD + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n", "no faces found|damaged"),
    "text.iges": ("hello\n", "not an IGES file; found 'hello'"),
    "short.igs": (" " * 72 + "S      1\n", "no faces found|damaged"),
    "text.3dm": ("hello\n", "not a 3DM file"),
    "cut.3dm": ("3D Geometry File Format        8", "not a 3DM file, or a damaged one"),
    "text.xml": ("hello\n", "not well-formed XML"),
    "other.xml": ("<VTKFile/>", "not a G\\+Smo file; found 'VTKFile'"),
    "none.xml": ("<xml></xml>", "no faces found"),
    "counts.xml": ("<xml>" + ONE.replace("2 1 0", "2 1") + "</xml>", "coefs does not fit"),
    "words.xml": ("<xml>" + ONE.replace("2 1 0", "2 1 x") + "</xml>", "other than numbers"),
    "knots.xml": ("<xml>" + ONE.replace("0 0 2 2", "0 2 0 2") + "</xml>", "geometry 0: .*knots"),
    "nan.xml": ("<xml>" + ONE.replace("2 1 0", "2 1 nan") + "</xml>", "geometry 0"),
    "degree.xml": ("<xml>" + ONE.replace('degree="1"', 'degree="x"') + "</xml>", "whole degree"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_named_with_what_is_wrong(tmp_path, name, capfd):
    text, words = BAD[name]
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(FileError, match=words) as caught:
        cg.read_cad(path)
    assert str(path) in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_missing_files_and_folders_are_named(tmp_path):
    with pytest.raises(FileError, match=r"gone\.step: no such file"):
        cg.read_cad(tmp_path / "gone.step")
    (tmp_path / "folder.step").mkdir()
    with pytest.raises(FileError, match="not a file"):
        cg.read_cad(tmp_path / "folder.step")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_files_that_may_not_be_read_are_named(tmp_path):
    path = xml(tmp_path / "a.xml", ONE)
    path.chmod(0)
    with pytest.raises(FileError, match="cannot be read"):
        cg.read_cad(path)


def test_unknown_suffixes_get_the_list_and_a_suggestion(tmp_path):
    with pytest.raises(FileError, match=r"allowed: \.step, .*Did you mean \.step\?"):
        cg.read_cad(tmp_path / "part.stepp")


@pytest.mark.parametrize("key", ["unit", "file_unit"])
def test_wrong_units_are_refused_before_anything_is_read(tmp_path, key):
    path = xml(tmp_path / "a.xml", ONE)
    with pytest.raises(UnitError, match=f"{key}: not a unit of length"):
        cg.read_cad(path, **{key: "kg"})
    with pytest.raises(UnitError, match=f"{key}: not a known unit"):
        cg.read_cad(path, **{key: "milli"})


def rhino_file(path: Path, *geometry: object, unit: str = "Millimeters") -> Path:
    import rhino3dm

    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, unit)
    for item in geometry:
        model.Objects.Add(item)
    assert model.Write(str(path), 7)
    return path


def rhino_shapes() -> dict[str, tuple[object, int, int, float]]:
    """Geometry, faces, trimmed faces, area."""
    import rhino3dm as r

    origin, pi = r.Point3d(0, 0, 0), math.pi
    tube = r.Cylinder(r.Circle(origin, 1.0), 2.0)
    box = r.Box(r.BoundingBox(origin, r.Point3d(1, 2, 3)))
    disc = r.Circle(origin, 1.5).ToNurbsCurve()
    return {
        "box": (r.Brep.CreateFromBox(box), 6, 0, 22.0),
        "sphere": (r.Brep.CreateFromSphere(r.Sphere(origin, 2.0)), 1, 0, 16 * pi),
        "capped cylinder": (r.Brep.CreateFromCylinder(tube, True, True), 3, 2, 6 * pi),
        "disc": (r.Brep.CreateTrimmedPlane(r.Plane.WorldXY(), disc), 1, 1, 2.25 * pi),
        "extrusion": (r.Extrusion.CreateCylinderExtrusion(tube, True, True), 3, 2, 6 * pi),
        "pipe": (r.Extrusion.CreatePipeExtrusion(tube, 0.5, True, True), 4, 2, 7.5 * pi),
        "surface": (r.NurbsSurface.CreateFromSphere(r.Sphere(origin, 2.0)), 1, 0, 16 * pi),
    }


@pytest.mark.parametrize(
    "name", ["box", "sphere", "capped cylinder", "disc", "extrusion", "pipe", "surface"]
)
def test_rhino_faces_are_read_with_their_trims(tmp_path, name):
    geometry, faces, trimmed, area = rhino_shapes()[name]
    body = cg.read_cad(rhino_file(tmp_path / "a.3dm", geometry))
    assert len(body.patches) == faces
    assert sum(loops is not None for loops in body.trims) == trimmed
    assert body.area() == pytest.approx(area, rel=1e-9)
    assert body.unit == "mm"


@pytest.mark.parametrize(
    ("name", "volume"),
    [("box", 6.0), ("sphere", 32 * math.pi / 3), ("capped cylinder", 2 * math.pi)],
)
def test_rhino_solids_are_oriented_outward_and_have_no_free_edges(tmp_path, name, volume):
    body = cg.read_cad(rhino_file(tmp_path / "a.3dm", rhino_shapes()[name][0]))
    assert body.volume() == pytest.approx(volume, rel=1e-9)
    assert all(len(edge.uses) == 2 for edge in body.edges)


def cap_of_a_sphere(axis: tuple[float, float, float]) -> cg.Body:
    """A sphere of radius 2 cut by the edge of a cap of height ½ about `axis`, p-curve missing."""
    from contiga.io.cad.assemble import Assembly
    from contiga.io.cad.projected_faces import ProjectedFace, Trim, add_projected

    n = np.array(axis) / np.linalg.norm(axis)
    x = np.cross(n, [0.1, 0.9, 0.3])
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3] = np.stack([x, np.cross(n, x), n, 1.5 * n], axis=1)
    circle = cg.shapes.circle(radius=math.sqrt(4 - 1.5**2)).transformed(frame)
    assembly = Assembly("cap")
    face = ProjectedFace(cg.shapes.sphere(radius=2.0), [[Trim(0, False)]], False, "cap, face 0")
    add_projected(assembly, face, [circle], 1e-6)
    return assembly.body("cap", lambda _: None, None)


@pytest.mark.parametrize(
    "axis", [(-1.0, 0.2, 0.3), (1.0, 1.0, 0.0), (1.0, 0.0, 0.3), (0.1, -0.2, 1.0), (0.0, 0.0, -1.0)]
)
def test_missing_pcurves_on_curved_faces_are_drawn_exactly(axis):
    """Also over the seam, and round a pole."""
    assert cap_of_a_sphere(axis).area() == pytest.approx(2 * math.pi, rel=1e-11)


def test_a_surface_that_is_approximated_is_told_with_its_miss(solids, tmp_path):
    """An offset of a free-form sheet, whose truth is the sheet and its normals."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.collections import Array2_gp_Pnt
    from OCP.Geom import Geom_BezierSurface, Geom_OffsetSurface
    from OCP.gp import gp_Pnt

    x = np.linspace(0.0, 60.0, 4)
    net = np.array([[[a, b, 3 * np.sin(a / 9) * np.cos(b / 11)] for b in x] for a in x])
    poles = Array2_gp_Pnt(1, 4, 1, 4)
    for i, j in np.ndindex(4, 4):
        poles.SetValue(i + 1, j + 1, gp_Pnt(*net[i, j].tolist()))
    offset = Geom_OffsetSurface(Geom_BezierSurface(poles), 2.0)
    face = BRepBuilderAPI_MakeFace(offset, 1e-6).Face()
    path = solids.write(face, tmp_path / "offset.step")
    with pytest.warns(
        ContigaWarning, match=r"face 1: its surface has no NURBS form.*to \d"
    ) as warned:
        body = cg.read_cad(path)
    said = float(str(warned[0].message).rsplit(" ", 1)[1])
    sheet = cg.NurbsSurface((3, 3), ([0.0] * 4 + [1.0] * 4,) * 2, net)
    uv = np.random.default_rng(0).random((300, 2))
    there = sheet.evaluate(uv) + 2.0 * sheet.normal(uv)
    off = np.linalg.norm(body.patches[0].evaluate(uv) - there, axis=1).max()
    assert 0.1 * said < off < 1.5 * said


def test_rhino_unit_is_converted(tmp_path):
    path = rhino_file(tmp_path / "a.3dm", rhino_shapes()["box"][0], unit="Inches")
    assert cg.read_cad(path).unit == "in"
    body = cg.read_cad(path, unit="mm")
    assert np.allclose(body.bounds()[1], [25.4, 50.8, 76.2])
    assert cg.read_cad(path, unit="mm", file_unit="m").bounds()[1, 0] == pytest.approx(1000.0)


def test_rhino_instances_are_placed_and_their_definition_is_not(tmp_path):
    import rhino3dm as r

    model = r.File3dm()
    model.Settings.ModelUnitSystem = r.UnitSystem.Millimeters
    part = rhino_shapes()["box"][0]
    index = model.InstanceDefinitions.Add(
        "part", "", "", "", r.Point3d(0, 0, 0), (part,), (r.ObjectAttributes(),)
    )
    definition = model.InstanceDefinitions[index]
    for turn, shift in ((0.0, 10.0), (math.pi / 2, 20.0)):
        turned = r.Transform.Rotation(turn, r.Vector3d(0, 0, 1), r.Point3d(0, 0, 0))
        placed = r.Transform.Multiply(r.Transform.Translation(r.Vector3d(shift, 0, 0)), turned)
        model.Objects.AddInstanceObject(r.InstanceReference(definition.Id, placed))
    assert model.Write(str(tmp_path / "i.3dm"), 7)
    body = cg.read_cad(tmp_path / "i.3dm")
    assert len(body.patches) == 12
    assert np.allclose(body.bounds(), [[10, 0, 0], [20, 2, 3]], atol=1e-12)
    assert body.volume() == pytest.approx(12.0, rel=1e-12)


def test_rhino_meshes_and_curves_are_left_out_with_a_warning(tmp_path):
    import rhino3dm as r

    curve = r.Circle(r.Point3d(0, 0, 0), 1.5).ToNurbsCurve()
    path = rhino_file(tmp_path / "a.3dm", rhino_shapes()["box"][0], curve)
    with pytest.warns(ContigaWarning, match="NurbsCurve were left out"):
        assert len(cg.read_cad(path).patches) == 6
    only = rhino_file(tmp_path / "b.3dm", curve)
    with pytest.warns(ContigaWarning), pytest.raises(FileError, match="no faces found"):
        cg.read_cad(only)


def test_angle_map_takes_angles_to_the_parameters_of_the_rational_arc():
    half = math.pi / 3
    arc = cg.NurbsCurve(
        2,
        [0, 0, 0, 2 * half, 2 * half, 2 * half],
        [[1, 0], [1, math.tan(half)], [math.cos(2 * half), math.sin(2 * half)]],
        [1, math.cos(half), 1],
    )
    angle = np.linspace(0, 2 * half, 50)
    points = arc.evaluate(AngleMap(np.array([0.0, 2 * half]))(angle))
    assert np.allclose(points[:, :2], np.stack([np.cos(angle), np.sin(angle)], 1), atol=1e-14)


def test_bent_curves_follow_the_map_and_lines_along_u_or_v_stay_lines():
    maps = (AngleMap(np.linspace(0, 2 * math.pi, 4)), identity)
    span = np.array([2 * math.pi, 1.0])
    wave = cg.NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], [[0.3, 0], [2, 3], [4, -2], [6, 1]])
    actual = map_pcurve(wave, maps, span)
    t = np.linspace(0, 1, 500)
    wanted = wave.evaluate(t)
    wanted[:, 0] = maps[0](wanted[:, 0])
    assert np.abs(actual.evaluate(t) - wanted).max() <= 1e-9
    level = cg.NurbsCurve(1, [0, 0, 1, 1], [[0.3, 0.5], [5, 0.5]])
    assert map_pcurve(level, maps, span).degree == 1
    assert map_pcurve(wave, (identity, identity), span) is wave


def pcurve(*points: tuple[float, float]) -> PCurve:
    knots = np.repeat(np.linspace(0, 1, len(points)), [2, *[1] * (len(points) - 2), 2])
    return PCurve(cg.NurbsCurve(1, knots, points), 0, False, 1e-7)


def test_strands_out_of_order_and_a_period_off_are_chained():
    a, b = pcurve((0, 0), (6, 0)), pcurve((0, 0), (0, 1))
    c, d = pcurve((6, 1), (0, 1)), pcurve((0, 1), (0, 0))
    loop = chain_pcurves([a, c, b, d], np.array([6.0, 0.0]))
    tails = np.array([ends(s) for s in loop])
    assert np.allclose(tails[:, 1], np.roll(tails[:, 0], -1, axis=0))
    assert np.allclose(np.ptp(tails.reshape(-1, 2), axis=0), [6, 1])


def test_inner_loops_a_period_off_are_brought_into_the_outer_one():
    square = [pcurve((0, 0), (6, 0), (6, 1), (0, 1), (0, 0))]
    hole = [pcurve((8, 0.2), (9, 0.2), (9, 0.8), (8, 0.2))]
    loops = align_loops([square, hole], np.array([6.0, 0.0]))
    assert np.allclose(ends(loops[1][0])[0], [2, 0.2])


def test_rectangles_are_told_from_what_only_touches_all_sides():
    box, speed = np.array([[0.0, 0.0], [2.0, 1.0]]), np.array([1.0, 1.0])
    corners = [(0, 0), (2, 0), (2, 1), (0, 1)]
    sides = [pcurve(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    actual = rectangle_sides(sides, box, speed)
    assert actual is not None
    assert actual.side == [2, 1, 3, 0]
    assert actual.against == [False, False, True, True]
    assert actual.span == [(0, 2), (0, 1), (0, 2), (0, 1)]
    halves = [pcurve((0, 0), (1, 0)), pcurve((1, 0), (2, 0)), *sides[1:]]
    assert rectangle_sides(halves, box, speed) is not None
    notched = [sides[0], pcurve((2, 0), (1.9, 0.5), (2, 1)), *sides[2:]]
    assert rectangle_sides(notched, box, speed) is None
    diamond = [(1, 0), (2, 0.5), (1, 1), (0, 0.5)]
    loop = [pcurve(diamond[i], diamond[(i + 1) % 4]) for i in range(4)]
    assert rectangle_sides(loop, box, speed) is None


def test_summary_is_to_hand_where_the_command_line_looks_for_it(tmp_path):
    assert body_summary(cg.read_cad(xml(tmp_path / "a.xml", ONE)))["patches"] == 1
