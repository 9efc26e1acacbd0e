"""Assemblies that OpenCASCADE writes: named, coloured, placed; and what is known of them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from tests.occ_solids import parts

from contiga.io.cad.occ_geometry import quiet
from contiga.io.cad.occ_parts import new_document

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def box(a: float = 2.0, b: float = 3.0, c: float = 4.0) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    return BRepPrimAPI_MakeBox(a, b, c).Shape()


def pin() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(1.0, 5.0).Shape()


def cup() -> Any:
    """A cube of side 1 without its lid, an open shell."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell

    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    for face in parts(box(1.0, 1.0, 1.0), "FACE")[:5]:
        builder.Add(shell, face)
    return shell


def together(*shapes: Any) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    builder, compound = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def at(x: float, y: float, z: float, degrees: float = 0.0) -> Any:
    """Turned about z, then moved."""
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    move = gp_Trsf()
    if degrees:
        move.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), math.radians(degrees))
    move.SetTranslationPart(gp_Vec(x, y, z))
    return TopLoc_Location(move)


class Rig:
    """A document to which products and assemblies are added by name."""

    def __init__(self) -> None:
        from OCP.XCAFDoc import XCAFDoc_DocumentTool

        with quiet():
            self.document = new_document()
        self._shapes = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        self._colours = XCAFDoc_DocumentTool.ColorTool_s(self.document.Main())

    def product(self, shape: Any, name: str, colour: tuple[float, ...] | None = None) -> Any:
        from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
        from OCP.XCAFDoc import XCAFDoc_ColorType

        label = self._shapes.AddShape(shape, False)
        if colour is not None:
            own = Quantity_Color(*colour, Quantity_TypeOfColor.Quantity_TOC_sRGB)
            self._colours.SetColor(label, own, XCAFDoc_ColorType.XCAFDoc_ColorGen)
        return self._named(label, name)

    def assembly(self, name: str, *members: tuple[Any, Any, str]) -> Any:
        label = self._shapes.NewShape()
        for product, place, instance in members:
            self._named(self._shapes.AddComponent(label, product, place), instance)
        return self._named(label, name)

    def _named(self, label: Any, name: str) -> Any:
        from OCP.TCollection import TCollection_ExtendedString
        from OCP.TDataStd import TDataStd_Name

        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
        return label

    def write(self, path: Path, unit: str = "MM") -> Path:
        from OCP.IGESCAFControl import IGESCAFControl_Writer
        from OCP.IGESControl import IGESControl_Controller
        from OCP.Interface import Interface_Static
        from OCP.STEPCAFControl import STEPCAFControl_Writer
        from OCP.STEPControl import STEPControl_StepModelType

        with quiet():
            self._shapes.UpdateAssemblies()
            if path.suffix == ".iges":
                IGESControl_Controller.Init_s()
                Interface_Static.SetIVal_s("write.iges.brep.mode", 1)
                writer = IGESCAFControl_Writer()
                writer.Transfer(self.document)
            else:
                writer = STEPCAFControl_Writer()
                Interface_Static.SetCVal_s("write.step.unit", unit)
                writer.Transfer(self.document, STEPControl_StepModelType.STEPControl_AsIs)
                Interface_Static.SetCVal_s("write.step.unit", "MM")
            assert writer.Write(str(path))
        return path


def rig(path: Path, unit: str = "MM") -> Path:
    """A box, a cup and, in two arms, four blocks of one product: seven parts and 35 faces.

    ::

        rig ─ box 1 (box, red) · cup 1 (cup)
            ├ left arm (arm, at x = 100) ─ front (block) at y = 0 · back (block) at y = 50, 90°
            └ right arm (arm, at x = 200) ─ the same
    """
    made = Rig()
    block = made.product(box(4.0, 2.0, 1.0), "block", BLUE)
    arm = made.assembly("arm", (block, at(0, 0, 0), "front"), (block, at(0, 50, 0, 90.0), "back"))
    made.assembly(
        "rig",
        (made.product(box(), "box", RED), at(0, 0, 0), "box 1"),
        (made.product(cup(), "cup"), at(0, 0, 30), "cup 1"),
        (arm, at(100, 0, 0), "left arm"),
        (arm, at(200, 0, 0), "right arm"),
    )
    return made.write(path, unit)
