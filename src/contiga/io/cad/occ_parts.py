"""Contents of OpenCASCADE's document of a file: placed parts with names and colours.

Assemblies refer to products with a placement; a product may contain several solids, shells and
faces. Each of them, at each place, is a piece here; loose faces that share edges make one part,
whatever their names.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from contiga.io.cad.parts import FaceLabel, PartLabel
from contiga.io.cad.sew import SewnEdges, members, subshapes

_SURFACE_KINDS = {
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
    """TopoDS_Shape at its place."""
    faces: list[Any]
    """Its faces, TopoDS_Face."""
    attributes: Attributes
    """Its own, or those of its product; the colour that all its faces have, if it has none."""
    face_attributes: list[Attributes]
    place: tuple[str, ...]
    """Names of its instances, from the outermost assembly in."""
    aliases: tuple[str, ...]
    """Names of the products of its assemblies."""


class Attributes(NamedTuple):
    """Name and colour "#rrggbb" of a shape in the file, None for what it does not give."""

    name: str | None
    colour: str | None


NO_ATTRIBUTES = Attributes(None, None)


class _Path(NamedTuple):
    """The path from the outermost assembly down to a label."""

    location: Any
    """TopLoc_Location of the label, from the document's origin."""
    place: tuple[str, ...] = ()
    """Names of the instances."""
    aliases: tuple[str, ...] = ()
    """Names of the products."""
    colour: str | None = None
    """Colour of the innermost assembly or instance that has one."""


def new_document() -> Any:
    """Return an empty document for `STEPCAFControl_Reader` or `IGESCAFControl_Reader` to fill.

    OpenCASCADE's automatic names are switched off, for the whole process.
    """
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
    """Return all pieces of a document in the order of the file, one for each instance."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    free = Sequence_TDF_Label()
    shapes.GetFreeShapes(free)
    start = _Path(TopLoc_Location())
    return [piece for label in _items(free) for piece in _pieces_under(shapes, label, start)]


def _pieces_under(shapes: Any, label: Any, path: _Path) -> Iterator[Piece]:
    """Yield the pieces of a label, which may refer to a product elsewhere, and of its components.

    An instance without a name has that of its product, and a piece without name or colour those of
    the product; without a colour there, too, it has the one that all its faces have.
    """
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher, Sequence_TDF_Label
    from OCP.TDF import TDF_Label
    from OCP.TopoDS import TopoDS

    product, colour = label, None
    if shapes.IsReference_s(label):
        product, colour = TDF_Label(), _colour(label)
        shapes.GetReferredShape_s(label, product)
        instance = _name(label) or _name(product)
        path = path._replace(
            location=path.location.Multiplied(shapes.GetLocation_s(label)),
            place=path.place if instance is None else (*path.place, instance),
        )
    attributes = Attributes(_name(product), colour or _colour(product) or path.colour)
    labels = Sequence_TDF_Label()
    if shapes.IsAssembly_s(product):
        name = attributes.name
        aliases = path.aliases if name is None else (*path.aliases, name)
        path = path._replace(aliases=aliases, colour=attributes.colour)
        shapes.GetComponents_s(product, labels, False)
        for component in _items(labels):
            yield from _pieces_under(shapes, component, path)
        return
    numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    by_number: dict[int, Attributes] = {}
    shapes.GetSubShapes_s(product, labels)
    for label in _items(labels):
        number = numbers.Add(shapes.GetShape_s(label))
        by_number[number] = Attributes(_name(label), _colour(label))
    for kind, shape in _split(shapes.GetShape_s(product)):
        name, colour = by_number.get(numbers.FindIndex(shape), NO_ATTRIBUTES)
        face_attributes = [
            by_number.get(numbers.FindIndex(face), NO_ATTRIBUTES)
            for face in subshapes(shape, "FACE")
        ]
        aliases = path.aliases
        if name is not None and attributes.name is not None:
            aliases = (*aliases, attributes.name)
        colour = colour or attributes.colour
        face_colours = {face.colour for face in face_attributes}
        if colour is None and len(face_colours) == 1:
            colour = face_colours.pop()
        placed = shape.Moved(path.location)
        yield Piece(
            kind,
            placed,
            [TopoDS.Face(face) for face in subshapes(placed, "FACE")],
            Attributes(name or attributes.name, colour),
            face_attributes,
            path.place,
            aliases,
        )


def _split(shape: Any) -> Iterator[tuple[str, Any]]:
    """Yield kind and shape of the solids, shells and faces in a shape, not those within others.

    Compounds are taken apart; wires, edges and vertices are left out.
    """
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


def part_labels(pieces: Sequence[Piece], edges: SewnEdges) -> list[PartLabel]:
    """Return the parts that pieces make, in order: solids, shells, and connected loose faces.

    `edges` numbers the edges of all pieces, coinciding ones alike. Parts and faces are numbered
    from 1. A part of loose faces has a name and a colour if all its faces have the same, and the
    place of its first face.
    """
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location

    parts: dict[int, PartLabel] = {}
    number = 0
    for piece, group in zip(pieces, _groups(pieces, edges), strict=True):
        faces = []
        for face, attributes in zip(piece.faces, piece.face_attributes, strict=True):
            number += 1
            surface = BRep_Tool.Surface_s(face, TopLoc_Location())
            kind = "" if surface is None else _SURFACE_KINDS.get(type(surface).__name__, "other")
            faces.append(FaceLabel(number, kind, *attributes))
        name, colour = piece.attributes
        part = parts.get(group)
        if part is None:
            kind = "faces" if piece.kind == "face" else piece.kind
            parts[group] = PartLabel(
                len(parts) + 1, kind, tuple(faces), name, piece.place, piece.aliases, colour
            )
        else:
            parts[group] = part._replace(
                faces=(*part.faces, *faces),
                name=name if part.name == name else None,
                colour=colour if part.colour == colour else None,
            )
    return list(parts.values())


def _groups(pieces: Sequence[Piece], edges: SewnEdges) -> Iterable[int]:
    """Return a group number for each piece, unique but for loose faces.

    Loose faces of one place have the same number if edges connect them, also by way of other loose
    faces.
    """
    loose = [k for k, piece in enumerate(pieces) if piece.kind == "face"]
    groups = np.arange(len(pieces))
    if len(loose) < 2:
        return groups.tolist()
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edge_nodes: dict[tuple[tuple[str, ...], int], int] = {}
    pairs = [
        (row, edge_nodes.setdefault((pieces[k].place, edges.number_of(edge)[0]), len(edge_nodes)))
        for row, k in enumerate(loose)
        for edge in subshapes(pieces[k].shape, "EDGE")
    ]
    if pairs:
        rows, columns = np.array(pairs).T
        size = len(loose) + len(edge_nodes)
        graph = coo_array((np.ones(len(pairs)), (rows, columns + len(loose))), shape=(size, size))
        labels = connected_components(graph, directed=False)[1][: len(loose)]
        groups[loose] = len(pieces) + labels
    return groups.tolist()


def _items(sequence: Any) -> list[Any]:
    return [sequence.Value(k) for k in range(1, sequence.Length() + 1)]


def _name(label: Any) -> str | None:
    """Return the name of a label without blanks around it; None if it has none, or an empty one."""
    from OCP.TDataStd import TDataStd_Name

    guid = TDataStd_Name.GetID_s()
    if not label.IsAttribute(guid):  # the bindings crash on missing attributes
        return None
    name = TDataStd_Name()
    label.FindAttribute(guid, name)
    return name.Get().ToExtString().strip() or None


def _colour(label: Any) -> str | None:
    """Return the colour "#rrggbb" of the surfaces of a label, or its general one; None without."""
    from OCP.Quantity import Quantity_Color
    from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

    colour = Quantity_Color()
    for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, colour):
            return str(Quantity_Color.ColorToHex_s(colour).ToCString()).lower()
    return None
