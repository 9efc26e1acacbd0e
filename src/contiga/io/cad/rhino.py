"""3DM through rhino3dm: surfaces, extrusions and breps, instances placed.

rhino3dm gives a face's surface, the edges of its loops in space and their order, but not its
p-curves. If a face is only a part of its surface, the edges are projected onto the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from contiga.errors import FileError, GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import REMEDY, Assembly, Edge, merge_bodies, warn
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
from contiga.io.cad.projected_faces import ProjectedFace, Trim, add_projected
from contiga.io.cad.render_check import distances_to_polyline, find_mismatches, render_mesh
from contiga.io.cad.stitch import side_curve
from contiga.io.cad.unite_body import unite_pieces
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
N_SAMPLES = 9
"""Points at which an edge is compared with a side."""
MAX_DEPTH = 32
"""Largest depth of nested instances."""

_Converted = TypeVar("_Converted", NurbsCurve, NurbsSurface)


class _Item(NamedTuple):
    """An object with faces, at its place."""

    label: PartLabel
    geometry: Any
    """A Brep or a NurbsSurface."""
    matrix: FloatArray
    """(4, 4) placement in the file's length unit."""


def warm_up() -> None:
    """Import rhino3dm before the time limit of a file starts to count."""
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
        Not a 3DM file, one without surfaces, or with one that cannot be converted; objects meet,
        and `solids` is "refuse".

    Warns
    -----
    ContigaWarning
        Objects that are no surfaces, and faces without extent, are left out; a face is kept whole,
        or differs from its render mesh; objects that meet were united or kept.
    """
    inventory = _Model(path, file_unit, unit).inventory(choice, solids)
    if inventory.message:
        warn(f"{path}: solids {inventory.message}")
    return inventory.body


def list_rhino(
    path: Path, file_unit: str | None, unit: str | None, solids: Solids | None = None
) -> Inventory:
    """Return the inventory of a 3DM file; objects that meet are in its message."""
    return _Model(path, file_unit, unit).inventory(ALL, solids)


class _Model:
    """A file of rhino3dm, to be converted in whole or in part.

    A file that is not 3DM, or is damaged, is a `FileError`. Lengths are scaled from `file_unit`,
    else the file's own, to `unit`; if one is missing they stay.
    """

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
        """Return the selection as a body with the labels of all objects; see `Inventory`.

        Objects that meet are treated as `solids` says, and are in `apart`, each by itself.
        """
        import rhino3dm

        labels = [item.label for item in self._items]
        chosen = chosen_faces(labels, choice, str(self._path))
        bodies: dict[int, Body] = {}
        pieces: list[IndexArray] = []
        numbers: list[int] = []
        owner: list[int] = []
        scale = np.diag([self._scale, self._scale, self._scale, 1.0])
        for k, item in enumerate(self._items):
            is_chosen = [face.number in chosen for face in item.label.faces]
            if not any(is_chosen):
                continue
            faces, body = [0], None
            if isinstance(item.geometry, rhino3dm.NurbsSurface):
                body = Body(surface_from(item.geometry))
            else:
                body, faces = _brep(item, is_chosen, self._tolerance, str(self._path))
            if body is not None:
                bodies[k] = body.transformed(scale @ item.matrix)
                pieces += [len(owner) + piece for piece in bodies[k].pieces]
                numbers += [item.label.faces[face].number for face in faces]
                owner += [k] * len(faces)
        union = unite_pieces(
            merge_bodies(list(bodies.values()), self._path, self._unit),
            pieces,
            solids,
            str(self._path),
            accuracy=self._tolerance * self._scale,
            describe=lambda group: listed(
                dict.fromkeys(labels[owner[patches[0]]].title for patches in group)
            ),
        )
        met = {owner[patches[0]] for group in union.met for patches in group}
        apart = {labels[k].number: bodies[k] for k in sorted(met)}
        origin = [numbers[k] for k in union.origin]
        return Inventory(union.body, origin, labels, apart, union.message)


def _items(model: Any, path: Path) -> list[_Item]:
    """Return the objects with faces in the file's order, as Breps or NURBS surfaces.

    Objects of a definition are there for each instance that places them, and only so; instances
    nested deeper than `MAX_DEPTH` are left out. Objects that are no surfaces are left out with one
    warning of their types.
    """
    import rhino3dm

    by_id = {str(item.Attributes.Id): item for item in model.Objects}
    items: list[_Item] = []
    omitted: set[str] = set()

    def add(item: Any, matrix: FloatArray, place: tuple[str, ...]) -> None:
        geometry = item.Geometry
        if type(geometry).__name__ == "InstanceReference":
            if len(place) < MAX_DEPTH:
                inner = matrix @ np.array(geometry.Xform.ToFloatArray(True)).reshape(4, 4)
                definition = model.InstanceDefinitions.FindId(geometry.ParentIdefId)
                name = item.Attributes.Name or definition.Name
                for member in definition.GetObjectIds():
                    if str(member) in by_id:
                        add(by_id[str(member)], inner, (*place, name))
            return
        shape = geometry.ToBrep(True) if isinstance(geometry, rhino3dm.Extrusion) else geometry
        if not isinstance(shape, rhino3dm.Brep):
            shape = shape.ToNurbsSurface() if isinstance(shape, rhino3dm.Surface) else None
        if shape is None:
            omitted.add(type(geometry).__name__)
        else:
            items.append(_Item(_label(model, item, shape, place, items), shape, matrix))

    for item in model.Objects:
        if not item.Attributes.IsInstanceDefinitionObject:
            add(item, np.eye(4), ())
    if omitted:
        warn(f"{path}: objects of type {', '.join(sorted(omitted))} were left out")
    return items


def _label(
    model: Any, item: Any, shape: Any, place: tuple[str, ...], items: list[_Item]
) -> PartLabel:
    """Return the label of an object; its layer and those above it are other names that select it.

    The colour is its own, or that of its layer. `items` are the objects before it, after which it
    and its faces are numbered; `shape` is a Brep or a surface.
    """
    import rhino3dm

    attributes = item.Attributes
    layer = model.Layers.FindIndex(attributes.LayerIndex) if attributes.LayerIndex >= 0 else None
    layers = () if layer is None else tuple(layer.FullPath.split("::"))
    colour = None if layer is None else layer.Color
    if attributes.ColorSource == rhino3dm.ObjectColorSource.ColorFromObject:
        colour = attributes.ObjectColor
    code = None if colour is None else "#{:02x}{:02x}{:02x}".format(*colour[:3])
    is_brep = isinstance(shape, rhino3dm.Brep)
    count = len(shape.Faces) if is_brep else 1
    first = 1 + sum(len(other.label.faces) for other in items)
    faces = tuple(FaceLabel(first + k, "NURBS", None, code) for k in range(count))
    is_solid = is_brep and bool(shape.IsSolid)
    kind = "solid" if is_solid else "shell" if count > 1 else "faces"
    return PartLabel(len(items) + 1, kind, faces, attributes.Name or None, place, layers, code)


def surface_from(surface: Any) -> NurbsSurface:
    """Convert a rhino3dm.NurbsSurface, which lacks the end knots and stores (wx, wy, wz, w).

    An error in it is a `GeometryError`; weights are kept if it says that it is rational.
    """
    points = surface.Points
    n, m = points.CountU, points.CountV
    net = np.empty((n, m, 4))
    for i in range(n):
        for j in range(m):
            point = points.GetControlPoint(i, j)
            net[i, j] = point.X, point.Y, point.Z, point.W
    weights = net[..., 3] if surface.IsRational else None
    degrees = (surface.Degree(0), surface.Degree(1))
    knots = (_full_knots(surface.KnotsU), _full_knots(surface.KnotsV))
    return NurbsSurface(degrees, knots, net[..., :3] / net[..., 3:], weights)


def curve_from(curve: Any) -> NurbsCurve:
    """Convert a rhino3dm.NurbsCurve, as `surface_from` converts a surface."""
    net = np.array(
        [(p.X, p.Y, p.Z, p.W) for p in (curve.Points[i] for i in range(len(curve.Points)))]
    )
    weights = net[:, 3] if curve.IsRational else None
    return NurbsCurve(curve.Degree, _full_knots(curve.Knots), net[:, :3] / net[:, 3:], weights)


def _full_knots(knots: Any) -> FloatArray:
    """Return the knots of rhino3dm with the first and the last one once more."""
    inner = np.array([knots[i] for i in range(len(knots))], dtype=np.float64)
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _brep(
    item: _Item, is_chosen: list[bool], tolerance: float, where: str
) -> tuple[Body | None, list[int]]:
    """Return the chosen faces of a Brep as a body, unplaced, and the indices of those with area.

    The body is None if none has any. Faces whose trims are the sides of their surface become whole
    patches; edges of others are projected onto the surface. A face that differs from its render
    mesh gives a warning.
    """
    brep = item.geometry
    curves = [
        _convert(f"{where}, edge {i}", curve_from, brep.Edges[i].ToNurbsCurve())
        for i in range(len(brep.Edges))
    ]
    assembly = Assembly(where)
    rows = []
    for i in np.flatnonzero(is_chosen).tolist():
        face = brep.Faces[i]
        label = f"{where}, face {item.label.faces[i].number}"
        surface = _convert(label, surface_from, face.UnderlyingSurface().ToNurbsSurface())
        loops = []
        for k in range(len(face.Loops)):
            trims = (face.Loops[k].Trims[j] for j in range(face.Loops[k].TrimCount))
            loops.append([Trim(int(trim.EdgeIndex), bool(trim.IsReversed)) for trim in trims])
        flip = bool(face.OrientationIsReversed)
        sides = _natural_sides(surface, loops, curves, tolerance)
        if sides is not None:
            assembly.add_whole(surface, *sides, flip=flip)
            rows.append(i)
        elif add_projected(assembly, ProjectedFace(surface, loops, flip, label), curves, tolerance):
            rows.append(i)
    if not rows:
        return None, rows
    body = assembly.body("brep", lambda number: Edge(curves[number], tolerance), None)
    for k, difference in find_mismatches(body, [render_mesh(brep.Faces[i]) for i in rows]):
        warn(f"{where}, face {item.label.faces[rows[k]].number} is in doubt: {difference}")
    return body, rows


def _convert(label: str, converter: Callable[[Any], _Converted], geometry: Any) -> _Converted:
    """Return `converter(geometry)`; its `GeometryError` becomes a `FileError` at `label`."""
    try:
        return converter(geometry)
    except GeometryError as error:
        raise FileError(str(error), where=label, remedy=REMEDY) from error


def _natural_sides(
    surface: NurbsSurface, loops: list[list[Trim]], curves: list[NurbsCurve], tolerance: float
) -> tuple[Loop, Sides] | None:
    """Return the sides of a surface as a loop, with their `Sides`, if four trims run along them.

    Its first trim may be any of the sides; a trim may be `tolerance`, or 1e-9 of the size, off
    its side. None for other loops, or more than one.
    """
    if len(loops) != 1 or len(loops[0]) != 4:
        return None
    size = float(np.ptp(surface.bounds(), axis=0).max())
    near = max(tolerance, 1e-9 * size)
    # Outer loops run counter-clockwise: up u on v0, up v on u1, and back.
    order = [(2, False), (1, False), (3, True), (0, True)]
    side_curves = {side: side_curve(surface, side) for side, _ in order}
    for turn in range(4):
        sides = order[turn:] + order[:turn]
        if all(
            _runs_along(side_curves[side], against, trim, curves, near)
            for (side, against), trim in zip(sides, loops[0], strict=True)
        ):
            loop = [
                PCurve(side_curves[side], trim.edge, trim.reversed, tolerance)
                for (side, _), trim in zip(sides, loops[0], strict=True)
            ]
            spans = [side_curves[side].domain for side, _ in sides]
            return loop, Sides([side for side, _ in sides], [a for _, a in sides], spans)
    return None


def _runs_along(
    side: NurbsCurve, against: bool, trim: Trim, curves: list[NurbsCurve], near: float
) -> bool:
    """Return whether a trim runs along a natural side, against its parameter if `against`.

    At a pole the side must be one point. Else the ends must meet within `near`, in each coordinate,
    and `N_SAMPLES` points of the edge be within `near`, plus twice the sagitta of its chords, of
    the sampled side.
    """
    fine = side.evaluate(np.linspace(*side.domain, 8 * N_SAMPLES + 1))
    if trim.edge < 0:
        return bool(np.ptp(fine, axis=0).max() <= near)
    edge = curves[trim.edge]
    points = edge.evaluate(np.linspace(*edge.domain, N_SAMPLES))
    if trim.reversed != against:
        points = points[::-1]
    if np.abs(points[[0, -1]] - fine[[0, -1]]).max() > near:
        return False
    # The chords of the sampled side are off its curve by their sagitta.
    sagitta = float(np.linalg.norm(fine[:-2] - 2.0 * fine[1:-1] + fine[2:], axis=1).max())
    return bool(distances_to_polyline(points, fine).max() <= near + 0.25 * sagitta)
