"""A headform for impact tests, built with OpenCASCADE and written as STEP.

One bicubic B-spline with a pole at the crown carries the face (brow, eye sockets, nose, lips,
chin). It is cut flat at the back and at the base, gets a neck with a filleted root, a bore for
the mounting bolt and a round recess on either side for a film target, and its edges are filleted:
free-form and analytic faces, nearly all of them trimmed. Lengths in mm, x to the front, z up, the
origin at the centre of the head. The same numbers give the same part every time.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

BACK = -84.0
"""x of the flat back, mm."""
NECK_X, NECK_RADIUS, NECK_END = -15.0, 40.0, -128.0
"""Axis and radius of the neck, and z of its flat end, mm."""
BORE_RADIUS, BORE_DEPTH = 9.0, 45.0
RECESS_X, RECESS_Z, RECESS_RADIUS, RECESS_FLOOR = -8.0, 26.0, 17.0, 66.0
"""Centre, radius and distance from the mid-plane of the flat recesses for the film targets."""
N_AROUND, N_DOWN = 49, 41
"""Points the surface is laid through: around the axis, and from pole to pole."""

_BLEND = 10
"""Higher values bring out the ellipsoids, lower ones melt them into each other."""
# centre x, z and half-axes x, y, z of the ellipsoids that make up skull, jaw and mouth
_ELLIPSOIDS = (
    (-6.0, 22.0, 92.0, 72.0, 80.0),
    (26.0, -34.0, 54.0, 56.0, 60.0),
    (40.0, -60.0, 44.0, 40.0, 36.0),
)
# where it sits (y, z seen from the front at x = 90), half-widths in y and z, height
_FEATURES = (
    (0.0, 37.0, 38.0, 9.0, 5.0),  # brow
    (28.0, 17.0, 13.0, 9.5, -10.0),  # eye sockets
    (-28.0, 17.0, 13.0, 9.5, -10.0),
    (0.0, 8.0, 7.0, 15.0, 9.0),  # bridge of the nose
    (0.0, -10.0, 10.5, 9.0, 17.0),  # tip of the nose
    (0.0, -35.0, 17.0, 4.5, 4.0),  # lips
    (0.0, -45.0, 14.0, 5.0, 3.5),
    (0.0, -40.0, 19.0, 2.6, -3.0),  # mouth
    (0.0, -54.0, 20.0, 4.5, -4.0),  # hollow above the chin
)


def radius(directions: np.ndarray) -> np.ndarray:
    """Return the distance (n,) of the skin from the origin along unit `directions` (n, 3), mm.

    A smooth maximum of ellipsoids, of power `_BLEND`, with the bumps of the face in front.
    """
    d = directions
    reach = np.zeros(len(d))
    for x, z, a, b, c in _ELLIPSOIDS:
        centre, half_axes = np.array([x, 0.0, z]), np.array([a, b, c])
        p, q = d / half_axes, centre / half_axes
        pp, pq, qq = (p * p).sum(1), p @ q, q @ q
        root = pq**2 - pp * (qq - 1.0)
        hit = np.where(root > 0.0, (pq + np.sqrt(np.maximum(root, 0.0))) / pp, 0.0)
        reach += np.maximum(hit, 0.0) ** _BLEND
    skin = reach ** (1.0 / _BLEND)
    front = np.maximum(d[:, 0], 1e-6)
    y, z = 90.0 * d[:, 1] / front, 90.0 * d[:, 2] / front
    for y0, z0, wy, wz, height in _FEATURES:
        bump = np.exp(-((y - y0) ** 2) / (2 * wy**2) - (z - z0) ** 2 / (2 * wz**2))
        skin += np.where(d[:, 0] > 0.05, height * bump, 0.0)
    return skin


def skin_points() -> np.ndarray:
    """Return points (N_AROUND, N_DOWN, 3) of the skin, around z from the back, from crown to base.

    The first and the last row are the same, and so are all points of either pole.
    """
    around = np.linspace(-np.pi, np.pi, N_AROUND)
    # closer together on the face: a quarter of the turn is spread over more than a third
    around = around - 0.45 * np.sin(around)
    down = np.linspace(0.0, np.pi, N_DOWN)
    theta, phi = np.meshgrid(around, down, indexing="ij")
    d = np.stack([np.sin(phi) * np.cos(theta), np.sin(phi) * np.sin(theta), np.cos(phi)], axis=-1)
    points = radius(d.reshape(-1, 3)).reshape(N_AROUND, N_DOWN, 1) * d
    points[:, 0] = points[:, 0].mean(axis=0)
    points[:, -1] = points[:, -1].mean(axis=0)
    points[-1] = points[0]
    return points


def skin_surface() -> Any:
    """Return the skin as a bicubic B-spline through `skin_points`, smooth across its seam."""
    from OCP.collections import Array1_double, Array1_int, Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt
    from scipy.interpolate import make_interp_spline

    around, down = np.arange(N_AROUND, dtype=float), np.arange(N_DOWN, dtype=float)
    v_spline = make_interp_spline(down, skin_points(), k=3, axis=1)
    u_spline = make_interp_spline(around, np.moveaxis(v_spline.c, 1, 0), k=3, bc_type="periodic")
    net = np.asarray(u_spline.c)[: N_AROUND - 1]
    net[:, 0] = net[:, 0].mean(axis=0)
    net[:, -1] = net[:, -1].mean(axis=0)
    poles = Array2_gp_Pnt(1, net.shape[0], 1, net.shape[1])
    for i, j in np.ndindex(net.shape[:2]):
        poles.SetValue(i + 1, j + 1, gp_Pnt(*net[i, j].tolist()))

    def knots(values: np.ndarray, ends: int) -> tuple[Any, Any]:
        places, counts = Array1_double(1, len(values)), Array1_int(1, len(values))
        for k, value in enumerate(values):
            places.SetValue(k + 1, float(value))
            counts.SetValue(k + 1, ends if k in (0, len(values) - 1) else 1)
        return places, counts

    u_knots, u_counts = knots(around, 1)
    v_knots, v_counts = knots(np.unique(v_spline.t), 4)
    surface = Geom_BSplineSurface(poles, u_knots, v_knots, u_counts, v_counts, 3, 3, True, False)
    surface.SetUNotPeriodic()
    return surface


def head_solid() -> Any:
    """Return the head, before any cut, as a solid with one face."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    face = BRepBuilderAPI_MakeFace(skin_surface(), 1e-3).Face()
    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    builder.Add(shell, face)
    shell.Closed(True)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def cylinder(
    origin: tuple[float, ...], axis: tuple[float, ...], radius: float, length: float
) -> Any:
    """Return a solid cylinder from `origin` along `axis`, mm."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*origin), gp_Dir(*axis)), radius, length).Shape()


def joined(body: Any, tool: Any) -> Any:
    """Return the union of `body` and `tool`."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    return BRepAlgoAPI_Fuse(body, tool).Shape()


def cut(body: Any, tool: Any) -> Any:
    """Return `body` without `tool`."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(body, tool).Shape()


def filleted(body: Any, radius: float, chosen: Callable[[np.ndarray], bool]) -> Any:
    """Return `body` with the edges rounded for whose sampled points (9, 3) `chosen` is true."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    maker = BRepFilletAPI_MakeFillet(body)
    explorer = TopExp_Explorer(body, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        curve = BRepAdaptor_Curve(edge)
        u = np.linspace(curve.FirstParameter(), curve.LastParameter(), 9)
        points = np.array([[(p := curve.Value(t)).X(), p.Y(), p.Z()] for t in u])
        if chosen(points):
            maker.Add(radius, edge)
        explorer.Next()
    return maker.Shape()


def _at_neck_root(points: np.ndarray) -> bool:
    radii = np.hypot(points[:, 0] - NECK_X, points[:, 1])
    return np.allclose(radii, NECK_RADIUS, atol=1e-3) and np.ptp(points[:, 0]) > 1.0


def _at_neck_end(points: np.ndarray) -> bool:
    return np.allclose(points[:, 2], NECK_END)


def _on_back(points: np.ndarray) -> bool:
    return np.allclose(points[:, 0], BACK)


def _at_bore(points: np.ndarray) -> bool:
    return _on_back(points) and np.hypot(points[:, 1], points[:, 2]).max() < BORE_RADIUS + 1.0


def _at_recess(points: np.ndarray) -> bool:
    off = np.hypot(points[:, 0] - RECESS_X, points[:, 2] - RECESS_Z)
    rim = np.abs(points[:, 1]).min() > RECESS_FLOOR + 1.0
    return rim and np.allclose(off, RECESS_RADIUS, atol=1e-3) and np.ptp(points[:, 0]) > 1.0


def headform() -> Any:
    """Return the finished part; each fillet is made while its edges are still simple."""
    head = cut(head_solid(), cylinder((BACK, 0.0, 0.0), (-1.0, 0.0, 0.0), 200.0, 100.0))
    head = filleted(head, 9.0, _on_back)
    head = joined(head, cylinder((NECK_X, 0.0, NECK_END), (0.0, 0.0, 1.0), NECK_RADIUS, 90.0))
    head = filleted(head, 7.0, lambda p: _at_neck_root(p) and not _at_neck_end(p))
    head = filleted(head, 3.0, _at_neck_end)
    head = cut(head, cylinder((BACK, 0.0, 0.0), (1.0, 0.0, 0.0), BORE_RADIUS, BORE_DEPTH))
    head = filleted(head, 2.0, _at_bore)
    for side in (1.0, -1.0):
        floor = (RECESS_X, side * RECESS_FLOOR, RECESS_Z)
        head = cut(head, cylinder(floor, (0.0, side, 0.0), RECESS_RADIUS, 30.0))
    return filleted(head, 1.5, _at_recess)


def only_solid(shape: Any) -> Any:
    """Return the one solid in `shape`; exit if there are more, or it is not valid."""
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, TopAbs_SOLID)
    solid = explorer.Current()
    explorer.Next()
    if explorer.More() or not BRepCheck_Analyzer(solid).IsValid():
        raise SystemExit("the headform is not one valid solid")
    return solid


def write_step(solid: Any, path: Path) -> None:
    """Write `solid` as STEP in mm, the same bytes each time; exit if it cannot be written.

    Its folder is made, and OpenCASCADE's messages are silenced for the process.
    """
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
    from OCP.TCollection import TCollection_HAsciiString

    Message.DefaultMessenger_s().ChangePrinters().Clear()
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    writer.Transfer(solid, STEPControl_AsIs)
    header = APIHeaderSection_MakeHeader(writer.Model())
    header.SetName(TCollection_HAsciiString("headform"))
    header.SetTimeStamp(TCollection_HAsciiString("2026-01-01T00:00:00"))
    path.parent.mkdir(parents=True, exist_ok=True)
    if writer.Write(str(path)) != IFSelect_RetDone:
        raise SystemExit(f"{path} cannot be written")
