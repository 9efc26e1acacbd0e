"""STEP and IGES through OpenCASCADE: every face as a NURBS patch with its loops and edges.

OpenCASCADE transfers the file (assemblies with their placements, units to millimetres) and builds
the p-curves that the file does not carry. What it hands over is converted exactly: B-splines and
planes as they are, analytic surfaces in their rational form, p-curves along.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import FileError, GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.io.cad import occ_geometry as occ
from contiga.io.cad.assemble import MEND, Assembly, Edge, warn
from contiga.io.cad.loops import (
    OPEN,
    THIN,
    Loop,
    PCurve,
    Sides,
    aligned,
    chained,
    ends,
    exact_box,
    gaps,
    rectangle_sides,
)
from contiga.io.cad.occ_parts import compound_of, labelled
from contiga.io.cad.occ_piercing import refuse_pierced
from contiga.io.cad.occ_transfer import transferred
from contiga.io.cad.parts import ALL, Choice, Inventory, PartLabel, Solids, chosen_faces
from contiga.io.cad.sew import Sewn, members
from contiga.io.cad.unite import Meeting, Numbered, Placed, placed_of, said_of
from contiga.io.cad.warp import AngleMap, bent
from contiga.io.naming import listed
from contiga.io.units import length_factor, short_name
from contiga.masters.body import Body
from contiga.records import FloatArray

OCC_UNIT = "mm"
"""OpenCASCADE converts every file to millimetres."""
ROUNDED = 1e-11
"""Rounding of bounds by OpenCASCADE, as a share of a face; it is coarser than that of float64."""


class RawFace(NamedTuple):
    """A face in OpenCASCADE's own parameters."""

    surface: Any
    loops: list[Loop]
    box: FloatArray
    """(2, 2) low and high (u, v)."""
    speed: FloatArray
    """(2,) largest |S_u|, |S_v|."""
    reversed: bool


def warm_up() -> None:
    """Load OpenCASCADE, its tables and the kernels in use, before the time of a file counts."""
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    with occ.quiet():
        STEPCAFControl_Reader()
        IGESCAFControl_Reader()
    slope = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], [[0.0, 0.0], [1.0, 1.0]])
    half = AngleMap(np.array([0.0, 0.5, 1.0]))
    bent(slope, (half, half), np.ones(2))


def read_step_iges(
    path: Path,
    file_unit: str | None,
    unit: str | None,
    choice: Choice = ALL,
    solids: Solids | None = None,
) -> Body:
    """Return the faces of a STEP or IGES file as a body in `unit`; see `io.cad.read_cad`."""
    with occ.quiet():
        return _Model(path, file_unit, unit, solids).body(choice)


def list_step_iges(
    path: Path, file_unit: str | None, unit: str | None, solids: Solids | None = None
) -> Inventory:
    """Return the inventory of a STEP or IGES file."""
    with occ.quiet():
        return _Model(path, file_unit, unit, solids).inventory()


class _Model:
    """A file of OpenCASCADE, to be converted whole or in part."""

    def __init__(
        self, path: Path, file_unit: str | None, unit: str | None, solids: Solids | None
    ) -> None:
        transfer = transferred(path)
        unit_name = file_unit or transfer.unit
        # OpenCASCADE has multiplied by the unit the file states, which file_unit overrides.
        stated = 1.0 if transfer.unit is None else length_factor(OCC_UNIT, transfer.unit, str(path))
        wanted = length_factor(unit_name, unit, str(path)) if unit_name and unit else 1.0
        self._path, self._pieces, self._solids = path, transfer.pieces, solids
        self._scale = _product(stated, wanted)
        self._unit = short_name(unit or unit_name) if unit_name else None
        to_occ = 1.0 if transfer.unit is None else length_factor(transfer.unit, OCC_UNIT, str(path))
        self._accuracy = transfer.accuracy * to_occ
        self._sewn = Sewn(compound_of(piece.shape for piece in transfer.pieces))
        self._parts = labelled(transfer.pieces, self._sewn)

    def body(self, choice: Choice) -> Body:
        """Return the selection, as if the file had nothing else."""
        placed, said = self._select_faces(choice)
        if said:
            warn(f"{self._path}: solids {said}")
        body, _, _ = self._assemble(placed)
        return body

    def inventory(self) -> Inventory:
        """Return everything, and the parts that share faces or edges with others alone, too."""
        placed, said = self._select_faces(ALL)
        body, numbers, assembly = self._assemble(placed)
        owner = {face.number: part.number for part in self._parts for face in part.faces}
        mixed = set(assembly.entangled([owner[number] for number in numbers]))
        mixed |= {part.number for meeting in placed.meetings for part in self._parts_of(meeting)}
        apart = {number: self.body(Choice(parts=(number,))) for number in sorted(mixed)}
        return Inventory(body, numbers, self._parts, apart, said)

    def _select_faces(self, choice: Choice) -> tuple[Placed, str]:
        """Return the selected faces and a message about solids that meet.

        Those are treated as requested.
        """
        chosen = chosen_faces(self._parts, choice, str(self._path))
        placed = placed_of(self._pieces, chosen, self._accuracy, self._solids)
        texts = [
            f"{listed(part.title for part in self._parts_of(meeting))} {meeting.at(self._scale)}"
            for meeting in placed.meetings
        ]
        return placed, said_of(placed, texts, self._solids, str(self._path))

    def _parts_of(self, meeting: Meeting) -> list[PartLabel]:
        firsts = np.cumsum([1, *(len(piece.faces) for piece in self._pieces)])
        wanted = set(firsts[list(meeting.pieces)].tolist())
        return [part for part in self._parts if part.faces[0].number in wanted]

    def _assemble(self, placed: Placed) -> tuple[Body, list[int], Assembly]:
        """Return the faces as a body, the number in the file of each patch, and the assembly."""
        whole = len(placed.faces) == sum(len(piece.faces) for piece in self._pieces)
        sewn = self._sewn if whole and not placed.meetings else Sewn(placed.shape)
        assembly = Assembly(str(self._path))
        numbers = gather(assembly, placed.faces, sewn, self._scale, f"{self._path}, face")
        edges = partial(edge_of, sewn, self._scale, self._accuracy)
        body = assembly.body(self._path.stem, edges, self._unit)
        if placed.embedded and placed.solids_only:
            body = body.known_apart()
        return body, numbers, assembly


def gather(
    assembly: Assembly, faces: Sequence[Numbered], sewn: Sewn, scale: float, where: str
) -> list[int]:
    """Add faces, oriented by sewing; return the numbers of those with area."""
    from OCP.TopoDS import TopoDS

    return [
        number
        for number, face in faces
        if add_face(
            assembly,
            TopoDS.Face(face.Reversed()) if sewn.turned(face) else face,
            sewn,
            scale,
            f"{where} {number}",
        )
    ]


def _product(a: float, b: float) -> float:
    """Return a · b rounded to 15 digits, the accuracy of units: 0.001 · 1000 is 1."""
    return float(f"{a * b:.15g}")


def edge_of(sewn: Sewn, scale: float, accuracy: float, number: int) -> Edge | None:
    """Return curve and tolerances of an edge by its number; None without a curve in space."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    edge = sewn.edge(number)
    curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    if curve is None and BRepLib.BuildCurve3d_s(edge):
        curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
    if curve is None:
        return None
    first, last = BRep_Tool.Range_s(edge)
    corner = accuracy
    for vertex in members(edge):
        corner = max(corner, BRep_Tool.Tolerance_s(TopoDS.Vertex(vertex)))
    tolerance = BRep_Tool.Tolerance_s(edge) * scale
    return Edge(occ.curve3d_from(curve, first, last, scale), tolerance, corner * scale)


def add_face(assembly: Assembly, face: Any, edges: Sewn, scale: float, where: str) -> bool:
    """Convert a TopoDS_Face and add it if it has an area; `edges` numbers its edges."""
    raw = _raw_face(face, edges)
    if raw is None or _is_thin(raw):
        warn(f"{where}: a face without extent was left out")
        return False
    refuse_pierced(raw.surface, raw.box, scale, where)
    sides = rectangle_sides(raw.loops[0], raw.box, raw.speed) if len(raw.loops) == 1 else None
    closed = _is_closed(raw, where)
    whole = sides is None and closed
    try:
        patch = occ.patch_from(raw.surface, raw.box, whole, scale)
    except GeometryError as error:
        raise FileError(str(error), where=where, remedy=MEND) from error
    if patch.off > 0.0:
        warn(
            f"{where}: its surface has no NURBS form (an offset surface, for example) and is "
            f"approximated, to {patch.off:.2g}"
        )
    if not whole:
        loop = raw.loops[0] if sides is not None else None
        mapped = None if sides is None else _mapped_sides(sides, patch)
        assembly.add_whole(patch.surface, loop, mapped, flip=raw.reversed)
        return True
    span = np.array([np.ptp(interval) for interval in patch.surface.domain])
    loops = [
        [pcurve._replace(curve=bent(pcurve.curve, patch.maps, span)) for pcurve in loop]
        for loop in raw.loops
    ]
    assembly.add_trimmed(patch.surface, loops, where, flip=raw.reversed)
    return True


def _is_thin(raw: RawFace) -> bool:
    """Return whether the loops of a face enclose a line or a point in (u, v)."""
    extent = (raw.box[1] - raw.box[0]) * raw.speed
    return bool(extent.min() <= THIN * extent.max())


def _is_closed(raw: RawFace, where: str) -> bool:
    """Return whether the loops close; a face with an open loop is kept whole, with a warning."""
    size = float(np.linalg.norm((raw.box[1] - raw.box[0]) * raw.speed))
    worst = max((_largest_gap(loop, raw.surface) for loop in raw.loops), default=0.0)
    if worst > OPEN * size:
        warn(
            f"{where}: a trimming loop is open by {worst:.3g} mm; the face is kept as the "
            "rectangle around its loops"
        )
        return False
    return True


def _largest_gap(loop: Loop, surface: Any) -> float:
    """Return the largest gap of a loop in space; poles are no gaps."""
    worst = 0.0
    for pcurve, gap in zip(loop, gaps(loop), strict=True):
        if gap.any():
            (u, v), (x, y) = ends(pcurve)[1], ends(pcurve)[1] + gap
            point = surface.Value(float(u), float(v))
            worst = max(worst, float(point.Distance(surface.Value(float(x), float(y)))))
    return worst


def _mapped_sides(sides: Sides, patch: occ.Patch) -> Sides:
    """Return the intervals along the sides in the patch's own parameters."""
    spans = []
    for side, (low, high) in zip(sides.side, sides.span, strict=True):
        axis = 1 - side // 2
        a, b = patch.surface.domain[axis]
        mapped = np.clip(patch.maps[axis](np.array([low, high])), a, b)
        spans.append((float(mapped[0]), float(mapped[1])))
    return sides._replace(span=spans)


def _raw_face(face: Any, edges: Sewn) -> RawFace | None:
    """Return surface, ordered loops and bounds of a face; None without area."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    surface = occ.base_surface(BRep_Tool.Surface_s(face))
    if surface is None:
        return None
    # Loops are read off the face turned forward: its own orientation is kept apart.
    forward = TopoDS.Face(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    periods = occ.periods_of(surface)
    loops = []
    for wire in members(forward):
        if wire.ShapeType() == TopAbs_ShapeEnum.TopAbs_WIRE:
            pcurves = _pcurves(TopoDS.Wire(wire), forward, edges)
            if pcurves:
                loops.append(chained(pcurves, periods))
    loops = aligned(loops, periods)
    box = _box(surface, loops, periods)
    if not np.isfinite(box).all():
        return None
    turned = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return RawFace(surface, loops, box, occ.speed_of(surface, box), turned)


def _box(surface: Any, loops: list[Loop], periods: FloatArray) -> FloatArray:
    """Return the parameter bounds (2, 2) of the loops, or of the surface without loops.

    They lie within the surface's own.
    """
    u0, u1, v0, v1 = surface.Bounds()
    natural = np.array([[u0, v0], [u1, v1]])
    natural[np.abs(natural) > 1e99] = np.inf
    natural[0][np.isinf(natural[0])] = -np.inf
    if not loops:
        return natural
    box = exact_box([pcurve for loop in loops for pcurve in loop])
    periodic = periods > 0.0
    box[0] = np.where(periodic, box[0], np.maximum(box[0], natural[0]))
    box[1] = np.where(
        periodic, np.minimum(box[1], box[0] + periods), np.minimum(box[1], natural[1])
    )
    # Bounds within rounding of the natural ones become those, so that a pole has no hole.
    near = ROUNDED * (box[1] - box[0])
    box[0] = np.where(~periodic & (box[0] - natural[0] <= near), natural[0], box[0])
    box[1] = np.where(~periodic & (natural[1] - box[1] <= near), natural[1], box[1])
    return box


def _pcurves(wire: Any, face: Any, edges: Sewn) -> Loop:
    """Return the p-curves of a wire in order, each in the wire's direction."""
    pcurves = [_pcurve(edge, face, edges) for edge in _wire_edges(wire, face)]
    return [pcurve for pcurve in pcurves if pcurve is not None]


def _wire_edges(wire: Any, face: Any) -> list[Any]:
    """Return edges in order of connection, or as stored if the explorer cannot follow the wire."""
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopoDS import TopoDS

    ordered = []
    explorer = BRepTools_WireExplorer(wire, face)
    while explorer.More():
        ordered.append(explorer.Current())
        explorer.Next()
    borders = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)
    stored = [TopoDS.Edge(edge) for edge in members(wire) if edge.Orientation() in borders]
    return ordered if len(ordered) == len(stored) else stored


def _pcurve(edge: Any, face: Any, edges: Sewn) -> PCurve | None:
    from OCP.BRep import BRep_Tool
    from OCP.ShapeFix import ShapeFix_Edge
    from OCP.TopAbs import TopAbs_Orientation

    curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
    if curve is None:
        ShapeFix_Edge().FixAddPCurve(edge, face, BRep_Tool.IsClosed_s(edge, face))
        curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        if curve is None:
            return None
    first, last = BRep_Tool.Range_s(edge, face)
    if not first < last:
        return None
    image = occ.pcurve_from(curve, first, last)
    turned = edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    number, against = (-1, False) if BRep_Tool.Degenerated_s(edge) else edges.add(edge)
    tolerance = float(BRep_Tool.Tolerance_s(edge))
    return PCurve(image.reversed() if turned else image, number, turned != against, tolerance)
