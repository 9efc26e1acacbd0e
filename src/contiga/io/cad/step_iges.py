"""STEP and IGES through OpenCASCADE: every face as a NURBS patch with its loops and edges.

OpenCASCADE transfers the file (assemblies with their placements, units to millimetres) and builds
the p-curves that the file does not have. Its shapes are converted exactly: B-splines and planes as
they are, analytic surfaces and their p-curves in rational form.
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
from contiga.io.cad.assemble import REMEDY, Assembly, Edge, warn
from contiga.io.cad.loops import (
    OPEN_TOL,
    THIN_TOL,
    Loop,
    PCurve,
    align_loops,
    chain_pcurves,
    ends,
    exact_box,
    gaps,
    rectangle_sides,
)
from contiga.io.cad.occ_parts import compound_of, part_labels
from contiga.io.cad.occ_piercing import refuse_self_intersection
from contiga.io.cad.occ_transfer import transfer_file
from contiga.io.cad.parts import ALL, Choice, Inventory, PartLabel, Solids, chosen_faces
from contiga.io.cad.sew import SewnEdges, members
from contiga.io.cad.unite import Meeting, Numbered, PlacedFaces, meeting_message, place_faces
from contiga.io.cad.warp import AngleMap, map_pcurve
from contiga.io.naming import listed
from contiga.io.units import length_factor, short_name
from contiga.masters.body import Body
from contiga.records import FloatArray

OCC_UNIT = "mm"
"""OpenCASCADE converts every file to millimetres."""
BOUNDS_TOL = 1e-11
"""Rounding of bounds by OpenCASCADE, as a share of a face; it is coarser than that of float64."""


class RawFace(NamedTuple):
    """A face in OpenCASCADE's own parameters."""

    surface: Any
    """Geom_Surface below any rectangular trimming."""
    loops: list[Loop]
    box: FloatArray
    """(2, 2) low and high (u, v)."""
    speed: FloatArray
    """(2,) largest |S_u|, |S_v|."""
    reversed: bool
    """Whether its free side is the surface's other side."""


def warm_up() -> None:
    """Load OpenCASCADE, its tables and the kernels in use, before the time of a file counts."""
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    with occ.quiet():
        STEPCAFControl_Reader()
        IGESCAFControl_Reader()
    slope = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], [[0.0, 0.0], [1.0, 1.0]])
    half = AngleMap(np.array([0.0, 0.5, 1.0]))
    map_pcurve(slope, (half, half), np.ones(2))


def read_step_iges(
    path: Path,
    file_unit: str | None,
    unit: str | None,
    choice: Choice = ALL,
    solids: Solids | None = None,
) -> Body:
    """Return the faces of a STEP or IGES file as a body in `unit`; see `io.cad.read_cad`.

    Raises
    ------
    FileError
        The file is damaged or of another format, a number is not finite, a face has no NURBS form
        or meets itself; solids meet, and `solids` is "refuse".

    Warns
    -----
    ContigaWarning
        Faces without extent, with open loops or approximated surfaces; solids that meet.
    """
    with occ.quiet():
        return _Model(path, file_unit, unit, solids).body(choice)


def list_step_iges(
    path: Path, file_unit: str | None, unit: str | None, solids: Solids | None = None
) -> Inventory:
    """Return the inventory of a STEP or IGES file; solids that meet are in its message.

    Other warnings and errors are those of `read_step_iges`.
    """
    with occ.quiet():
        return _Model(path, file_unit, unit, solids).inventory()


class _Model:
    """A file of OpenCASCADE, to be converted in whole or in part.

    Lengths are scaled from `file_unit`, else the file's own, to `unit`; if one is missing they
    stay.
    """

    def __init__(
        self, path: Path, file_unit: str | None, unit: str | None, solids: Solids | None
    ) -> None:
        transfer = transfer_file(path)
        unit_name = file_unit or transfer.unit
        # OpenCASCADE has multiplied by the unit the file states, which file_unit overrides.
        to_stated, to_occ = 1.0, 1.0
        if transfer.unit is not None:
            to_stated = length_factor(OCC_UNIT, transfer.unit, str(path))
            to_occ = length_factor(transfer.unit, OCC_UNIT, str(path))
        to_unit = length_factor(unit_name, unit, str(path)) if unit_name and unit else 1.0
        self._path, self._pieces, self._solids = path, transfer.pieces, solids
        # Units are accurate to 15 digits: 0.001 · 1000 is 1.
        self._scale = float(f"{to_stated * to_unit:.15g}")
        self._unit = short_name(unit or unit_name) if unit_name else None
        self._accuracy = transfer.accuracy * to_occ
        self._edges = SewnEdges(compound_of(piece.shape for piece in transfer.pieces))
        self._parts = part_labels(transfer.pieces, self._edges)

    def body(self, choice: Choice) -> Body:
        """Return the selection as a body, as if the file had nothing else.

        Solids that meet give a warning, or a `FileError` if they are to be refused.
        """
        placed, message = self._select_faces(choice)
        if message:
            warn(f"{self._path}: solids {message}")
        body, _, _ = self._assemble(placed)
        return body

    def inventory(self) -> Inventory:
        """Return the whole file, and each part that shares faces or edges with others alone."""
        placed, message = self._select_faces(ALL)
        body, numbers, assembly = self._assemble(placed)
        owner = {face.number: part.number for part in self._parts for face in part.faces}
        joined = set(assembly.connected_owners([owner[number] for number in numbers]))
        joined |= {part.number for meeting in placed.meetings for part in self._parts_of(meeting)}
        apart = {number: self.body(Choice(parts=(number,))) for number in sorted(joined)}
        return Inventory(body, numbers, self._parts, apart, message)

    def _select_faces(self, choice: Choice) -> tuple[PlacedFaces, str]:
        """Return the selected faces, and a message about solids that meet, "" if none do.

        These solids are united, kept or refused (`FileError`) as `solids` says.
        """
        chosen = chosen_faces(self._parts, choice, str(self._path))
        placed = place_faces(self._pieces, chosen, self._accuracy, self._solids)
        texts = []
        for meeting in placed.meetings:
            titles = listed(part.title for part in self._parts_of(meeting))
            texts.append(f"{titles} {meeting.describe(self._scale)}")
        return placed, meeting_message(placed, texts, self._solids, str(self._path))

    def _parts_of(self, meeting: Meeting) -> list[PartLabel]:
        first_faces = np.cumsum([1, *(len(piece.faces) for piece in self._pieces)])
        numbers = set(first_faces[list(meeting.pieces)].tolist())
        return [part for part in self._parts if part.faces[0].number in numbers]

    def _assemble(self, placed: PlacedFaces) -> tuple[Body, list[int], Assembly]:
        """Return the faces as a body, the number in the file of each patch, and the assembly.

        Edges are those of the file if all of it is there and no solids meet, else sewn anew. A body
        of whole solids of which none meet is marked as such, so that it is not examined again.
        """
        is_whole = len(placed.faces) == sum(len(piece.faces) for piece in self._pieces)
        edges = self._edges if is_whole and not placed.meetings else SewnEdges(placed.shape)
        assembly = Assembly(str(self._path))
        numbers = gather(assembly, placed.faces, edges, self._scale, f"{self._path}, face")
        curve_of = partial(edge_of, edges, self._scale, self._accuracy)
        body = assembly.body(self._path.stem, curve_of, self._unit)
        if placed.is_sound and placed.solids_only:
            body = body.known_apart()
        return body, numbers, assembly


def gather(
    assembly: Assembly, faces: Sequence[Numbered], edges: SewnEdges, scale: float, where: str
) -> list[int]:
    """Add faces to `assembly`, reversed if `edges` says so; return the numbers of those with area.

    Warnings and errors are those of `add_face`; `where` and the number name a face in them.
    """
    from OCP.TopoDS import TopoDS

    numbers = []
    for number, face in faces:
        oriented = TopoDS.Face(face.Reversed()) if edges.is_reversed(face) else face
        if add_face(assembly, oriented, edges, scale, f"{where} {number}"):
            numbers.append(number)
    return numbers


def edge_of(edges: SewnEdges, scale: float, accuracy: float, number: int) -> Edge | None:
    """Return curve and tolerances of an edge by its number, times `scale`.

    The curve is built from a p-curve if there is none in space; None if that fails. The corner
    tolerance is that of its vertices, `accuracy` at least.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    edge = edges.edge(number)
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


def add_face(assembly: Assembly, face: Any, edges: SewnEdges, scale: float, where: str) -> bool:
    """Convert a TopoDS_Face and add it if it has an area; return whether it has.

    `edges` numbers its edges, `scale` is a factor on lengths.

    Raises
    ------
    FileError
        The face meets itself on its axis, or OpenCASCADE cannot approximate its surface.

    Warns
    -----
    ContigaWarning
        The face is left out, because it has no extent; a loop is open by more than `OPEN_TOL` of
        the face, which becomes the rectangle around its loops; its surface is approximated.
    """
    raw = _raw_face(face, edges)
    if raw is None or _is_thin(raw):
        warn(f"{where}: a face without extent was left out")
        return False
    refuse_self_intersection(raw.surface, raw.box, scale, where)
    sides = rectangle_sides(raw.loops[0], raw.box, raw.speed) if len(raw.loops) == 1 else None
    max_gap = 0.0
    for loop in raw.loops:
        for pcurve, gap in zip(loop, gaps(loop), strict=True):
            if gap.any():  # in space; at a pole there is none
                (u, v), (x, y) = ends(pcurve)[1], ends(pcurve)[1] + gap
                point = raw.surface.Value(float(u), float(v))
                distance = point.Distance(raw.surface.Value(float(x), float(y)))
                max_gap = max(max_gap, float(distance))
    size = float(np.linalg.norm((raw.box[1] - raw.box[0]) * raw.speed))
    is_open = max_gap > OPEN_TOL * size
    if is_open:
        warn(
            f"{where}: a trimming loop is open by {max_gap:.3g} mm; the face is kept as the "
            "rectangle around its loops"
        )
    is_trimmed = sides is None and not is_open
    try:
        patch = occ.patch_from(raw.surface, raw.box, is_trimmed, scale)
    except GeometryError as error:
        raise FileError(str(error), where=where, remedy=REMEDY) from error
    if patch.error > 0.0:
        warn(
            f"{where}: its surface has no NURBS form (an offset surface, for example) and is "
            f"approximated, to {patch.error:.2g}"
        )
    if is_trimmed:
        span = np.array([np.ptp(interval) for interval in patch.surface.domain])
        loops = [
            [pcurve._replace(curve=map_pcurve(pcurve.curve, patch.maps, span)) for pcurve in loop]
            for loop in raw.loops
        ]
        assembly.add_trimmed(patch.surface, loops, where, flip=raw.reversed)
    elif sides is None:
        assembly.add_whole(patch.surface, flip=raw.reversed)
    else:
        spans = []
        for side, interval in zip(sides.side, sides.span, strict=True):
            axis = 1 - side // 2
            low, high = np.clip(patch.maps[axis](np.array(interval)), *patch.surface.domain[axis])
            spans.append((float(low), float(high)))
        sides = sides._replace(span=spans)
        assembly.add_whole(patch.surface, raw.loops[0], sides, flip=raw.reversed)
    return True


def _is_thin(raw: RawFace) -> bool:
    """Return whether the box of a face is at most `THIN_TOL` as wide as long, in space."""
    extent = (raw.box[1] - raw.box[0]) * raw.speed
    return bool(extent.min() <= THIN_TOL * extent.max())


def _raw_face(face: Any, edges: SewnEdges) -> RawFace | None:
    """Return surface, ordered loops and bounds of a face, in the sense of its surface.

    Bounds are those of the loops, at most a period, or of the surface without loops; those beyond
    the surface, or within `BOUNDS_TOL` of its bounds, become equal to these. None if the face has
    no surface, or an infinite one without loops. Wires without p-curves are left out.
    """
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    surface = occ.base_surface(BRep_Tool.Surface_s(face))
    if surface is None:
        return None
    # Loops are those of the face with forward orientation; its own orientation is kept apart.
    forward = TopoDS.Face(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    periods = occ.periods_of(surface)
    loops = []
    for wire in members(forward):
        if wire.ShapeType() == TopAbs_ShapeEnum.TopAbs_WIRE:
            pcurves = _pcurves(TopoDS.Wire(wire), forward, edges)
            if pcurves:
                loops.append(chain_pcurves(pcurves, periods))
    loops = align_loops(loops, periods)
    u0, u1, v0, v1 = surface.Bounds()
    natural = np.array([[u0, v0], [u1, v1]])
    natural[np.abs(natural) > 1e99] = np.inf
    natural[0][np.isinf(natural[0])] = -np.inf
    box = natural
    if loops:
        box = exact_box([pcurve for loop in loops for pcurve in loop])
        is_periodic = periods > 0.0
        box[0] = np.where(is_periodic, box[0], np.maximum(box[0], natural[0]))
        box[1] = np.minimum(box[1], np.where(is_periodic, box[0] + periods, natural[1]))
        # Bounds within rounding of the natural ones become equal to them: a pole has no hole.
        near = BOUNDS_TOL * (box[1] - box[0])
        box[0] = np.where(~is_periodic & (box[0] - natural[0] <= near), natural[0], box[0])
        box[1] = np.where(~is_periodic & (natural[1] - box[1] <= near), natural[1], box[1])
    if not np.isfinite(box).all():
        return None
    is_reversed = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return RawFace(surface, loops, box, occ.speed_of(surface, box), is_reversed)


def _pcurves(wire: Any, face: Any, edges: SewnEdges) -> Loop:
    """Return the p-curves of a wire, each in the wire's direction.

    They are in order of connection, or as stored if the explorer cannot follow the wire. Missing
    ones are built by projection; edges without any, or without length, are left out. A p-curve at
    a pole has number -1.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.ShapeFix import ShapeFix_Edge
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopoDS import TopoDS

    connected = []
    explorer = BRepTools_WireExplorer(wire, face)
    while explorer.More():
        connected.append(explorer.Current())
        explorer.Next()
    borders = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)
    stored = [TopoDS.Edge(edge) for edge in members(wire) if edge.Orientation() in borders]
    pcurves = []
    for edge in connected if len(connected) == len(stored) else stored:
        curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        if curve is None:
            ShapeFix_Edge().FixAddPCurve(edge, face, BRep_Tool.IsClosed_s(edge, face))
            curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
        if curve is None:
            continue
        first, last = BRep_Tool.Range_s(edge, face)
        if not first < last:
            continue
        image = occ.pcurve_from(curve, first, last)
        is_reversed = edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        number, against = (-1, False) if BRep_Tool.Degenerated_s(edge) else edges.number_of(edge)
        tolerance = float(BRep_Tool.Tolerance_s(edge))
        image = image.reversed() if is_reversed else image
        pcurves.append(PCurve(image, number, is_reversed != against, tolerance))
    return pcurves
