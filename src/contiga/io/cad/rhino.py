"""3DM through rhino3dm: surfaces, extrusions and breps, instances placed.

rhino3dm gives a face's surface, the edges of its loops in space and their order, but not its
p-curves. Faces that are not the whole of their surface are therefore handed to OpenCASCADE, which
builds the p-curves from the edges; from there on the way is that of `step_iges`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import FileError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad import step_iges
from contiga.io.cad.assemble import Assembly, Edge, merged, warn
from contiga.io.cad.loops import Loop, Sides, Strand
from contiga.io.cad.occ_build import OccEdges
from contiga.io.cad.step_iges import add_face
from contiga.io.cad.stitch import side_curve
from contiga.io.units import length_factor, short_name
from contiga.masters.body import Body
from contiga.records import FloatArray

_UNITS = {
    "Microns": "um",
    "Millimeters": "mm",
    "Centimeters": "cm",
    "Decimeters": "dm",
    "Meters": "m",
    "Kilometers": "km",
    "Microinches": "microinch",
    "Mils": "thou",
    "Inches": "in",
    "Feet": "ft",
    "Yards": "yard",
    "Miles": "mile",
    "Nanometers": "nm",
}
SAMPLES = 9


class _Placed(NamedTuple):
    geometry: Any
    matrix: FloatArray
    """(4, 4) placement in the file's length unit."""


class _Trim(NamedTuple):
    edge: int
    """Index in the brep, −1 at a pole."""
    reversed: bool


def warm_up() -> None:
    """Load what the reader needs, before the time of a file counts."""
    import rhino3dm  # noqa: F401

    step_iges.warm_up()


def read_rhino(path: Path, file_unit: str | None, unit: str | None) -> Body:
    """All faces of a 3DM file as one body; see `contiga.io.cad.read_cad.read_cad`.

    Raises
    ------
    FileError
        Not a 3DM file, or one without surfaces.
    """
    import rhino3dm

    with path.open("rb") as stream:
        head = stream.read(32)
    model = rhino3dm.File3dm.Read(str(path)) if head.startswith(b"3D Geometry File") else None
    if model is None:
        raise FileError(
            "not a 3DM file, or a damaged one",
            where=str(path),
            allowed="a file that begins with '3D Geometry File Format'",
        )
    own = file_unit or _UNITS.get(model.Settings.ModelUnitSystem.name)
    scale = length_factor(own, unit, str(path)) if own and unit else 1.0
    tolerance = max(float(model.Settings.ModelAbsoluteTolerance), 1e-9)
    bodies: list[Body] = []
    left_out: set[str] = set()
    for geometry, matrix in _placed(model):
        body = _body_of(geometry, tolerance, str(path))
        if body is None:
            left_out.add(type(geometry).__name__)
        else:
            bodies.append(body.transformed(np.diag([scale, scale, scale, 1.0]) @ matrix))
    if left_out:
        warn(f"{path}: objects of type {', '.join(sorted(left_out))} were left out")
    return merged(bodies, path, short_name(unit or own) if own else None)


def _placed(model: Any) -> list[_Placed]:
    """Geometry with its placement; instances are followed into their definitions."""
    by_id = {str(item.Attributes.Id): item for item in model.Objects}
    found: list[_Placed] = []

    def follow(item: Any, matrix: FloatArray, depth: int) -> None:
        geometry = item.Geometry
        if type(geometry).__name__ != "InstanceReference":
            found.append(_Placed(geometry, matrix))
        elif depth < 32:
            inner = matrix @ np.array(geometry.Xform.ToFloatArray(True)).reshape(4, 4)
            definition = model.InstanceDefinitions.FindId(geometry.ParentIdefId)
            for member in definition.GetObjectIds():
                if str(member) in by_id:
                    follow(by_id[str(member)], inner, depth + 1)

    for item in model.Objects:
        if not item.Attributes.IsInstanceDefinitionObject:
            follow(item, np.eye(4), 0)
    return found


def _body_of(geometry: Any, tolerance: float, where: str) -> Body | None:
    """The faces of one object where it stands, in the file's unit; None if it has none."""
    import rhino3dm

    if isinstance(geometry, rhino3dm.Extrusion):
        geometry = geometry.ToBrep(True)
    if isinstance(geometry, rhino3dm.Brep):
        return _brep(geometry, tolerance, where)
    if isinstance(geometry, rhino3dm.Surface):
        return Body(surface_from(geometry.ToNurbsSurface()))
    return None


def surface_from(surface: Any) -> NurbsSurface:
    """A rhino3dm.NurbsSurface. Its knots lack the first and the last, its points are (wx, …, w)."""
    points = surface.Points
    n, m = points.CountU, points.CountV
    net = np.empty((n, m, 4))
    for i in range(n):
        for j in range(m):
            point = points.GetControlPoint(i, j)
            net[i, j] = point.X, point.Y, point.Z, point.W
    weights = net[..., 3] if surface.IsRational else None
    degrees = (surface.Degree(0), surface.Degree(1))
    knots = (_full(surface.KnotsU), _full(surface.KnotsV))
    return NurbsSurface(degrees, knots, net[..., :3] / net[..., 3:], weights)


def curve_from(curve: Any) -> NurbsCurve:
    """A rhino3dm.NurbsCurve."""
    net = np.array(
        [(p.X, p.Y, p.Z, p.W) for p in (curve.Points[i] for i in range(len(curve.Points)))]
    )
    weights = net[:, 3] if curve.IsRational else None
    return NurbsCurve(curve.Degree, _full(curve.Knots), net[:, :3] / net[:, 3:], weights)


def _full(knots: Any) -> FloatArray:
    inner = np.array([knots[i] for i in range(len(knots))], dtype=np.float64)
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _brep(brep: Any, tolerance: float, where: str) -> Body:
    curves = [curve_from(brep.Edges[i].ToNurbsCurve()) for i in range(len(brep.Edges))]
    edges = OccEdges(curves, tolerance)
    assembly = Assembly(where)
    for i in range(len(brep.Faces)):
        face = brep.Faces[i]
        surface = surface_from(face.UnderlyingSurface().ToNurbsSurface())
        trims = [_trims(face.Loops[k]) for k in range(len(face.Loops))]
        turned = bool(face.OrientationIsReversed)
        sides = _natural_sides(surface, trims, curves, tolerance)
        if sides is not None:
            assembly.add_whole(surface, *sides, flip=turned)
        else:
            made = edges.face(surface, trims, turned)
            add_face(assembly, made, edges, 1.0, f"{where}, face {i}")

    def edge_of(number: int) -> Edge | None:
        return Edge(curves[number], tolerance)

    return assembly.body("brep", edge_of, None)


def _trims(loop: Any) -> list[_Trim]:
    trims = (loop.Trims[i] for i in range(loop.TrimCount))
    return [_Trim(int(trim.EdgeIndex), bool(trim.IsReversed)) for trim in trims]


def _natural_sides(
    surface: NurbsSurface, trims: list[list[_Trim]], curves: list[NurbsCurve], tolerance: float
) -> tuple[Loop, Sides] | None:
    """The four sides as a loop if the trims are just those, else None."""
    if len(trims) != 1 or len(trims[0]) != 4:
        return None
    size = float(np.ptp(surface.bounds(), axis=0).max())
    near = max(10.0 * tolerance, 1e-9 * size)
    # Outer loops run counter-clockwise: up u on v0, up v on u1, and back.
    order = [(2, False), (1, False), (3, True), (0, True)]
    for turn in range(4):
        sides = order[turn:] + order[:turn]
        rows = list(zip(sides, trims[0], strict=True))
        if all(_fits(side_curve(surface, s), a, trim, curves, near) for (s, a), trim in rows):
            loop = [
                Strand(side_curve(surface, s), trim.edge, trim.reversed, tolerance)
                for (s, _), trim in rows
            ]
            spans = [side_curve(surface, s).domain for s, _ in sides]
            return loop, Sides([s for s, _ in sides], [a for _, a in sides], spans)
    return None


def _fits(
    side: NurbsCurve, against: bool, trim: _Trim, curves: list[NurbsCurve], near: float
) -> bool:
    """Whether a trim runs along a natural side (or both are one point)."""
    fine = side.evaluate(np.linspace(*side.domain, 8 * SAMPLES + 1))
    if trim.edge < 0:
        return bool(np.ptp(fine, axis=0).max() <= near)
    edge = curves[trim.edge]
    points = edge.evaluate(np.linspace(*edge.domain, SAMPLES))
    if trim.reversed != against:
        points = points[::-1]
    if np.abs(points[[0, -1]] - fine[[0, -1]]).max() > near:
        return False
    a, b = fine[:-1], fine[1:]
    along = b - a
    share = np.einsum("kid,id->ki", points[:, None] - a, along)
    share = np.clip(share / np.maximum(np.einsum("id,id->i", along, along), 1e-300), 0.0, 1.0)
    miss = np.linalg.norm(points[:, None] - (a + share[..., None] * along), axis=2).min(axis=1)
    # The chords of the sampled side are off its curve by their sagitta.
    sagitta = float(np.linalg.norm(fine[:-2] - 2.0 * fine[1:-1] + fine[2:], axis=1).max())
    return bool(miss.max() <= near + 0.25 * sagitta)
