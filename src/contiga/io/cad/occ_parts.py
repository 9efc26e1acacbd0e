"""Contents of OpenCASCADE's document of a file: placed parts with names and colours.

Products stand in assemblies by references with a placement; a product may hold several solids,
shells and faces. Each of them, where it stands, is a piece here; loose faces that share edges make
one part, whatever each is called.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from contiga.io.cad.parts import FaceLabel, PartLabel
from contiga.io.cad.sew import Sewn, members, subshapes

_SURFACES = {
    "Geom_Plane": "plane",
    "Geom_CylindricalSurface": "cylinder",
    "Geom_ConicalSurface": "cone",
    "Geom_SphericalSurface": "sphere",
    "Geom_ToroidalSurface": "torus",
    "Geom_BSplineSurface": "B-spline",
    "Geom_BezierSurface": "Bézier",
    "Geom_SurfaceOfRevolution": "of revolution",
    "Geom_SurfaceOfLinearExtrusion": "extruded",
    "Geom_OffsetSurface": "offset",
    "Geom_RectangularTrimmedSurface": "trimmed",
}


class Piece(NamedTuple):
    """A solid, a shell that bounds none, or a face of no shell, placed."""

    kind: str
    """"solid", "shell" or "face"."""
    shape: Any
    faces: list[Any]
    """Its faces, TopoDS_Face."""
    called: _Called
    face_called: list[_Called]
    place: tuple[str, ...]
    others: tuple[str, ...]


class _Called(NamedTuple):
    name: str | None
    colour: str | None


NAMELESS = _Called(None, None)


class _Way(NamedTuple):
    """The path from the outermost assembly down to a label."""

    location: Any
    place: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    colour: str | None = None


def new_document() -> Any:
    """Return an empty document for `STEPCAFControl_Reader` or `IGESCAFControl_Reader` to fill."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    XCAFDoc_ShapeTool.SetAutoNaming_s(False)  # otherwise shapes without a name are called COMPOUND
    kind = TCollection_ExtendedString("MDTV-XCAF")
    document = TDocStd_Document(kind)
    XCAFApp_Application.GetApplication_s().NewDocument(kind, document)
    return document


def pieces_of(document: Any) -> list[Piece]:
    """Return all pieces of a document in the order of the file."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    free = Sequence_TDF_Label()
    shapes.GetFreeShapes(free)
    walk, start = _Walk(shapes), _Way(TopLoc_Location())
    return [piece for label in _items(free) for piece in walk.under(label, start)]


class _Walk(NamedTuple):
    """A traversal of the labels of a document."""

    shapes: Any

    def under(self, label: Any, way: _Way) -> Iterator[Piece]:
        """Yield the pieces of a label that may refer to a product elsewhere."""
        from OCP.TDF import TDF_Label

        if not self.shapes.IsReference_s(label):
            yield from self._within(label, way, None)
            return
        product = TDF_Label()
        self.shapes.GetReferredShape_s(label, product)
        name = _name(label) or _name(product)
        place = way.place if name is None else (*way.place, name)
        location = way.location.Multiplied(self.shapes.GetLocation_s(label))
        way = way._replace(location=location, place=place)
        yield from self._within(product, way, _colour(label))

    def _within(self, product: Any, way: _Way, colour: str | None) -> Iterator[Piece]:
        """Yield the pieces of a product; `colour` is that of the instance."""
        from OCP.collections import Sequence_TDF_Label

        called = _Called(_name(product), colour or _colour(product) or way.colour)
        if not self.shapes.IsAssembly_s(product):
            yield from self._leaf(product, way, called)
            return
        others = way.others if called.name is None else (*way.others, called.name)
        way = way._replace(others=others, colour=called.colour)
        components = Sequence_TDF_Label()
        self.shapes.GetComponents_s(product, components, False)
        for component in _items(components):
            yield from self.under(component, way)

    def _leaf(self, product: Any, way: _Way, called: _Called) -> Iterator[Piece]:
        from OCP.TopoDS import TopoDS

        inner = _Inner(self.shapes, product)
        for kind, shape in _split(self.shapes.GetShape_s(product)):
            label = inner.called(shape)
            faces = subshapes(shape, "FACE")
            face_called = [inner.called(face) for face in faces]
            shared = {face.colour for face in face_called}
            name, colour = label.name or called.name, label.colour or called.colour
            if colour is None and len(shared) == 1:
                colour = shared.pop()
            others = way.others
            if label.name is not None and called.name is not None:
                others = (*others, called.name)
            placed = shape.Moved(way.location)
            yield Piece(
                kind,
                placed,
                [TopoDS.Face(face) for face in subshapes(placed, "FACE")],
                _Called(name, colour),
                face_called,
                way.place,
                others,
            )


class _Inner:
    """Names and colours of the solids, shells and faces inside a product."""

    def __init__(self, shapes: Any, product: Any) -> None:
        from OCP.collections import (
            IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
            Sequence_TDF_Label,
        )

        self._known = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._called: dict[int, _Called] = {}
        labels = Sequence_TDF_Label()
        shapes.GetSubShapes_s(product, labels)
        for label in _items(labels):
            number = self._known.Add(shapes.GetShape_s(label))
            self._called[number] = _Called(_name(label), _colour(label))

    def called(self, shape: Any) -> _Called:
        return self._called.get(self._known.FindIndex(shape), NAMELESS)


def _split(shape: Any) -> Iterator[tuple[str, Any]]:
    """Yield the solids, shells and faces of a shape, each once, without the faces of solids."""
    from OCP.TopAbs import TopAbs_ShapeEnum

    if shape.IsNull():
        return
    kinds = {
        TopAbs_ShapeEnum.TopAbs_SOLID: "solid",
        TopAbs_ShapeEnum.TopAbs_SHELL: "shell",
        TopAbs_ShapeEnum.TopAbs_FACE: "face",
    }
    kind = shape.ShapeType()
    if kind in kinds:
        yield kinds[kind], shape
    elif kind in (TopAbs_ShapeEnum.TopAbs_COMPOUND, TopAbs_ShapeEnum.TopAbs_COMPSOLID):
        for member in members(shape):
            yield from _split(member)


def compound_of(shapes: Iterable[Any]) -> Any:
    """Return a compound of several shapes."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    builder, compound = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def labelled(pieces: Sequence[Piece], edges: Sewn) -> list[PartLabel]:
    """Return the parts that pieces make: solids, shells, and connected loose faces.

    `edges` numbers the edges of all pieces, those that coincide alike.
    """
    parts: dict[int, PartLabel] = {}
    number = 0
    for piece, group in zip(pieces, _groups(pieces, edges), strict=True):
        faces = []
        for face, called in zip(piece.faces, piece.face_called, strict=True):
            number += 1
            faces.append(FaceLabel(number, _surface(face), *called))
        part = parts.get(group)
        if part is None:
            kind = "faces" if piece.kind == "face" else piece.kind
            parts[group] = PartLabel(
                len(parts) + 1,
                kind,
                tuple(faces),
                piece.called.name,
                piece.place,
                piece.others,
                piece.called.colour,
            )
        else:
            parts[group] = _join(part, piece, faces)
    return list(parts.values())


def _join(part: PartLabel, piece: Piece, faces: list[FaceLabel]) -> PartLabel:
    """Return a part of loose faces with more of them, with name and colour if all have the same."""
    name = part.name if part.name == piece.called.name else None
    colour = part.colour if part.colour == piece.called.colour else None
    return part._replace(faces=(*part.faces, *faces), name=name, colour=colour)


def _groups(pieces: Sequence[Piece], edges: Sewn) -> Iterable[int]:
    """Return a group number for each piece.

    Loose faces of one place that share an edge are one group.
    """
    loose = [k for k, piece in enumerate(pieces) if piece.kind == "face"]
    groups = np.arange(len(pieces))
    if len(loose) < 2:
        return groups.tolist()
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ends: dict[tuple[tuple[str, ...], int], int] = {}
    pairs = [
        (row, ends.setdefault((pieces[k].place, edges.add(edge)[0]), len(ends)))
        for row, k in enumerate(loose)
        for edge in subshapes(pieces[k].shape, "EDGE")
    ]
    if pairs:
        rows, columns = np.array(pairs).T
        size = len(loose) + len(ends)
        graph = coo_array((np.ones(len(pairs)), (rows, columns + len(loose))), shape=(size, size))
        labels = connected_components(graph, directed=False)[1][: len(loose)]
        groups[loose] = len(pieces) + labels
    return groups.tolist()


def _items(sequence: Any) -> list[Any]:
    return [sequence.Value(k) for k in range(1, sequence.Length() + 1)]


def _name(label: Any) -> str | None:
    from OCP.TDataStd import TDataStd_Name

    guid = TDataStd_Name.GetID_s()
    if not label.IsAttribute(guid):  # the bindings crash on missing attributes
        return None
    name = TDataStd_Name()
    label.FindAttribute(guid, name)
    return name.Get().ToExtString().strip() or None


def _colour(label: Any) -> str | None:
    from OCP.Quantity import Quantity_Color
    from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

    colour = Quantity_Color()
    for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, colour):
            return str(Quantity_Color.ColorToHex_s(colour).ToCString()).lower()
    return None


def _surface(face: Any) -> str:
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location

    surface = BRep_Tool.Surface_s(face, TopLoc_Location())
    return "" if surface is None else _SURFACES.get(type(surface).__name__, "other")
