"""Faces that a file gives one by one: their common edges and their orientation.

IGES has no topology, and STEP files may hold loose faces. OpenCASCADE's sewing finds the edges
that coincide; surfaces and p-curves stay as the file has them, only edges are given one number.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from contiga.arrays.groups import groups_of
from contiga.geometry.joints import Joint, turned_faces
from contiga.records import FloatArray

COINCIDENT = 1e-6
"""Edges farther apart than this share of the whole size stay separate."""
CUT_OFF = 1e-3
"""Largest shares of an edge cut off its ends that still leave the same edge."""
TANGENT = 0.05
"""Edges that coincide over less than this share of the shorter one touch, but are not the same."""
FINEST = 1e-7
"""OpenCASCADE's own confusion distance, mm."""


class Sewn:
    """Numbering of the edges of a shape, with coinciding edges alike, and faces to be reversed.

    Parameters
    ----------
    shape : TopoDS_Shape, left as it is
    """

    def __init__(self, shape: Any) -> None:
        from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher

        self._known = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._leader: dict[int, tuple[int, bool]] = {}
        self._turned: set[int] = set()
        self._by_chance: set[int] = set()
        if self._has_loose_edges(shape):
            sewing = _sewing(shape)
            self._lead(shape, sewing)
            self._turn(shape, sewing)

    def add(self, edge: Any) -> tuple[int, bool]:
        """Return the number of a TopoDS_Edge, and whether it runs against that number's edge."""
        number = self._number(edge)
        return self._leader.get(number, (number, False))

    def edge(self, number: int) -> Any:
        """Return the TopoDS_Edge of a number."""
        from OCP.TopoDS import TopoDS

        return TopoDS.Edge(self._known.FindKey(number))

    def turned(self, face: Any) -> bool:
        """Return whether a face must swap its sides to agree with those it is joined to."""
        return self._number(face) in self._turned

    def _number(self, shape: Any) -> int:
        """Return a number that is equal for a shape and its reverse in the same place."""
        return int(self._known.Add(shape))

    def _has_loose_edges(self, shape: Any) -> bool:
        """Return whether several faces have edges of their own that may be given twice."""
        from OCP.BRep import BRep_Tool
        from OCP.TopoDS import TopoDS

        # Numbers of faces follow the file's order.
        if len({self._number(face) for face in subshapes(shape, "FACE")}) < 2:
            return False
        edges = [TopoDS.Edge(edge) for edge in subshapes(shape, "EDGE")]
        uses = Counter(self._number(e) for e in edges if not BRep_Tool.Degenerated_s(e))
        return 1 in uses.values()

    def _lead(self, shape: Any, sewing: Any) -> None:
        """Find, for each joined edge, the edge that represents it.

        An edge that meets several edges one after the other is cut by the sewing; here it stays
        whole and shares its number with all of them. Whichever of them the file has first, the
        one that runs along all the others stands for them; where none does (two halves of a
        circle on three thirds), what they make together.
        """
        from OCP.TopAbs import TopAbs_Orientation

        forward = TopAbs_Orientation.TopAbs_FORWARD
        pieces: dict[int, dict[int, Any]] = {}
        holders: dict[int, list[tuple[int, bool]]] = defaultdict(list)
        for edge in subshapes(shape, "EDGE"):
            edge_number = self._number(edge)
            if edge_number not in pieces:
                pieces[edge_number] = {}
                for part in subshapes(sewing.ModifiedSubShape(edge.Oriented(forward)), "EDGE"):
                    number = self._number(part)
                    pieces[edge_number][number] = part
                    holders[number].append((edge_number, part.Orientation() != forward))
        self._leader = {edge_number: (edge_number, False) for edge_number in pieces}
        extent = {edge_number: _length(self.edge(edge_number)) for edge_number in pieces}
        for number, ((first, first_against), *others) in holders.items():
            shortest = min(extent[first], *(extent[other] for other, _ in others), np.inf)
            if others and _length(self.edge(number)) < TANGENT * shortest:
                self._by_chance.add(number)
                continue
            root, turned = self._root(first)
            for edge_number, against in others:
                end, flipped = self._root(edge_number)
                if end != root:
                    self._leader[end] = root, (turned != first_against) != (flipped != against)
        self._leader = {edge: self._root(edge) for edge in self._leader}
        groups: dict[int, list[int]] = defaultdict(list)
        for edge_number, (root, _) in self._leader.items():
            groups[root].append(edge_number)
        for group in groups.values():
            if len(group) > 1:
                self._crown(group, pieces)

    def _crown(self, group: list[int], pieces: dict[int, dict[int, Any]]) -> None:
        """Make one edge that runs along a group of joined edges represent them."""
        every = {number: part for one in group for number, part in pieces[one].items()}
        length = {number: _length(part) for number, part in every.items()}
        along = {one: sum(length[number] for number in pieces[one]) for one in group}
        root = self._leader[group[0]][0]
        longest = max(group, key=lambda one: along[one])
        leader = root if along[root] >= (1.0 - CUT_OFF) * along[longest] else longest
        against = self._leader[leader][1]
        if along[leader] < (1.0 - CUT_OFF) * sum(length.values()):
            whole = _whole(list(every.values()))
            if whole is not None:
                against ^= not _same_way(self.edge(leader), whole)
                leader = self._number(whole)
                self._leader[leader] = leader, False
        for one in group:
            self._leader[one] = leader, self._leader[one][1] != against

    def _root(self, edge: int) -> tuple[int, bool]:
        """Return the representative of an edge, and whether the edge runs against it."""
        against = False
        while self._leader[edge][0] != edge:
            edge, turned = self._leader[edge]
            against ^= turned
        return edge, against

    def _turn(self, shape: Any, sewing: Any) -> None:
        """Find the faces that must swap their sides to agree with those they are joined to.

        Faces are joined over edges that two of them share. What hangs together and is closed
        faces outward; what is open, or lies within something closed, as its first face does in
        the file: it may bound a cavity. Edges in one place, as where two boxes touch along a
        line, join nothing: which faces sewing has paired there is chance.
        """
        from OCP.BRep import BRep_Tool
        from OCP.TopAbs import TopAbs_Orientation
        from OCP.TopoDS import TopoDS

        faces = list(dict.fromkeys(subshapes(shape, "FACE")))
        sewn = [sewing.ModifiedSubShape(face) for face in faces]
        uses: dict[int, list[tuple[int, bool]]] = defaultdict(list)
        for k, face in enumerate(sewn):
            for edge in map(TopoDS.Edge, subshapes(face, "EDGE")):
                if not BRep_Tool.Degenerated_s(edge):
                    forward = edge.Orientation() == TopAbs_Orientation.TopAbs_FORWARD
                    uses[self._number(edge)].append((k, forward))
        chance = self._by_chance | self._in_one_place(list(uses))
        joints = []
        for number, ends in uses.items():
            if len(ends) == 2 and number not in chance:
                (a, one), (b, other) = ends
                joints.append(Joint(a, b, one != other))
        odd = set(turned_faces(len(sewn), joints)[0])
        pairs = np.array([joint[:2] for joint in joints], np.int64).reshape(-1, 2)
        group = groups_of(pairs[:, 0], pairs[:, 1], len(sewn))
        ends_at = {ends[0][0] for ends in uses.values() if len(ends) == 1}
        pieces = [
            np.flatnonzero(group == k).tolist() for k in range(int(group.max(initial=-1)) + 1)
        ]
        closed = [piece for piece in pieces if ends_at.isdisjoint(piece)]
        solids = [
            _solid([sewn[k].Reversed() if k in odd else sewn[k] for k in piece]) for piece in closed
        ]
        turned = dict.fromkeys((piece[0] for piece in pieces), False)
        for piece, solid in zip(closed, solids, strict=True):
            if not any(_holds(other, solid) for other in solids if other is not solid):
                front = sewn[piece[0]]
                turned[piece[0]] = subshapes(solid, "FACE")[0].Orientation() != front.Orientation()
        self._turned |= {
            self._number(faces[k])
            for piece in pieces
            for k in piece
            if turned[piece[0]] != ((k in odd) != (piece[0] in odd))
        }

    def _in_one_place(self, numbers: list[int]) -> set[int]:
        """Find the edges that coincide with another of them between the same corners."""
        from OCP.BRep import BRep_Tool
        from OCP.BRepAdaptor import BRepAdaptor_Curve

        between: dict[frozenset[int], list[int]] = defaultdict(list)
        for number in numbers:
            ends = frozenset(map(self._number, subshapes(self.edge(number), "VERTEX")))
            between[ends].append(number)
        coincide: set[int] = set()
        for some in between.values():
            curves = {number: BRepAdaptor_Curve(self.edge(number)) for number in some}
            middles = {
                number: curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
                for number, curve in curves.items()
                if len(some) > 1
            }
            for one, other in combinations(middles, 2):
                near = sum(BRep_Tool.Tolerance_s(self.edge(number)) for number in (one, other))
                if middles[one].Distance(middles[other]) <= near:
                    coincide |= {one, other}
        return coincide


def _solid(faces: list[Any]) -> Any:
    """Build the solid that a closed surface bounds; `faces` agree, and face outward in it."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS_Shell

    shell, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    solid = BRepBuilderAPI_MakeSolid(shell).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _holds(solid: Any, other: Any) -> bool:
    """Return whether a solid holds another, by their boxes and by a corner of the other."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.TopAbs import TopAbs_State
    from OCP.TopoDS import TopoDS

    (low, high), (other_low, other_high) = box_of(solid), box_of(other)
    if not ((low <= other_low) & (other_high <= high)).all():
        return False
    corner = BRep_Tool.Pnt_s(TopoDS.Vertex(subshapes(other, "VERTEX")[0]))
    classifier = BRepClass3d_SolidClassifier(solid, corner, FINEST)
    return bool(classifier.State() == TopAbs_State.TopAbs_IN)


def box_of(shape: Any) -> FloatArray:
    """Return the corners (2, 3) of the box around a shape."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    low, high = box.CornerMin(), box.CornerMax()
    return np.array([[p.X(), p.Y(), p.Z()] for p in (low, high)])


def _length(edge: Any) -> float:
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_AbscissaPoint
    from OCP.TopoDS import TopoDS

    return float(GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(TopoDS.Edge(edge))))


def _whole(parts: list[Any]) -> Any | None:
    """Return one edge along edges that meet end to end; None if they do not."""
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.Geom import Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert_CompCurveToBSplineCurve
    from OCP.TopoDS import TopoDS

    edges = [TopoDS.Edge(part) for part in parts]
    near = max(BRep_Tool.Tolerance_s(edge) for edge in edges)
    chain = GeomConvert_CompCurveToBSplineCurve()
    rest = edges
    while rest:
        # A piece that does not meet the chain yet may do so later.
        left = []
        for edge in rest:
            curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
            trimmed = Geom_TrimmedCurve(curve, *BRep_Tool.Range_s(edge))
            if not chain.Add(trimmed, 2.0 * near):
                left.append(edge)
        if len(left) == len(rest):
            return None
        rest = left
    whole = BRepBuilderAPI_MakeEdge(chain.BSplineCurve()).Edge()
    BRep_Builder().UpdateEdge(whole, near)
    return whole


def _same_way(edge: Any, whole: Any) -> bool:
    """Return whether an edge runs in the direction of another edge that it lies on."""
    from OCP.BRep import BRep_Tool
    from OCP.GeomAPI import GeomAPI_ProjectPointOnCurve
    from OCP.gp import gp_Pnt, gp_Vec

    first, last = BRep_Tool.Range_s(edge)
    point, way = gp_Pnt(), gp_Vec()
    BRep_Tool.Curve_s(edge, 0.0, 0.0).D1(0.5 * (first + last), point, way)
    curve = BRep_Tool.Curve_s(whole, 0.0, 0.0)
    at = GeomAPI_ProjectPointOnCurve(point, curve).LowerDistanceParameter()
    other = gp_Vec()
    curve.D1(at, point, other)
    return bool(way.Dot(other) > 0.0)


def subshapes(shape: Any, kind: str) -> list[Any]:
    """Return the subshapes of a kind ("SOLID", "SHELL", "FACE", "EDGE"), in order."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"))
    shapes = []
    while explorer.More():
        shapes.append(explorer.Current())
        explorer.Next()
    return shapes


def members(shape: Any) -> Iterator[Any]:
    """Yield the direct members of a shape, in order: edges of a wire, wires of a face."""
    from OCP.TopoDS import TopoDS_Iterator

    iterator = TopoDS_Iterator(shape)
    while iterator.More():
        yield iterator.Value()
        iterator.Next()


def _sewing(shape: Any) -> Any:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    size = 0.0 if box.IsVoid() else box.CornerMin().Distance(box.CornerMax())
    sewing = BRepBuilderAPI_Sewing(max(FINEST, COINCIDENT * size))
    sewing.Add(shape)
    sewing.Perform()
    return sewing
