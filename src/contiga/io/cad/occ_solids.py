"""Closed pieces of a body as solids of OpenCASCADE, with their own surfaces and trims.

OpenCASCADE reads a STEP file as solids. 3DM, G+Smo and bodies made in Python are patches: here they
become faces, sewn to a shell. Patches that are flat parallelograms become planes, which OpenCASCADE
handles better than splines.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.faces import Faces
from contiga.geometry.piece import piece_of
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.sew import COINCIDENT, FINEST, subshapes
from contiga.records import FloatArray

FLAT_TOL = 1e-12
"""Largest distance of a parallelogram from a patch, over its size."""
SEAM_TOL = 1e-9
"""Largest distance of opposite sides that are one seam, over the size of the patch."""
VERTEX_TOL = 1e-4
"""Distance up to which ends of edges coincide, mm, for a size of some thousand."""
VOLUME_TOL = 1e-6
"""Largest relative difference of the volumes of a solid and its piece."""


class Solid(NamedTuple):
    """A solid of OpenCASCADE, made of patches of a body."""

    shape: Any
    """TopoDS_Solid."""
    faces: list[Any]
    """Its faces, TopoDS_Face."""
    patches: list[int]
    """Patch that each face is, or is a part of."""


def solid_of(body: Faces, patches: Sequence[int], scale: float) -> Solid | None:
    """Return a closed piece of a body as a solid, points times `scale`.

    A piece that bounds a cavity, which faces inward, makes the solid that fills it. None if the
    faces cannot be made, are not sewn to one shell without free edges, or the solid's volume
    differs from the piece's by more than `VOLUME_TOL` of it.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    piece = piece_of(body, patches)
    sewing = BRepBuilderAPI_Sewing(max(FINEST, COINCIDENT * scale * piece.size))
    try:
        faces = [
            (patch, face)
            for patch in patches
            for face in faces_of(body.patches[patch].scaled(scale), body.trims[patch])
        ]
    except Exception:  # OpenCASCADE raises its own kinds for loops that it cannot follow
        return None
    for _, face in faces:
        sewing.Add(face)
    sewing.Perform()
    shells = subshapes(sewing.SewedShape(), "SHELL")
    if len(shells) != 1 or sewing.NbFreeEdges():
        return None
    solid = BRepBuilderAPI_MakeSolid(TopoDS.Shell(shells[0])).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    volume = abs(piece.volume()) * scale**3
    if not abs(volume_of(solid) - volume) <= VOLUME_TOL * volume:
        return None
    return _trace(solid, [(patch, [sewing.ModifiedSubShape(face)]) for patch, face in faces])


def hollow_out(solid: Solid, cavity: Solid) -> Solid | None:
    """Return a solid with a cavity cut out; None if the cavity does not lie within it.

    It does if the cut is one solid and has the volume of `solid` less that of `cavity`, to
    `VOLUME_TOL`.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    cut = BRepAlgoAPI_Cut(solid.shape, cavity.shape)
    solids = subshapes(cut.Shape(), "SOLID")
    volume = volume_of(solid.shape) - volume_of(cavity.shape)
    if len(solids) != 1 or not abs(volume_of(solids[0]) - volume) <= VOLUME_TOL * volume:
        return None
    faces = [*zip(solid.patches, solid.faces, strict=True)]
    faces += zip(cavity.patches, cavity.faces, strict=True)
    return _trace(solids[0], [(k, list(cut.Modified(face)) or [face]) for k, face in faces])


def _trace(solid: Any, parts: Sequence[tuple[int, list[Any]]]) -> Solid:
    """Return the record of a solid; `parts` has the patches, and the faces that each became."""
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
    from OCP.TopoDS import TopoDS

    numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    owner = {int(numbers.Add(face)): patch for patch, faces in parts for face in faces}
    faces = [TopoDS.Face(face) for face in subshapes(solid, "FACE")]
    return Solid(solid, faces, [owner[int(numbers.FindIndex(face))] for face in faces])


def volume_of(shape: Any) -> float:
    """Return the signed volume of a shape, to about 1e-9 of it; negative if it faces inward."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-9)
    return float(properties.Mass())


def faces_of(patch: NurbsSurface, loops: Sequence[Sequence[NurbsCurve]] | None) -> list[Any]:
    """Return a patch, cut out by its loops if it has any, as TopoDS_Face of OpenCASCADE.

    A parallelogram becomes a plane face; an untrimmed patch whose opposite sides meet becomes two
    halves, or four. Outer loops run anticlockwise afterwards.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepLib import BRepLib
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt
    from OCP.ShapeFix import ShapeFix_Face

    net = patch.control_points
    is_flat = False
    if patch.degrees == (1, 1) and patch.weights is None and net.shape[:2] == (2, 2):
        miss = net[0, 0] + net[1, 1] - net[0, 1] - net[1, 0]
        is_flat = bool(np.abs(miss).max() <= FLAT_TOL * np.ptp(net, axis=(0, 1)).max())
    if loops is None and not is_flat:
        return [BRepBuilderAPI_MakeFace(_surface(half), FINEST).Face() for half in _halves(patch)]
    if is_flat:
        (u, u1), (v, v1) = patch.domain
        if not loops:
            corners = [(u, v), (u1, v), (u1, v1), (u, v1), (u, v)]
            loops = [[NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], np.array(p)) for p in pairwise(corners)]]
        first = patch.derivatives(np.array([[u, v]]), 1)[0]
        origin, du, dv = first[0, 0], first[1, 0], first[0, 1]
        normal = gp_Dir(*np.cross(du, dv).tolist())
        surface = gp_Pln(gp_Ax3(gp_Pnt(*origin.tolist()), normal, gp_Dir(*du.tolist())))
        # p-curves are lifted into space
        wires = []
        for loop in loops:
            edges = []
            for c in loop:
                uv = c.control_points
                points = origin + (uv[:, :1] - u) * du + (uv[:, 1:2] - v) * dv
                edges.append(_edge(_curve(NurbsCurve(c.degree, c.knots, points, c.weights))))
            wires.append(_wire(edges))
    else:
        surface = _surface(patch)
        wires = [_wire([_edge(_curve(c, 2), surface) for c in loop]) for loop in loops or ()]
    face = BRepBuilderAPI_MakeFace(surface, wires[0], True)
    for wire in wires[1:]:
        face.Add(wire)
    if not is_flat:
        BRepLib.BuildCurves3d_s(face.Face(), FINEST)
    fix = ShapeFix_Face(face.Face())
    fix.FixOrientation()
    return [fix.Face()]


def _halves(patch: NurbsSurface) -> list[NurbsSurface]:
    """Return a patch cut in two in each direction whose sides meet, so that none has a seam.

    Sides meet if their control points differ by at most `SEAM_TOL` of the size.
    """
    for axis, ((a, b), other) in enumerate(zip(patch.domain, patch.domain[::-1], strict=True)):
        sides = [patch.isocurve(**{"uv"[axis]: end}).control_points for end in (a, b)]
        if np.abs(sides[0] - sides[1]).max() <= SEAM_TOL * np.ptp(patch.bounds(), axis=0).max():
            parts = [(a, 0.5 * (a + b)), (0.5 * (a + b), b)]
            spans = [(part, other) if axis == 0 else (other, part) for part in parts]
            return [half for span in spans for half in _halves(patch.restricted(*span))]
    return [patch]


def _edge(curve: Any, *surface: Any) -> Any:
    """Return an edge along a curve in space, or along a p-curve of `surface`.

    Its vertices get the tolerance `VERTEX_TOL`, which joins them in loops of p-curves.
    """
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.TopoDS import TopoDS

    edge = BRepBuilderAPI_MakeEdge(curve, *surface).Edge()
    for vertex in subshapes(edge, "VERTEX"):
        BRep_Builder().UpdateVertex(TopoDS.Vertex(vertex), VERTEX_TOL)
    return edge


def _wire(edges: Sequence[Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire

    wire = BRepBuilderAPI_MakeWire()
    for edge in edges:
        wire.Add(edge)
    return wire.Wire()


def _knots(values: FloatArray) -> tuple[Any, Any]:
    """Return the different knots and their multiplicities, as arrays of OpenCASCADE."""
    from OCP.collections import Array1_double, Array1_int

    breaks, counts = np.unique(values, return_counts=True)
    knots, multiplicities = Array1_double(1, len(breaks)), Array1_int(1, len(breaks))
    for k, (knot, count) in enumerate(zip(breaks.tolist(), counts.tolist(), strict=True), 1):
        knots.SetValue(k, knot)
        multiplicities.SetValue(k, count)
    return knots, multiplicities


def _curve(curve: NurbsCurve, dimension: int = 3) -> Any:
    """Return a Geom_BSplineCurve, or for `dimension` 2 the Geom2d_BSplineCurve of a p-curve."""
    from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_gp_Pnt2d
    from OCP.Geom import Geom_BSplineCurve
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.gp import gp_Pnt, gp_Pnt2d

    net = curve.control_points[:, :dimension]
    is_planar = dimension == 2
    points = (Array1_gp_Pnt2d if is_planar else Array1_gp_Pnt)(1, len(net))
    weights = Array1_double(1, len(net))
    for k, row in enumerate(net.tolist(), 1):
        points.SetValue(k, (gp_Pnt2d if is_planar else gp_Pnt)(*row))
        weights.SetValue(k, 1.0 if curve.weights is None else float(curve.weights[k - 1]))
    kind = Geom2d_BSplineCurve if is_planar else Geom_BSplineCurve
    return kind(points, weights, *_knots(curve.knots), curve.degree)


def _surface(patch: NurbsSurface) -> Any:
    """Return a Geom_BSplineSurface."""
    from OCP.collections import Array2_double, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    n, m = patch.control_points.shape[:2]
    poles, weights = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
    for i, j in np.ndindex(n, m):
        poles.SetValue(i + 1, j + 1, gp_Pnt(*patch.control_points[i, j].tolist()))
        weights.SetValue(i + 1, j + 1, 1.0 if patch.weights is None else patch.weights[i, j])
    (u, u_counts), (v, v_counts) = map(_knots, patch.knots)
    return Geom_BSplineSurface(poles, weights, u, v, u_counts, v_counts, *patch.degrees)
