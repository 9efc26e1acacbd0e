"""The generated solids as OpenCASCADE makes them: shapes to be written to STEP."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tests.stress.fields import Piece


def solid_box(low: Sequence[float], high: Sequence[float]) -> Any:
    """A box by its corners."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()


def solid_tube(axis: int, radius: float, low: Sequence[float], length: float) -> Any:
    """A cylinder along x, y or z that begins at `low`."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    direction = [0.0, 0.0, 0.0]
    direction[axis] = 1.0
    axes = gp_Ax2(gp_Pnt(*low), gp_Dir(*direction))
    return BRepPrimAPI_MakeCylinder(axes, radius, length).Shape()


def solid_ball(centre: Sequence[float], radius: float) -> Any:
    """A ball."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeSphere(gp_Pnt(*centre), radius).Shape()


def solid_cone(radius: float, height: float) -> Any:
    """A cone with an apex."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    return BRepPrimAPI_MakeCone(radius, 0.0, height).Shape()


def solid_torus(major: float, minor: float) -> Any:
    """A ring about z."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return BRepPrimAPI_MakeTorus(major, minor).Shape()


def cut(shape: Any, *tools: Any) -> Any:
    """`shape` without the tools, one after the other."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    return shape


def fused(shape: Any, *others: Any) -> Any:
    """The union of shapes, one after the other."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    for other in others:
        shape = BRepAlgoAPI_Fuse(shape, other).Shape()
    return shape


def unified(shape: Any) -> Any:
    """`shape` with faces of one surface that adjoin made one, edges too."""
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    unify = ShapeUpgrade_UnifySameDomain(shape)
    unify.Build()
    return unify.Shape()


def placed(shape: Any, matrix: Any, shift: Any) -> Any:
    """`shape` by a rotation matrix that may have a factor, then moved: a copy of its own."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    rows = [[*row, by] for row, by in zip(matrix.tolist(), map(float, shift), strict=True)]
    move.SetValues(*(value for row in rows for value in row))
    return BRepBuilderAPI_Transform(shape, move, True).Shape()


def turned(shape: Any, about: Sequence[float], axis: int, angle: float) -> Any:
    """`shape` turned about an axis along x, y or z through `about`, rad."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf

    direction = [0.0, 0.0, 0.0]
    direction[axis] = 1.0
    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(*about), gp_Dir(*direction)), angle)
    return BRepBuilderAPI_Transform(shape, turn, True).Shape()


def compound(shapes: Sequence[Any]) -> Any:
    """Shapes side by side."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    builder, made = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(made)
    for shape in shapes:
        builder.Add(made, shape)
    return made


def common_part(shape: Any, other: Any) -> Any:
    """What lies in both."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

    return BRepAlgoAPI_Common(shape, other).Shape()


def rounded(shape: Any, radius: float) -> Any:
    """Every edge of `shape` filleted."""
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    maker = BRepFilletAPI_MakeFillet(shape)
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        maker.Add(radius, TopoDS.Edge(explorer.Current()))
        explorer.Next()
    return maker.Shape()


def hollowed(shape: Any, thickness: float, top: float) -> Any:
    """Walls of `thickness` inside `shape`, open at its face in the plane z = `top`."""
    from OCP.BRepGProp import BRepGProp
    from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeThickSolid
    from OCP.collections import List_TopoDS_Shape
    from OCP.GProp import GProp_GProps
    from tests.cases.occ import faces_of

    opened = List_TopoDS_Shape()
    for face in faces_of(shape):
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties)
        if abs(properties.CentreOfMass().Z() - top) < 1e-9 * abs(top):
            opened.Append(face)
    maker = BRepOffsetAPI_MakeThickSolid()
    maker.MakeThickSolidByJoin(shape, opened, -thickness, 1e-6)
    return maker.Shape()


def prism(loops: Sequence[Sequence[Piece]], low: float, high: float) -> Any:
    """A profile in (x, y), its first loop the outer one, given the extent low … high in z."""
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeWire,
    )
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Pnt, gp_Vec

    def point(xy: Any) -> Any:
        return gp_Pnt(float(xy[0]), float(xy[1]), low)

    def wire(loop: Sequence[Piece]) -> Any:
        maker = BRepBuilderAPI_MakeWire()
        for piece in loop:
            a, b = point(piece.a), point(piece.b)
            if piece.centre is None:
                maker.Add(BRepBuilderAPI_MakeEdge(a, b).Edge())
            else:
                arc = GC_MakeArcOfCircle(a, point(piece.middle()), b).Value()
                maker.Add(BRepBuilderAPI_MakeEdge(arc).Edge())
        return maker.Wire()

    maker = BRepBuilderAPI_MakeFace(wire(loops[0]), True)
    face = maker.Face()
    upright = BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, high - low)).Shape()
    holes = (prism([loop], low - 1.0, high + 1.0) for loop in loops[1:])
    return cut(upright, *holes)


def polyhedron(outlines: Sequence[Any]) -> Any:
    """The solid between plane polygons, each (k, 3), counter-clockwise as seen from outside."""
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakePolygon,
        BRepBuilderAPI_MakeSolid,
        BRepBuilderAPI_Sewing,
    )
    from OCP.gp import gp_Pnt
    from OCP.TopoDS import TopoDS

    sewing = BRepBuilderAPI_Sewing(1e-9)
    for corners in outlines:
        polygon = BRepBuilderAPI_MakePolygon()
        for corner in corners:
            polygon.Add(gp_Pnt(*map(float, corner)))
        polygon.Close()
        sewing.Add(BRepBuilderAPI_MakeFace(polygon.Wire(), True).Face())
    sewing.Perform()
    return BRepBuilderAPI_MakeSolid(TopoDS.Shell(sewing.SewedShape())).Solid()
