"""Cuts of a body by a plane with OpenCASCADE: a flat face closes parts of closed pieces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import GeometryError, InputError
from contiga.extras import require
from contiga.io.cad.occ_geometry import quiet
from contiga.io.cad.occ_parts import compound_of
from contiga.io.cad.occ_solids import faces_of
from contiga.io.cad.sew import subshapes
from contiga.io.cad.unite_body import as_patches, as_solids, scale_of
from contiga.masters.body import Body
from contiga.records import FloatArray


def split(body: Body, plane: tuple[ArrayLike, ArrayLike]) -> tuple[Body, Body]:
    """Return the parts of a body above and below a plane (point, normal); see `Body.split`.

    A solid or a face of an open piece is above if its centroid is on the side of the normal.

    Raises
    ------
    InputError
        `plane` is not a finite point and a finite normal of some length.
    GeometryError
        All is on one side, or OpenCASCADE cannot split the body.
    MissingPackageError
        OpenCASCADE is not installed.
    """
    try:
        point, normal = (np.asarray(real(part, "plane"), np.float64) for part in plane)
    except (TypeError, ValueError):
        point = normal = np.zeros(0)
    length = float(np.sqrt((normal * normal).sum()))
    is_valid = point.shape == normal.shape == (3,) and bool(np.isfinite(point).all())
    if not is_valid or not 0.0 < length < np.inf:
        raise InputError(
            "must be a point and a normal",
            where="Body.split(plane)",
            found=plane,
            allowed="([x, y, z], [nx, ny, nz]), finite, the normal not zero",
        )
    normal = normal / length
    require("splitting a body by a plane", "OCP")
    scale = scale_of(body)
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    with quiet():
        above: list[Any] = []
        below: list[Any] = []
        for part in _split_shapes(body, point, normal, scale):
            properties = GProp_GProps()
            if subshapes(part, "SOLID"):
                BRepGProp.VolumeProperties_s(part, properties)
            else:
                BRepGProp.SurfaceProperties_s(part, properties)
            place = properties.CentreOfMass()
            centroid = np.array([place.X(), place.Y(), place.Z()])
            is_above = normal @ (centroid / scale - point) > 0.0
            (above if is_above else below).append(part)
        if not above or not below:
            extent = (body.bounds() - point) * normal
            low, high = extent.min(axis=0).sum(), extent.max(axis=0).sum()
            raise GeometryError(
                "the plane does not cut the body",
                where=f"{body.name}.split(plane)",
                found=f"point {point.tolist()}, normal {normal.round(6).tolist()}",
                allowed="a plane with a part of the body on either side; its box reaches from "
                f"{low:.6g} to {high:.6g} along the normal",
            )
        return _join_parts(body, above, scale), _join_parts(body, below, scale)


def _split_shapes(body: Body, point: FloatArray, normal: FloatArray, scale: float) -> list[Any]:
    """Return solids, then faces of no solid, split by the plane, with lengths · `scale`.

    The plane is a square with a half side of the body's size about the middle of its box. Failure
    of OpenCASCADE is a `GeometryError`.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.collections import List_TopoDS_Shape
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    solids = as_solids(body, [piece.tolist() for piece in body.pieces], scale)
    closed_patches = {patch for solid in solids for patch in solid.patches}
    open_faces = [
        faces_of(patch.scaled(scale), trims)
        for k, (patch, trims) in enumerate(zip(body.patches, body.trims, strict=True))
        if k not in closed_patches
    ]
    arguments, tools = List_TopoDS_Shape(), List_TopoDS_Shape()
    for shape in chain((solid.shape for solid in solids), *open_faces):
        arguments.Append(shape)
    middle = body.bounds().mean(axis=0)
    middle = scale * (middle - normal * (normal @ (middle - point)))
    half = scale * body.size
    flat = gp_Pln(gp_Pnt(*middle.tolist()), gp_Dir(*normal.tolist()))
    tools.Append(BRepBuilderAPI_MakeFace(flat, -half, half, -half, half).Face())
    splitter = BRepAlgoAPI_Splitter()
    splitter.SetArguments(arguments)
    splitter.SetTools(tools)
    splitter.SetNonDestructive(True)
    splitter.Build()
    if not splitter.IsDone():
        raise GeometryError("OpenCASCADE cannot split the body", where=f"{body.name}.split(plane)")
    result = splitter.Shape()
    parts = subshapes(result, "SOLID")
    faces = TopExp_Explorer(result, TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_SOLID)
    while faces.More():
        parts.append(faces.Current())
        faces.Next()
    return parts


def _join_parts(body: Body, parts: Sequence[Any], scale: float) -> Body:
    """Return parts as one body, lengths divided by `scale`, with coinciding edges joined.

    It has the name, unit and reference point of `body`.
    """
    from OCP.TopoDS import TopoDS

    compound = compound_of(parts)
    faces = [(k, TopoDS.Face(face)) for k, face in enumerate(subshapes(compound, "FACE"), 1)]
    joined, _ = as_patches(faces, compound, scale, body.name, body.unit)
    return joined.renamed(body.name).with_reference_point(body.reference_point)
