"""Faces that a file gives one by one: their common edges and their orientation.

IGES has no topology, and STEP files may have loose faces. OpenCASCADE's sewing finds the edges that
coincide; surfaces and p-curves stay as the file has them, only edges get a common number.
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
CUT_TOL = 1e-3
"""Largest share of an edge cut off its ends that still leaves the same edge."""
MIN_OVERLAP = 0.05
"""Edges that coincide over less than this share of the shorter one touch, but are not the same."""
FINEST = 1e-7
"""OpenCASCADE's own confusion distance, mm."""


class SewnEdges:
    """Numbers of the edges of a shape, coinciding edges alike, and faces to be reversed.

    Edges of one face alone coincide if they are apart by at most `COINCIDENT` of the whole size,
    `FINEST` at least.

    Parameters
    ----------
    shape : TopoDS_Shape, left as it is
    """

    def __init__(self, shape: Any) -> None:
        from OCP.Bnd import Bnd_Box
        from OCP.BRep import BRep_Tool
        from OCP.BRepBndLib import BRepBndLib
        from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
        from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
        from OCP.TopoDS import TopoDS

        self._numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._leaders: dict[int, tuple[int, bool]] = {}
        """Edge that represents each joined edge, and whether the edge runs against it."""
        self._reversed_faces: set[int] = set()
        self._touching: set[int] = set()
        """Edges whose sewing is accidental: they coincide over a small part only."""
        # Numbers of faces follow the file's order.
        if len({self._number(face) for face in subshapes(shape, "FACE")}) < 2:
            return
        edges = [TopoDS.Edge(edge) for edge in subshapes(shape, "EDGE")]
        uses = Counter(self._number(e) for e in edges if not BRep_Tool.Degenerated_s(e))
        # Only an edge of one face alone may coincide with another edge.
        if 1 in uses.values():
            box = Bnd_Box()
            BRepBndLib.Add_s(shape, box)
            size = 0.0 if box.IsVoid() else box.CornerMin().Distance(box.CornerMax())
            sewing = BRepBuilderAPI_Sewing(max(FINEST, COINCIDENT * size))
            sewing.Add(shape)
            sewing.Perform()
            self._join_edges(shape, sewing)
            self._orient_faces(shape, sewing)

    def number_of(self, edge: Any) -> tuple[int, bool]:
        """Return the number of a TopoDS_Edge, and whether it runs against that number's edge.

        An edge that is not in the shape gets a new number.
        """
        number = self._number(edge)
        return self._leaders.get(number, (number, False))

    def edge(self, number: int) -> Any:
        """Return the TopoDS_Edge of a number."""
        from OCP.TopoDS import TopoDS

        return TopoDS.Edge(self._numbers.FindKey(number))

    def is_reversed(self, face: Any) -> bool:
        """Return whether a face must swap its sides to agree with its neighbours."""
        return self._number(face) in self._reversed_faces

    def _number(self, shape: Any) -> int:
        """Return the number of a shape, new if need be; its reverse in the same place shares it."""
        return int(self._numbers.Add(shape))

    def _join_edges(self, shape: Any, sewing: Any) -> None:
        """Fill `_leaders`: the edge that represents each edge, and whether it runs against that.

        An edge that meets several edges one after the other is cut by the sewing; here it stays
        whole and shares its number with all of them, and edges joined to it. Pieces shorter than
        `MIN_OVERLAP` of the shortest of their edges join nothing; they are noted in `_touching`.
        """
        from OCP.TopAbs import TopAbs_Orientation

        forward = TopAbs_Orientation.TopAbs_FORWARD
        pieces: dict[int, dict[int, Any]] = {}
        owners: dict[int, list[tuple[int, bool]]] = defaultdict(list)
        """Edges that each piece is a part of, and whether it runs against them."""
        for edge in subshapes(shape, "EDGE"):
            edge_number = self._number(edge)
            if edge_number not in pieces:
                pieces[edge_number] = {}
                for part in subshapes(sewing.ModifiedSubShape(edge.Oriented(forward)), "EDGE"):
                    number = self._number(part)
                    pieces[edge_number][number] = part
                    owners[number].append((edge_number, part.Orientation() != forward))
        self._leaders = {edge_number: (edge_number, False) for edge_number in pieces}
        lengths = {edge_number: _length(self.edge(edge_number)) for edge_number in pieces}
        for number, ((first, first_against), *further) in owners.items():
            shortest = min(lengths[first], *(lengths[edge] for edge, _ in further), np.inf)
            if further and _length(self.edge(number)) < MIN_OVERLAP * shortest:
                self._touching.add(number)
                continue
            root, root_against = self._root(first)
            for edge_number, against in further:
                other_root, other_against = self._root(edge_number)
                if other_root != root:
                    is_against = (root_against != first_against) != (other_against != against)
                    self._leaders[other_root] = root, is_against
        self._leaders = {edge: self._root(edge) for edge in self._leaders}
        groups: dict[int, list[int]] = defaultdict(list)
        for edge_number, (root, _) in self._leaders.items():
            groups[root].append(edge_number)
        for group in groups.values():
            if len(group) > 1:
                self._choose_leader(group, pieces)

    def _choose_leader(self, group: list[int], pieces: dict[int, dict[int, Any]]) -> None:
        """Write into `_leaders` one edge that represents a group of joined edges.

        It is the current one if no other is longer by more than `CUT_TOL`, else the longest one; if
        that does not run along all the others (two halves of a circle on three thirds), it is the
        edge that their pieces make end to end, if they make one.
        """
        parts = {number: part for edge in group for number, part in pieces[edge].items()}
        part_lengths = {number: _length(part) for number, part in parts.items()}
        lengths = {edge: sum(part_lengths[number] for number in pieces[edge]) for edge in group}
        root = self._leaders[group[0]][0]
        longest = max(group, key=lambda edge: lengths[edge])
        leader = root if lengths[root] >= (1.0 - CUT_TOL) * lengths[longest] else longest
        against = self._leaders[leader][1]
        if lengths[leader] < (1.0 - CUT_TOL) * sum(part_lengths.values()):
            chain = _chain_edges(list(parts.values()))
            if chain is not None:
                against ^= not _is_same_direction(self.edge(leader), chain)
                leader = self._number(chain)
                self._leaders[leader] = leader, False
        for edge in group:
            self._leaders[edge] = leader, self._leaders[edge][1] != against

    def _root(self, edge: int) -> tuple[int, bool]:
        """Return the representative of an edge, and whether the edge runs against it."""
        against = False
        while self._leaders[edge][0] != edge:
            edge, is_reversed = self._leaders[edge]
            against ^= is_reversed
        return edge, against

    def _orient_faces(self, shape: Any, sewing: Any) -> None:
        """Add to `_reversed_faces` the faces that must swap their sides to agree with neighbours.

        Faces are joined over edges that two of them share. A connected piece that is closed faces
        outward. A piece that is open, or lies within a closed one, keeps the orientation of its
        first face in the file: it may bound a cavity. Coincident edges, as where two boxes touch
        along a line, join nothing: the sewing pairs their faces arbitrarily.
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
        ambiguous = self._touching | self._coincident_edges(list(uses))
        joints = []
        for number, sides in uses.items():
            if len(sides) == 2 and number not in ambiguous:
                (a, a_forward), (b, b_forward) = sides
                joints.append(Joint(a, b, a_forward != b_forward))
        odd = set(turned_faces(len(sewn), joints)[0])
        pairs = np.array([joint[:2] for joint in joints], np.int64).reshape(-1, 2)
        group = groups_of(pairs[:, 0], pairs[:, 1], len(sewn))
        border_faces = {sides[0][0] for sides in uses.values() if len(sides) == 1}
        pieces = [
            np.flatnonzero(group == k).tolist() for k in range(int(group.max(initial=-1)) + 1)
        ]
        closed = [piece for piece in pieces if border_faces.isdisjoint(piece)]
        solids = [
            _make_solid([sewn[k].Reversed() if k in odd else sewn[k] for k in piece])
            for piece in closed
        ]
        is_flipped = dict.fromkeys((piece[0] for piece in pieces), False)
        for piece, solid in zip(closed, solids, strict=True):
            if not any(_contains(other, solid) for other in solids if other is not solid):
                outward = subshapes(solid, "FACE")[0].Orientation()
                is_flipped[piece[0]] = outward != sewn[piece[0]].Orientation()
        self._reversed_faces |= {
            self._number(faces[k])
            for piece in pieces
            for k in piece
            if is_flipped[piece[0]] != ((k in odd) != (piece[0] in odd))
        }

    def _coincident_edges(self, numbers: list[int]) -> set[int]:
        """Return the numbers of edges that coincide with another of them between the same corners.

        They do if their middles are no farther apart than the sum of their tolerances.
        """
        from OCP.BRep import BRep_Tool
        from OCP.BRepAdaptor import BRepAdaptor_Curve

        by_corners: dict[frozenset[int], list[int]] = defaultdict(list)
        for number in numbers:
            corners = frozenset(map(self._number, subshapes(self.edge(number), "VERTEX")))
            by_corners[corners].append(number)
        coincident: set[int] = set()
        for group in by_corners.values():
            curves = {number: BRepAdaptor_Curve(self.edge(number)) for number in group}
            middles = {
                number: curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
                for number, curve in curves.items()
                if len(group) > 1
            }
            for a, b in combinations(middles, 2):
                near = sum(BRep_Tool.Tolerance_s(self.edge(number)) for number in (a, b))
                if middles[a].Distance(middles[b]) <= near:
                    coincident |= {a, b}
        return coincident


def _make_solid(faces: list[Any]) -> Any:
    """Return the solid that a closed surface bounds, with its faces outward.

    `faces` must agree in their sides; if they face inward, all are reversed in the solid.
    """
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


def _contains(solid: Any, other: Any) -> bool:
    """Return whether the box of a solid contains that of another one, and the solid a corner of it.

    One corner of the other is tried, its first vertex; one on a face of the solid is not within.
    """
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
    """Return the corners, low and high (2, 3), of OpenCASCADE's box around a shape.

    The box contains the shape with its tolerances; it may be larger.
    """
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


def _chain_edges(parts: list[Any]) -> Any | None:
    """Return one edge along edges that meet end to end, in any order; None if they do not.

    Ends may be apart by twice the largest tolerance of the edges.
    """
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.Geom import Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert_CompCurveToBSplineCurve
    from OCP.TopoDS import TopoDS

    remaining = [TopoDS.Edge(part) for part in parts]
    near = max(BRep_Tool.Tolerance_s(edge) for edge in remaining)
    chain = GeomConvert_CompCurveToBSplineCurve()
    while remaining:
        # An edge that does not meet the chain yet may do so later.
        apart = []
        for edge in remaining:
            curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
            trimmed = Geom_TrimmedCurve(curve, *BRep_Tool.Range_s(edge))
            if not chain.Add(trimmed, 2.0 * near):
                apart.append(edge)
        if len(apart) == len(remaining):
            return None
        remaining = apart
    joined = BRepBuilderAPI_MakeEdge(chain.BSplineCurve()).Edge()
    BRep_Builder().UpdateEdge(joined, near)
    return joined


def _is_same_direction(edge: Any, chain: Any) -> bool:
    """Return whether the curve of an edge runs in the direction of that of `chain`, at its middle.

    The edge must lie on the chain; orientations of the two do not count.
    """
    from OCP.BRep import BRep_Tool
    from OCP.GeomAPI import GeomAPI_ProjectPointOnCurve
    from OCP.gp import gp_Pnt, gp_Vec

    first, last = BRep_Tool.Range_s(edge)
    point, tangent, chain_tangent = gp_Pnt(), gp_Vec(), gp_Vec()
    BRep_Tool.Curve_s(edge, 0.0, 0.0).D1(0.5 * (first + last), point, tangent)
    curve = BRep_Tool.Curve_s(chain, 0.0, 0.0)
    t = GeomAPI_ProjectPointOnCurve(point, curve).LowerDistanceParameter()
    curve.D1(t, point, chain_tangent)
    return bool(tangent.Dot(chain_tangent) > 0.0)


def subshapes(shape: Any, kind: str) -> list[Any]:
    """Return the subshapes of a kind ("SOLID", "SHELL", "FACE", "EDGE", "VERTEX"), in order.

    One that is shared, such as an edge of two faces, is there for each use.
    """
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
