"""Closed solids that OpenCASCADE makes and calls valid, in a few lines each; some with a flaw."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from contiga.io.cad.occ_geometry import quiet

Z = (0.0, 0.0, 1.0)


def axes(place: tuple[float, ...], way: tuple[float, ...] = Z) -> Any:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return gp_Ax2(gp_Pnt(*place), gp_Dir(*way))


def parts(shape: Any, kind: str) -> list[Any]:
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"))
    values = []
    while explorer.More():
        values.append(explorer.Current())
        explorer.Next()
    return values


def cylinder(r: float, h: float, place: tuple[float, ...], way: tuple[float, ...] = Z) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(axes(place, way), r, h).Shape()


def block(low: tuple[float, ...], high: tuple[float, ...]) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()


def filleted(shape: Any, radius: float) -> Any:
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.TopoDS import TopoDS

    fillet = BRepFilletAPI_MakeFillet(shape)
    for edge in parts(shape, "EDGE"):
        fillet.Add(radius, TopoDS.Edge(edge))
    return fillet.Shape()


def link_rod() -> Any:
    """Two cylinders with bores, joined by a web, all edges filleted."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    rod = BRepAlgoAPI_Fuse(cylinder(10, 10, (0, 0, 0)), cylinder(7, 10, (40, 0, 0))).Shape()
    rod = BRepAlgoAPI_Fuse(rod, block((0, -4, 2), (40, 4, 8))).Shape()
    for r, x in ((5, 0), (3, 40)):
        rod = BRepAlgoAPI_Cut(rod, cylinder(r, 20, (x, 0, -5))).Shape()
    whole = ShapeUpgrade_UnifySameDomain(rod)
    whole.Build()
    return filleted(whole.Shape(), 0.8)


def crossing_bores() -> Any:
    """A block with three bores whose axes pass each other."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    shape = block((-10, -10, -10), (10, 10, 10))
    bores = ((5, (1, 0, 0), (-20, 0.3, 0)), (4, (0, 1, 0), (0, -20, 0.3)), (4.5, Z, (0.3, 0, -20)))
    for radius, way, place in bores:
        shape = BRepAlgoAPI_Cut(shape, cylinder(radius, 40, place, way)).Shape()
    return shape


def rounded_box() -> Any:
    return filleted(block((0, 0, 0), (10, 6, 4)), 1.0)


def slot() -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(
        block((-10, -6, 0), (10, 6, 8)), block((-0.5, -10, 4), (0.5, 10, 10))
    ).Shape()


def cup() -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(cylinder(5, 10, (0, 0, 0)), cylinder(4, 10, (0, 0, 1))).Shape()


def shell() -> Any:
    """A hollow box, open at the top."""
    from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeThickSolid
    from OCP.collections import List_TopoDS_Shape

    box = block((0, 0, 0), (10, 8, 6))
    top = List_TopoDS_Shape()
    top.Append(parts(box, "FACE")[5])
    maker = BRepOffsetAPI_MakeThickSolid()
    maker.MakeThickSolidByJoin(box, top, -0.5, 1e-4)
    return maker.Shape()


def cone() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    return BRepPrimAPI_MakeCone(4.0, 0.0, 9.0).Shape()


def lens() -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    from OCP.gp import gp_Pnt

    one = BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 0), 5.0).Shape()
    two = BRepPrimAPI_MakeSphere(gp_Pnt(6, 0, 0), 5.0).Shape()
    return BRepAlgoAPI_Common(one, two).Shape()


def torus() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return BRepPrimAPI_MakeTorus(6.0, 2.0).Shape()


def sphere() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    return BRepPrimAPI_MakeSphere(3.0).Shape()


SOLIDS: dict[str, Callable[[], Any]] = {
    maker.__name__: maker
    for maker in (
        link_rod, crossing_bores, rounded_box, slot, cup, shell, cone, lens, torus, sphere
    )
}  # fmt: skip


def sewn(faces: list[Any], tolerance: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing

    sewing = BRepBuilderAPI_Sewing(tolerance)
    for face in faces:
        sewing.Add(face)
    sewing.Perform()
    return sewing.SewedShape()


def lifted(face: Any, by: tuple[float, ...]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf, gp_Vec

    move = gp_Trsf()
    move.SetTranslation(gp_Vec(*by))
    return BRepBuilderAPI_Transform(face, move, True).Shape()


def gaping_box(gap: float) -> Any:
    """A box of side 10 whose top is `gap` too high, sewn together all the same."""
    faces = parts(block((0, 0, 0), (10, 10, 10)), "FACE")
    return sewn([*faces[:5], lifted(faces[5], (0, 0, gap))], 2.0 * gap)


def lidless_box() -> Any:
    return sewn(parts(block((0, 0, 0), (10, 10, 10)), "FACE")[:5], 1e-6)


def compound(faces: list[Any]) -> Any:
    """Faces side by side, which share nothing."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    made, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(made)
    for face in faces:
        builder.Add(made, face)
    return made


def write(shape: Any, path: Path) -> Path:
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    with quiet():
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
    return path


def is_valid(shape: Any) -> bool:
    from OCP.BRepCheck import BRepCheck_Analyzer

    return bool(BRepCheck_Analyzer(shape).IsValid())


def edge_uses(shape: Any) -> dict[int, int]:
    """How many edges are used once, twice, …; degenerate ones left out."""
    from collections import Counter

    from OCP.BRep import BRep_Tool
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
    from OCP.TopoDS import TopoDS

    known = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    uses: Counter[int] = Counter()
    for face in parts(shape, "FACE"):
        for edge in parts(face, "EDGE"):
            if not BRep_Tool.Degenerated_s(TopoDS.Edge(edge)):
                uses[known.Add(edge)] += 1
    return dict(Counter(uses.values()))


def rim(face: Any) -> float:
    """Length of the edges of a face, seams left out."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    total = GProp_GProps()
    BRepGProp.LinearProperties_s(face, total)
    return float(total.Mass())


def plain_shape(path: Path) -> Any:
    """The shape of a STEP or IGES file, in millimetres, without a document of names."""
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    iges = path.suffix.lower() in (".igs", ".iges")
    reader = IGESControl_Reader() if iges else STEPControl_Reader()
    with quiet():
        reader.ReadFile(str(path))
        reader.TransferRoots()
    return reader.OneShape()


def sewn_shape(path: Path) -> Any:
    """The shape of a STEP or IGES file, its loose faces sewn together."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    shape = plain_shape(path)
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    size = box.CornerMin().Distance(box.CornerMax())
    return sewn(parts(shape, "FACE"), 1e-6 * size) if 1 in edge_uses(shape) else shape
