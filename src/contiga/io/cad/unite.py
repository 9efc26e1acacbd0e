"""Solids of a file that touch or overlap: united by OpenCASCADE, or reported.

The search needs a closed surface that does not meet itself. Where solids meet, walls inside another
solid and common walls bound nothing, and the union has none of them. Its faces are parts of the
file's faces, on the same surfaces.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from itertools import accumulate, chain
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import FileError
from contiga.io.cad.occ_parts import Piece, compound_of
from contiga.io.cad.occ_solids import volume_of
from contiga.io.cad.parts import Solids
from contiga.io.cad.sew import COINCIDENT, FINEST, box_of, subshapes
from contiga.records import FloatArray

N_SAMPLES = 64
"""Points of each solid whose side of the union is compared with that of the solids."""
MAX_SAMPLES = 256
"""Largest number of such points in all."""
VOLUME_TOL = 1e-6
"""Largest relative excess of the union's volume over the sum of the solids."""

UNKNOWN = ", of which OpenCASCADE does not find out whether they touch or overlap"

Numbered = tuple[int, Any]
"""Number of a face in the file, and TopoDS_Face."""


class Meeting(NamedTuple):
    """A group of solids that touch or overlap, or whose boxes do."""

    pieces: tuple[int, ...]
    """Their indices, ascending."""
    place: tuple[float, float, float]
    """A point where some of them, or their boxes, meet, mm."""
    gap: float = 0.0
    """Distance of two of them there, mm."""

    def describe(self, scale: float) -> str:
        """Return the place of the meeting in words, lengths times `scale`.

        A gap that the union closes is mentioned if it is more than rounding.
        """
        text = "at ({:.6g}, {:.6g}, {:.6g})".format(*(scale * c for c in self.place))
        return f"{text}, {scale * self.gap:.2g} apart" if self.gap > 0.5 * FINEST else text


class PlacedFaces(NamedTuple):
    """The faces of a future body, and the shape whose topology connects them."""

    shape: Any
    faces: list[Numbered]
    """Several for a face of the file that was cut up."""
    meetings: list[Meeting]
    is_certain: bool
    """Whether solids of `meetings` are known to meet, and not only their boxes."""
    is_sound: bool
    """Whether no two solids meet any more."""
    solids_only: bool
    """Whether all chosen faces belong to whole solids."""


def place_faces(
    pieces: Sequence[Piece], chosen: Container[int], accuracy: float, solids: Solids | None
) -> PlacedFaces:
    """Return the faces with the numbers `chosen`; whole solids that meet may be united.

    Faces of `pieces` are numbered from 1. With `solids` "union", or None, solids that are chosen
    whole and meet are united; if OpenCASCADE fails, or the union is not sound, they stay as they
    are. For "refuse" the result only says where solids meet; for "separate", which examines
    nothing, where boxes meet. Solids meet if they overlap or come nearer than `contact_distance`,
    which `accuracy`, mm, may raise; only solids whose boxes meet are examined.
    """
    firsts = [1, *accumulate((len(piece.faces) for piece in pieces), initial=1)][1:]
    rows = [
        [(n, face) for n, face in enumerate(piece.faces, first) if n in chosen]
        for first, piece in zip(firsts, pieces, strict=False)
    ]
    # Whole pieces keep their topology, from which sewing knows which faces are joined.
    shapes = [
        [piece.shape] if len(faces) == len(piece.faces) else [face for _, face in faces]
        for piece, faces in zip(pieces, rows, strict=True)
    ]
    whole_solids = [
        k
        for k, piece in enumerate(pieces)
        if piece.kind == "solid" and rows[k] and len(rows[k]) == len(piece.faces)
    ]
    solids_only = len(whole_solids) == sum(map(bool, rows))
    boxes = {k: box_of(pieces[k].shape) for k in whole_solids if len(whole_solids) > 1}
    max_gap = contact_distance(boxes, accuracy)
    groups = meeting_boxes(boxes, max_gap)
    meetings = [Meeting(tuple(sorted(group)), between(boxes, group)) for group in groups]
    is_certain = is_sound = not groups
    if groups and solids != "separate":
        members = sorted(k for group in groups for k in group)
        union = _Union([pieces[k] for k in members], np.array([boxes[k] for k in members]), max_gap)
        is_certain = union.done
        is_sound = is_certain and (not union.met or (solids != "refuse" and union.holds()))
        if union.met and is_sound:
            for j in union.met:
                shapes[members[j]] = []
                rows[members[j]] = union.faces(rows[members[j]])
            shapes.append(union.solids)
        if is_certain:
            meetings = [
                Meeting(tuple(members[j] for j in group), *union.place(group))
                for group in union.groups
            ]
    shape = compound_of(chain.from_iterable(shapes))
    faces = list(chain.from_iterable(rows))
    return PlacedFaces(shape, faces, meetings, is_certain, is_sound, solids_only)


def meeting_message(
    placed: PlacedFaces, texts: Sequence[str], solids: Solids | None, where: str
) -> str:
    """Return the message about solids that meet, "" if none do or a union was asked for and made.

    `texts` name the solids and places, one for each of `placed.meetings`.

    Raises
    ------
    FileError
        Solids that meet are to be refused, and some meet or may meet.
    """
    if not texts:
        return ""
    text = "; ".join(texts)
    if solids == "refuse":
        remedy = '"union" makes one of them'
        if not placed.is_certain:
            remedy = '"separate" keeps them as they are'
        raise FileError(
            "solids touch or overlap" if placed.is_certain else f"solids whose boxes meet{UNKNOWN}",
            where=where,
            found=text,
            allowed="solids that are apart",
            remedy=f"solids = {remedy}; parts chooses some",
        )
    if solids == "separate":
        return separate_message(texts)
    if placed.is_sound:  # "union" asked for that
        return "" if solids == "union" else f"that touch or overlap are made one: {text}"
    if not placed.is_certain:
        return f"whose boxes meet are kept as they are{UNKNOWN}: {text}. Choose some by parts"
    return (
        "that touch or overlap are kept as they are, because OpenCASCADE makes no sound union of "
        f"them: {text}. Choose some by parts"
    )


def separate_message(texts: Sequence[str]) -> str:
    """Return the message about solids whose boxes meet and that stay separate."""
    return f"whose boxes meet are kept as they are: {'; '.join(texts)}. Body.flaws says which touch"


class _Union:
    """The union of solids by OpenCASCADE, and the solids that it changes.

    It is made at once; `done` says whether OpenCASCADE could. `holds` checks it.

    Parameters
    ----------
    pieces : two or more solids
    boxes : (n, 2, 3) around them
    max_gap : largest distance of solids that touch, mm
    """

    def __init__(self, pieces: Sequence[Piece], boxes: FloatArray, max_gap: float) -> None:
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
        from OCP.collections import (
            IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
            List_TopoDS_Shape,
        )
        from OCP.TopoDS import TopoDS

        self._pieces = pieces
        self._boxes = boxes
        arguments, tools = List_TopoDS_Shape(), List_TopoDS_Shape()
        arguments.Append(pieces[0].shape)
        for piece in pieces[1:]:
            tools.Append(piece.shape)
        self._fuse = fuse = BRepAlgoAPI_Fuse()
        fuse.SetArguments(arguments)
        fuse.SetTools(tools)
        fuse.SetNonDestructive(True)
        fuse.SetFuzzyValue(max_gap)
        fuse.Build()
        self._numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._faces: dict[int, Any] = {}
        self.groups: list[list[int]] = []
        """Indices of pieces that are in one solid of the union, or together in none."""
        self.met: list[int] = []
        """Indices of all pieces in groups, ascending."""
        self.solids: list[Any] = []
        """Solids that the groups make."""
        self.done = bool(fuse.IsDone())
        if not self.done:
            return
        all_solids = subshapes(fuse.Shape(), "SOLID")
        owner: dict[int, int] = {}
        for j, solid in enumerate(all_solids):
            for face in subshapes(solid, "FACE"):
                number = int(self._numbers.Add(face))
                self._faces[number], owner[number] = TopoDS.Face(face), j
        # Pieces in one solid of the union have met.
        groups: dict[int, list[int]] = {}
        for k, piece in enumerate(pieces):
            images = [number for face in piece.faces for number in self._images(face)]
            if images:
                j = owner[images[0]]
            else:  # no face is left of a piece within another
                point = np.array([middle(subshapes(piece.shape, "EDGE")[0])])
                holders = (i for i, s in enumerate(all_solids) if inside([s], point)[0] != 0.0)
                j = next(holders, -1)
            groups.setdefault(j, []).append(k)
        groups = {j: group for j, group in groups.items() if len(group) > 1}
        self.groups = list(groups.values())
        self.met = sorted(k for group in self.groups for k in group)
        self.solids = [all_solids[j] for j in groups if j >= 0]

    def _images(self, face: Any) -> list[int]:
        """Return the numbers of the faces of the union that are parts of a face."""
        parts = list(self._fuse.Modified(face)) or [face]
        return [number for part in parts if (number := int(self._numbers.FindIndex(part)))]

    def faces(self, rows: Sequence[Numbered]) -> list[Numbered]:
        """Take out and return the faces of the union that are parts of `rows`, with their numbers.

        Numbers are those of `rows`. A face is given out once: a common one belongs to the solid
        that is asked for first.
        """
        return [
            (number, self._faces.pop(image))
            for number, face in rows
            for image in self._images(face)
            if image in self._faces
        ]

    def place(self, group: Sequence[int]) -> tuple[tuple[float, float, float], float]:
        """Return the middle of the first edge between faces of two solids, and their gap there, mm.

        The gap is the sum of the distances of the point from the two. If no edge is common, because
        one solid lies within another, it is the middle of the smallest box, and 0.
        """
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
        from OCP.BRepExtrema import BRepExtrema_DistShapeShape
        from OCP.gp import gp_Pnt

        owner: dict[int, int] = {}
        for k in group:
            for number in (n for face in self._pieces[k].faces for n in self._images(face)):
                for edge in subshapes(self._numbers.FindKey(number), "EDGE"):
                    other = owner.setdefault(int(self._numbers.Add(edge)), k)
                    if other != k:
                        point = middle(edge)
                        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex()
                        shapes = (self._pieces[n].shape for n in (k, other))
                        gaps = (BRepExtrema_DistShapeShape(vertex, s).Value() for s in shapes)
                        return point, float(sum(gaps))
        smallest = min(group, key=lambda k: float(np.ptp(self._boxes[k], axis=0).prod()))
        x, y, z = self._boxes[smallest].mean(axis=0).tolist()
        return (x, y, z), 0.0

    def holds(self) -> bool:
        """Return whether the union has a possible volume, and the right side at random points.

        The volume is at least that of the largest solid, at most the sum, to `VOLUME_TOL`. Every
        point within one of the solids must be within the union, every other one outside; points on
        a face do not count. Up to `MAX_SAMPLES` points in the boxes, the same in every call.
        """
        shapes = [self._pieces[k].shape for k in self.met]
        before, after = [volume_of(shape) for shape in shapes], [volume_of(s) for s in self.solids]
        if not max(before) * (1.0 - VOLUME_TOL) <= sum(after) <= sum(before) * (1.0 + VOLUME_TOL):
            return False
        count = min(N_SAMPLES, -(-MAX_SAMPLES // len(self.met)))
        shares = np.random.default_rng(0).random((len(self.met), count, 3))
        boxes = self._boxes[self.met]
        points = boxes[:, :1] + shares * np.ptp(boxes, axis=1)[:, None]
        rows = points.reshape(-1, 3)
        side_before, side_after = (inside(group, rows) for group in (shapes, self.solids))
        is_clear = ~np.isnan(side_before) & ~np.isnan(side_after)
        return bool((side_before[is_clear] == side_after[is_clear]).all())


def _diagonal(boxes: Mapping[int, FloatArray]) -> float:
    """Return the diagonal of the box around boxes; 0 without boxes."""
    corners = np.array(list(boxes.values())).reshape(-1, 3)
    return float(np.linalg.norm(np.ptp(corners, axis=0))) if len(corners) else 0.0


def contact_distance(boxes: Mapping[int, FloatArray], accuracy: float) -> float:
    """Return the distance up to which solids in these boxes touch, mm.

    It is the largest of `FINEST`, the accuracy of the file, at most 1e-6 of the whole size, and
    1e-6 of the size of the smallest solid: placements have so many decimals, and no clearance is so
    narrow.
    """
    smallest = min((_diagonal({0: box}) for box in boxes.values()), default=0.0)
    return max(FINEST, min(accuracy, COINCIDENT * _diagonal(boxes)), COINCIDENT * smallest)


def meeting_boxes(boxes: Mapping[int, FloatArray], max_gap: float) -> list[list[int]]:
    """Return the keys of each connected group of two or more boxes that meet.

    Boxes meet if they are apart by at most `max_gap` along each axis. A group begins with its
    first key; each later box meets one before it.
    """
    keys, rows = list(boxes), np.array(list(boxes.values())).reshape(-1, 2, 3)
    remaining, groups = set(range(len(keys))), []
    while remaining:
        group = [min(remaining)]
        remaining -= set(group)
        for k in group:
            low, high = rows[k, 0] - max_gap, rows[k, 1] + max_gap
            meets = ((rows[:, 0] <= high) & (rows[:, 1] >= low)).all(axis=1)
            neighbours = remaining.intersection(np.flatnonzero(meets).tolist())
            remaining -= neighbours
            group += sorted(neighbours)
        if len(group) > 1:
            groups.append([keys[k] for k in group])
    return groups


def between(boxes: Mapping[int, FloatArray], group: Sequence[int]) -> tuple[float, float, float]:
    """Return the middle of the intersection of the first two boxes of a group, or of their gap."""
    (low, high), (other_low, other_high) = boxes[group[0]], boxes[group[1]]
    x, y, z = (0.5 * (np.maximum(low, other_low) + np.minimum(high, other_high))).tolist()
    return x, y, z


def middle(edge: Any) -> tuple[float, float, float]:
    """Return the point of an edge at the middle of its parameters."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.TopoDS import TopoDS

    curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
    point = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
    return point.X(), point.Y(), point.Z()


def inside(shapes: Sequence[Any], points: FloatArray) -> FloatArray:
    """Return 1 (n,) for points within one of the solids, 0 outside all, NaN on a face of one.

    On a face means within `FINEST`; a point that is on a face and within another solid is 1.
    """
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_State

    sides = np.zeros(len(points))
    for shape in shapes:
        low, high = box_of(shape)
        classifier = BRepClass3d_SolidClassifier(shape)
        is_within_box = ((low <= points) & (points <= high)).all(axis=1)
        for k in np.flatnonzero(is_within_box & (sides != 1.0)):
            classifier.Perform(gp_Pnt(*points[k].tolist()), FINEST)
            state = classifier.State()
            if state == TopAbs_State.TopAbs_IN:
                sides[k] = 1.0
            elif state == TopAbs_State.TopAbs_ON:
                sides[k] = np.nan
    return sides
