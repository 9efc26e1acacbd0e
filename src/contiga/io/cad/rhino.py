"""3DM through rhino3dm: surfaces, extrusions and breps, instances placed.

rhino3dm gives a face's surface, the edges of its loops in space and their order, but not its
p-curves. Where a face is not the whole of its surface they are drawn from the edges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from contiga.errors import FileError, GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import MEND, Assembly, Edge, merged, warn
from contiga.io.cad.drawn import DrawnFace, Trim, add_drawn
from contiga.io.cad.loops import Loop, PCurve, Sides
from contiga.io.cad.parts import (
    ALL,
    Choice,
    FaceLabel,
    Inventory,
    PartLabel,
    Solids,
    chosen_faces,
)
from contiga.io.cad.rendered import doubts, render_mesh, to_polyline
from contiga.io.cad.stitch import side_curve
from contiga.io.cad.unite_body import united
from contiga.io.naming import listed
from contiga.io.units import length_factor, short_name
from contiga.masters.body import Body
from contiga.records import FloatArray, IndexArray

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

_Made = TypeVar("_Made")


class _Item(NamedTuple):
    """An object with faces, at its place."""

    label: PartLabel
    geometry: Any
    """A Brep or a NurbsSurface."""
    matrix: FloatArray
    """(4, 4) placement in the file's length unit."""


def warm_up() -> None:
    """Load what the reader needs, before the time of a file counts."""
    import rhino3dm  # noqa: F401


def read_rhino(
    path: Path,
    file_unit: str | None,
    unit: str | None,
    choice: Choice = ALL,
    solids: Solids | None = None,
) -> Body:
    """Return the faces of a 3DM file as one body; see `contiga.io.cad.read_cad.read_cad`.

    Raises
    ------
    FileError
        Not a 3DM file, or one without surfaces.
    """
    inventory = _Model(path, file_unit, unit).inventory(choice, solids)
    if inventory.said:
        warn(f"{path}: solids {inventory.said}")
    return inventory.body


def list_rhino(
    path: Path, file_unit: str | None, unit: str | None, solids: Solids | None = None
) -> Inventory:
    """Return the inventory of a 3DM file."""
    return _Model(path, file_unit, unit).inventory(ALL, solids)


class _Model:
    """A file of rhino3dm, to be converted whole or in part."""

    def __init__(self, path: Path, file_unit: str | None, unit: str | None) -> None:
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
        unit_name = file_unit or _UNITS.get(model.Settings.ModelUnitSystem.name)
        self._path = path
        self._scale = length_factor(unit_name, unit, str(path)) if unit_name and unit else 1.0
        self._unit = short_name(unit or unit_name) if unit_name else None
        self._tolerance = max(float(model.Settings.ModelAbsoluteTolerance), 1e-9)
        self._items = _items(model, path)

    def inventory(self, choice: Choice, solids: Solids | None) -> Inventory:
        """Return the selection as a body; objects that meet are treated as requested."""
        labels = [item.label for item in self._items]
        chosen = chosen_faces(labels, choice, str(self._path))
        alone: dict[int, Body] = {}
        pieces: list[IndexArray] = []
        numbers: list[int] = []
        owner: list[int] = []
        for k, item in enumerate(self._items):
            wanted = [face.number in chosen for face in item.label.faces]
            body, kept = self._body(item, wanted) if any(wanted) else (None, [])
            if body is not None:
                scale = np.diag([self._scale, self._scale, self._scale, 1.0])
                alone[k] = body.transformed(scale @ item.matrix)
                pieces += [len(owner) + piece for piece in alone[k].pieces]
                numbers += [item.label.faces[face].number for face in kept]
                owner += [k] * len(kept)
        whole = merged(list(alone.values()), self._path, self._unit)

        def title(patches: Sequence[int]) -> str:
            return labels[owner[patches[0]]].title

        union = united(
            whole,
            pieces,
            solids,
            str(self._path),
            accuracy=self._tolerance * self._scale,
            describe=lambda some: listed(dict.fromkeys(map(title, some))),
        )
        met = {owner[patches[0]] for some in union.met for patches in some}
        apart = {labels[k].number: alone[k] for k in sorted(met)}
        origin = [numbers[k] for k in union.origin]
        return Inventory(union.body, origin, labels, apart, union.said)

    def _body(self, item: _Item, wanted: list[bool]) -> tuple[Body | None, list[int]]:
        """Return the wanted faces of an object, unplaced, and the numbers of those with area."""
        import rhino3dm

        if isinstance(item.geometry, rhino3dm.NurbsSurface):
            return Body(surface_from(item.geometry)), [0]
        body, kept = _brep(item, wanted, self._tolerance, str(self._path))
        if body is not None:
            meshes = [render_mesh(item.geometry.Faces[i]) for i in kept]
            for k, doubt in doubts(body, meshes):
                number = item.label.faces[kept[k]].number
                warn(f"{self._path}, face {number} is in doubt: {doubt}")
        return body, kept


def _items(model: Any, path: Path) -> list[_Item]:
    """Return the objects with faces; instances are resolved to their definitions."""
    by_id = {str(item.Attributes.Id): item for item in model.Objects}
    items: list[_Item] = []
    left_out: set[str] = set()

    def follow(item: Any, matrix: FloatArray, place: tuple[str, ...]) -> None:
        geometry = item.Geometry
        if type(geometry).__name__ != "InstanceReference":
            shape = _geometry_with_faces(geometry)
            if shape is None:
                left_out.add(type(geometry).__name__)
            else:
                items.append(_Item(_label(model, item, shape, place, items), shape, matrix))
        elif len(place) < 32:
            inner = matrix @ np.array(geometry.Xform.ToFloatArray(True)).reshape(4, 4)
            definition = model.InstanceDefinitions.FindId(geometry.ParentIdefId)
            name = item.Attributes.Name or definition.Name
            for member in definition.GetObjectIds():
                if str(member) in by_id:
                    follow(by_id[str(member)], inner, (*place, name))

    for item in model.Objects:
        if not item.Attributes.IsInstanceDefinitionObject:
            follow(item, np.eye(4), ())
    if left_out:
        warn(f"{path}: objects of type {', '.join(sorted(left_out))} were left out")
    return items


def _geometry_with_faces(geometry: Any) -> Any:
    """Return a Brep or a NurbsSurface of an object; None if it has no faces."""
    import rhino3dm

    if isinstance(geometry, rhino3dm.Extrusion):
        geometry = geometry.ToBrep(True)
    if isinstance(geometry, rhino3dm.Brep):
        return geometry
    return geometry.ToNurbsSurface() if isinstance(geometry, rhino3dm.Surface) else None


def _label(
    model: Any, item: Any, shape: Any, place: tuple[str, ...], before: list[_Item]
) -> PartLabel:
    """Return the label of an object: its name or layer, and other names that select it."""
    import rhino3dm

    said = item.Attributes
    layer = model.Layers.FindIndex(said.LayerIndex) if said.LayerIndex >= 0 else None
    layers = () if layer is None else tuple(layer.FullPath.split("::"))
    colour = None if layer is None else layer.Color
    if said.ColorSource == rhino3dm.ObjectColorSource.ColorFromObject:
        colour = said.ObjectColor
    code = None if colour is None else "#{:02x}{:02x}{:02x}".format(*colour[:3])
    is_brep = isinstance(shape, rhino3dm.Brep)
    count = len(shape.Faces) if is_brep else 1
    first = 1 + sum(len(other.label.faces) for other in before)
    faces = tuple(FaceLabel(first + k, "NURBS", None, code) for k in range(count))
    solid = is_brep and bool(shape.IsSolid)
    kind = "solid" if solid else "shell" if count > 1 else "faces"
    name = said.Name or None
    return PartLabel(len(before) + 1, kind, faces, name, place, layers, code)


def surface_from(surface: Any) -> NurbsSurface:
    """Return a rhino3dm.NurbsSurface; it lacks the end knots, and its points are (wx, …, w)."""
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
    """Return a rhino3dm.NurbsCurve."""
    net = np.array(
        [(p.X, p.Y, p.Z, p.W) for p in (curve.Points[i] for i in range(len(curve.Points)))]
    )
    weights = net[:, 3] if curve.IsRational else None
    return NurbsCurve(curve.Degree, _full(curve.Knots), net[:, :3] / net[:, 3:], weights)


def _full(knots: Any) -> FloatArray:
    inner = np.array([knots[i] for i in range(len(knots))], dtype=np.float64)
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _brep(
    item: _Item, wanted: list[bool], tolerance: float, where: str
) -> tuple[Body | None, list[int]]:
    brep = item.geometry
    curves = [
        _convert(f"{where}, edge {i}", curve_from, brep.Edges[i].ToNurbsCurve())
        for i in range(len(brep.Edges))
    ]
    assembly = Assembly(where)
    kept = []
    for i in np.flatnonzero(wanted).tolist():
        face = brep.Faces[i]
        name = f"{where}, face {item.label.faces[i].number}"
        surface = _convert(name, surface_from, face.UnderlyingSurface().ToNurbsSurface())
        trims = [_trims(face.Loops[k]) for k in range(len(face.Loops))]
        turned = bool(face.OrientationIsReversed)
        sides = _natural_sides(surface, trims, curves, tolerance)
        if sides is not None:
            assembly.add_whole(surface, *sides, flip=turned)
            kept.append(i)
        elif add_drawn(assembly, DrawnFace(surface, trims, turned, name), curves, tolerance):
            kept.append(i)

    if not kept:
        return None, kept
    return assembly.body("brep", lambda number: Edge(curves[number], tolerance), None), kept


def _convert(name: str, made: Callable[[Any], _Made], geometry: Any) -> _Made:
    """Return what `made` makes of a curve or surface; errors name it."""
    try:
        return made(geometry)
    except GeometryError as error:
        raise FileError(str(error), where=name, remedy=MEND) from error


def _trims(loop: Any) -> list[Trim]:
    trims = (loop.Trims[i] for i in range(loop.TrimCount))
    return [Trim(int(trim.EdgeIndex), bool(trim.IsReversed)) for trim in trims]


def _natural_sides(
    surface: NurbsSurface, trims: list[list[Trim]], curves: list[NurbsCurve], tolerance: float
) -> tuple[Loop, Sides] | None:
    """Return the four sides as a loop if the trims are just those, else None."""
    if len(trims) != 1 or len(trims[0]) != 4:
        return None
    size = float(np.ptp(surface.bounds(), axis=0).max())
    near = max(tolerance, 1e-9 * size)
    # Outer loops run counter-clockwise: up u on v0, up v on u1, and back.
    order = [(2, False), (1, False), (3, True), (0, True)]
    for turn in range(4):
        sides = order[turn:] + order[:turn]
        rows = list(zip(sides, trims[0], strict=True))
        if all(_fits(side_curve(surface, s), a, trim, curves, near) for (s, a), trim in rows):
            loop = [
                PCurve(side_curve(surface, s), trim.edge, trim.reversed, tolerance)
                for (s, _), trim in rows
            ]
            spans = [side_curve(surface, s).domain for s, _ in sides]
            return loop, Sides([s for s, _ in sides], [a for _, a in sides], spans)
    return None


def _fits(
    side: NurbsCurve, against: bool, trim: Trim, curves: list[NurbsCurve], near: float
) -> bool:
    """Return whether a trim runs along a natural side (or both are one point)."""
    fine = side.evaluate(np.linspace(*side.domain, 8 * SAMPLES + 1))
    if trim.edge < 0:
        return bool(np.ptp(fine, axis=0).max() <= near)
    edge = curves[trim.edge]
    points = edge.evaluate(np.linspace(*edge.domain, SAMPLES))
    if trim.reversed != against:
        points = points[::-1]
    if np.abs(points[[0, -1]] - fine[[0, -1]]).max() > near:
        return False
    # The chords of the sampled side are off its curve by their sagitta.
    sagitta = float(np.linalg.norm(fine[:-2] - 2.0 * fine[1:-1] + fine[2:], axis=1).max())
    return bool(to_polyline(points, fine).max() <= near + 0.25 * sagitta)
