"""NURBS of contiga as OpenCASCADE faces, for formats that give edges but no p-curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.occ_geometry import pcurve_from
from contiga.io.cad.warp import on_edge
from contiga.records import FloatArray


def _doubles(values: FloatArray) -> Any:
    from OCP.collections import Array1_double

    array = Array1_double(1, len(values))
    for i, value in enumerate(values):
        array.SetValue(i + 1, float(value))
    return array


def _knots(knots: FloatArray) -> tuple[Any, Any]:
    """Distinct knots and their multiplicities."""
    from OCP.collections import Array1_int

    distinct, times = np.unique(knots, return_counts=True)
    counts = Array1_int(1, len(times))
    for i, count in enumerate(times):
        counts.SetValue(i + 1, int(count))
    return _doubles(distinct), counts


def occ_curve(curve: NurbsCurve) -> Any:
    """`curve` as a Geom_BSplineCurve."""
    from OCP.collections import Array1_gp_Pnt
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

    points = curve.control_points
    poles = Array1_gp_Pnt(1, len(points))
    for i, point in enumerate(points):
        poles.SetValue(i + 1, gp_Pnt(*map(float, point)))
    weights = np.ones(len(points)) if curve.weights is None else curve.weights
    return Geom_BSplineCurve(poles, _doubles(weights), *_knots(curve.knots), curve.degree)


def occ_pcurve(curve: NurbsCurve) -> Any:
    """A p-curve as a Geom2d_BSplineCurve."""
    from OCP.collections import Array1_gp_Pnt2d
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.gp import gp_Pnt2d

    points = curve.control_points
    poles = Array1_gp_Pnt2d(1, len(points))
    for i, point in enumerate(points):
        poles.SetValue(i + 1, gp_Pnt2d(float(point[0]), float(point[1])))
    weights = np.ones(len(points)) if curve.weights is None else curve.weights
    return Geom2d_BSplineCurve(poles, _doubles(weights), *_knots(curve.knots), curve.degree)


def occ_surface(surface: NurbsSurface) -> Any:
    """`surface` as a Geom_BSplineSurface."""
    from OCP.collections import Array2_double, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    points = surface.control_points
    n, m = points.shape[:2]
    poles, factors = Array2_gp_Pnt(1, n, 1, m), Array2_double(1, n, 1, m)
    weights = np.ones((n, m)) if surface.weights is None else surface.weights
    for i in range(n):
        for j in range(m):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*map(float, points[i, j])))
            factors.SetValue(i + 1, j + 1, float(weights[i, j]))
    (U, u_times), (V, v_times) = (_knots(knots) for knots in surface.knots)
    return Geom_BSplineSurface(poles, factors, U, V, u_times, v_times, *surface.degrees)


def occ_plane(surface: NurbsSurface) -> Any | None:
    """The Geom_Plane of a flat bilinear patch with the same normal, else None.

    OpenCASCADE draws p-curves on planes exactly, on flat splines only by approximation.
    """
    from OCP.Geom import Geom_Plane
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

    points = surface.control_points
    if surface.degrees != (1, 1) or points.shape[:2] != (2, 2):
        return None
    along_u, along_v = points[1, 0] - points[0, 0], points[0, 1] - points[0, 0]
    normal = np.cross(along_u, along_v)
    size = max(np.linalg.norm(along_u), np.linalg.norm(along_v))
    off = abs(np.dot(points[1, 1] - points[0, 0], normal))
    if np.linalg.norm(normal) <= 1e-12 * size**2 or off > 1e-12 * size * np.linalg.norm(normal):
        return None
    axes = gp_Ax3(
        gp_Pnt(*map(float, points[0, 0])),
        gp_Dir(*map(float, normal)),
        gp_Dir(*map(float, along_u)),
    )
    return Geom_Plane(axes)


class OccEdges:
    """The edges of one brep as TopoDS_Edge; faces made with them share them.

    Parameters
    ----------
    curves : the edges in space
    tolerance : largest miss between edges and faces, length
    """

    def __init__(self, curves: Sequence[NurbsCurve], tolerance: float) -> None:
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

        self._curves = list(curves)
        self._tolerance = tolerance
        self._edges = [BRepBuilderAPI_MakeEdge(occ_curve(curve)).Edge() for curve in curves]

    def add(self, edge: Any) -> tuple[int, bool]:
        """Number of `edge`, −1 if it is none of these, and that it runs as that edge does."""
        for number, known in enumerate(self._edges):
            if known.IsSame(edge):
                return number, False
        return -1, False

    def face(self, surface: NurbsSurface, trims: list[Any], turned: bool) -> Any:
        """A TopoDS_Face on `surface`; `trims` are loops of items with ``edge`` and ``reversed``.

        OpenCASCADE's p-curves by projection are good to its tolerance; on curved surfaces they
        are drawn anew. Trims at a pole (edge −1) are left out: the loop closes over the pole.
        """
        from OCP.BRep import BRep_Builder
        from OCP.TopAbs import TopAbs_Orientation
        from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Wire

        forward, backward = (
            TopAbs_Orientation.TopAbs_FORWARD,
            TopAbs_Orientation.TopAbs_REVERSED,
        )
        builder = BRep_Builder()
        face = TopoDS_Face()
        plane = occ_plane(surface)
        base = plane or occ_surface(surface)
        builder.MakeFace(face, base, self._tolerance)
        for loop in trims:
            wire = TopoDS_Wire()
            builder.MakeWire(wire)
            for trim in loop:
                if trim.edge >= 0:
                    way = backward if trim.reversed else forward
                    builder.Add(wire, self._edges[trim.edge].Oriented(way))
            builder.Add(face, wire)
        if plane is None:
            self._sharpen(face, surface, [trim.edge for loop in trims for trim in loop])
        return TopoDS.Face(face.Oriented(backward if turned else forward))

    def _sharpen(self, face: Any, surface: NurbsSurface, used: list[int]) -> None:
        """Project the edges of `face` exactly; seams, which have two p-curves, stay as they are."""
        from OCP.BRep import BRep_Builder, BRep_Tool
        from OCP.ShapeFix import ShapeFix_Edge

        for number in set(used):
            if number < 0 or used.count(number) > 1:
                continue
            edge = self._edges[number]
            ShapeFix_Edge().FixAddPCurve(edge, face, False)
            rough = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
            if rough is not None:
                first, last = BRep_Tool.Range_s(edge, face)
                near = pcurve_from(rough, first, last)
                far = 100.0 * self._tolerance
                exact = on_edge(near, self._curves[number], surface, far)
                if exact is None:
                    continue
                BRep_Builder().UpdateEdge(edge, occ_pcurve(exact), face, self._tolerance)
