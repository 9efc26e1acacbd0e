"""Solids of a file that touch or overlap: united by OpenCASCADE, or reported.

The search takes a closed surface that does not meet itself. Where solids meet, the walls that lie
in another of them, and those they have in common, bound nothing: the union has none of them. Its
faces are parts of the file's faces, on the same surfaces.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import FileError
from contiga.io.cad.occ_parts import Piece, compound_of
from contiga.io.cad.occ_solids import volume_of
from contiga.io.cad.parts import Solids
from contiga.io.cad.sew import COINCIDENT, FINEST, box_of, subshapes
from contiga.records import FloatArray

SAMPLES = 64
"""Points of each solid whose side of the union is compared with that of the solids."""
MAX_SAMPLES = 256
"""Largest number of such points in all."""
FULL = 1e-6
"""Largest relative excess of the union's volume over the sum of the solids."""

UNKNOWN = ", of which OpenCASCADE does not find out whether they touch or overlap"
MADE_ONE, KEPT = '"union" makes one of them', '"separate" keeps them as they are'

Numbered = tuple[int, Any]


class Meeting(NamedTuple):
    """A group of solids that touch or overlap, or whose boxes do."""

    pieces: tuple[int, ...]
    """Their indices, ascending."""
    place: tuple[float, float, float]
    """A point where some of them, or their boxes, meet, mm."""
    gap: float = 0.0
    """Distance of two of them there, mm."""

    def at(self, scale: float) -> str:
        """Return the place of the meeting in words, lengths times `scale`.

        A gap that is closed there is named if it is more than rounding.
        """
        text = "at ({:.6g}, {:.6g}, {:.6g})".format(*(scale * c for c in self.place))
        return f"{text}, {scale * self.gap:.2g} apart" if self.gap > 0.5 * FINEST else text


class Placed(NamedTuple):
    """The faces of a future body, and the shape whose topology connects them."""

    shape: Any
    faces: list[Numbered]
    """Numbers in the file, from 1, and TopoDS_Face; several for a face that was cut up."""
    meetings: list[Meeting]
    known: bool
    """Whether solids of `meetings` are known to meet, and not only their boxes."""
    embedded: bool
    """Whether no two solids meet any more."""
    solids_only: bool
    """Whether there are whole solids alone."""


def placed_of(
    pieces: Sequence[Piece], chosen: Container[int], accuracy: float, solids: Solids | None
) -> Placed:
    """Return the faces with the numbers `chosen`.

    With `solids` "union", or None, solids that are chosen whole and meet are united.

    Solids meet where they overlap or come nearer than `accuracy`, mm, which those can whose boxes
    do. For "refuse" it is only told where they meet; for "separate", where that is not looked
    into, where their boxes do. A union that OpenCASCADE does not manage leaves them as they are.
    """
    first = [1, *accumulate((len(piece.faces) for piece in pieces), initial=1)][1:]
    rows = [
        [(n, face) for n, face in enumerate(piece.faces, start) if n in chosen]
        for start, piece in zip(first, pieces, strict=False)
    ]
    # Whole pieces keep their topology, from which sewing knows what is joined.
    shapes = [
        [piece.shape] if len(mine) == len(piece.faces) else [face for _, face in mine]
        for piece, mine in zip(pieces, rows, strict=True)
    ]
    whole = [
        k
        for k, piece in enumerate(pieces)
        if piece.kind == "solid" and rows[k] and len(rows[k]) == len(piece.faces)
    ]
    only = len(whole) == sum(map(bool, rows))
    boxes = {k: box_of(pieces[k].shape) for k in whole if len(whole) > 1}
    within = closed_within(boxes, accuracy)
    groups = groups_near(boxes, within)
    meetings = [Meeting(tuple(sorted(some)), between(boxes, some)) for some in groups]
    known = embedded = not groups
    if groups and solids != "separate":
        near = sorted(k for some in groups for k in some)
        union = _Union([pieces[k] for k in near], np.array([boxes[k] for k in near]), within)
        known = union.done
        embedded = known and (not union.met or (solids != "refuse" and union.holds()))
        if union.met and embedded:
            for j in union.met:
                shapes[near[j]] = []
                rows[near[j]] = union.faces(rows[near[j]])
            shapes.append(union.solids)
        if known:
            meetings = [Meeting(tuple(near[j] for j in g), *union.place(g)) for g in union.groups]
    return Placed(compound_of(_flat(shapes)), list(_flat(rows)), meetings, known, embedded, only)


def said_of(placed: Placed, texts: Sequence[str], solids: Solids | None, where: str) -> str:
    """Return the message about solids that meet, "" if none do.

    `texts` name the solids and places.

    Raises
    ------
    FileError
        They are to be refused, and there are some, or it cannot be known.
    """
    text = "; ".join(texts)
    if not texts:
        return ""
    if solids == "refuse":
        raise FileError(
            "solids touch or overlap" if placed.known else f"solids whose boxes meet{UNKNOWN}",
            where=where,
            found=text,
            allowed="solids that are apart",
            remedy=f"solids = {MADE_ONE if placed.known else KEPT}; parts chooses some",
        )
    if solids == "separate":
        return kept_apart(texts)
    if placed.embedded:  # "union" asked for that
        return "" if solids == "union" else f"that touch or overlap are made one: {text}"
    if not placed.known:
        return f"whose boxes meet are kept as they are{UNKNOWN}: {text}. Choose some by parts"
    return (
        "that touch or overlap are kept as they are, because OpenCASCADE makes no sound union of "
        f"them: {text}. Choose some by parts"
    )


def kept_apart(texts: Sequence[str]) -> str:
    """Return the message about solids whose boxes meet and that stay separate."""
    return f"whose boxes meet are kept as they are: {'; '.join(texts)}. Body.flaws says which touch"


def _flat(lists: Sequence[Sequence[Any]]) -> Iterator[Any]:
    return (each for some in lists for each in some)


class _Union:
    """The union of solids, and the solids that it changes.

    Parameters
    ----------
    pieces : two or more solids
    boxes : (n, 2, 3) around them
    within : nearer than this they touch, mm
    """

    def __init__(self, pieces: Sequence[Piece], boxes: FloatArray, within: float) -> None:
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
        from OCP.collections import (
            IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
            List_TopoDS_Shape,
        )

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
        fuse.SetFuzzyValue(within)
        fuse.Build()
        self._known = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        self._faces: dict[int, Any] = {}
        self.groups: list[list[int]] = []
        """Pieces that touch or overlap one another."""
        self.met: list[int] = []
        """All pieces in groups."""
        self.solids: list[Any] = []
        """Solids that the groups make."""
        self.done = bool(fuse.IsDone())
        if self.done:
            self._look()

    def _look(self) -> None:
        """Assign pieces to solids of the union: those in one solid have met."""
        from OCP.TopoDS import TopoDS

        every = subshapes(self._fuse.Shape(), "SOLID")
        owner: dict[int, int] = {}
        for j, solid in enumerate(every):
            for face in subshapes(solid, "FACE"):
                number = int(self._known.Add(face))
                self._faces[number], owner[number] = TopoDS.Face(face), j
        groups: dict[int, list[int]] = {}
        for k, piece in enumerate(self._pieces):
            images = [number for face in piece.faces for number in self._images(face)]
            # Nothing is left of a piece within another.
            home = owner[images[0]] if images else _holder(every, piece.shape)
            groups.setdefault(home, []).append(k)
        several = {j: group for j, group in groups.items() if len(group) > 1}
        self.groups = list(several.values())
        self.met = sorted(k for group in self.groups for k in group)
        self.solids = [every[j] for j in several if j >= 0]

    def _images(self, face: Any) -> list[int]:
        """Return the numbers of the faces of the union that are parts of a face."""
        parts = list(self._fuse.Modified(face)) or [face]
        return [number for part in parts if (number := int(self._known.FindIndex(part)))]

    def faces(self, rows: Sequence[Numbered]) -> list[Numbered]:
        """Return the faces of a solid in the union; a common face belongs to the first solid."""
        pieces = []
        for number, face in rows:
            for image in self._images(face):
                if image in self._faces:
                    pieces.append((number, self._faces.pop(image)))
        return pieces

    def place(self, group: Sequence[int]) -> tuple[tuple[float, float, float], float]:
        """Return the middle of an edge between faces of two solids, and their distance there.

        A solid within another has a place of its own.
        """
        owner: dict[int, int] = {}
        for k in group:
            for number in (n for face in self._pieces[k].faces for n in self._images(face)):
                for edge in subshapes(self._known.FindKey(number), "EDGE"):
                    other = owner.setdefault(int(self._known.Add(edge)), k)
                    if other != k:
                        at = middle(edge)
                        return at, sum(_distance(self._pieces[n].shape, at) for n in (k, other))
        smallest = min(group, key=lambda k: float(np.ptp(self._boxes[k], axis=0).prod()))
        x, y, z = self._boxes[smallest].mean(axis=0).tolist()
        return (x, y, z), 0.0

    def holds(self) -> bool:
        """Return whether the union has the right volume, and the right side at random points.

        Every point within one of the solids is within the union, every other one outside.
        """
        shapes = [self._pieces[k].shape for k in self.met]
        before, after = [volume_of(shape) for shape in shapes], [volume_of(s) for s in self.solids]
        if not max(before) * (1.0 - FULL) <= sum(after) <= sum(before) * (1.0 + FULL):
            return False
        count = min(SAMPLES, -(-MAX_SAMPLES // len(self.met)))
        shares = np.random.default_rng(0).random((len(self.met), count, 3))
        boxes = self._boxes[self.met]
        points = boxes[:, :1] + shares * np.ptp(boxes, axis=1)[:, None]
        rows = points.reshape(-1, 3)
        sides = [inside(some, rows) for some in (shapes, self.solids)]
        known = ~np.isnan(sides[0]) & ~np.isnan(sides[1])
        return bool((sides[0][known] == sides[1][known]).all())


def _holder(solids: Sequence[Any], shape: Any) -> int:
    """Return the index of the solid that contains a shape; −1 if there is none."""
    point = np.array([middle(subshapes(shape, "EDGE")[0])])
    return next((j for j, solid in enumerate(solids) if inside([solid], point)[0] != 0.0), -1)


def _diagonal(boxes: Mapping[int, FloatArray]) -> float:
    """Return the diagonal of the box around boxes; 0 without boxes."""
    corners = np.array(list(boxes.values())).reshape(-1, 3)
    return float(np.linalg.norm(np.ptp(corners, axis=0))) if len(corners) else 0.0


def closed_within(boxes: Mapping[int, FloatArray], accuracy: float) -> float:
    """Return the distance up to which solids in these boxes touch, mm.

    That is the accuracy of the file, at most 1e-6 of the size of all, or 1e-6 of the size of the
    smallest: placements are written to so many decimals, and no clearance is so narrow.
    """
    smallest = min((_diagonal({0: box}) for box in boxes.values()), default=0.0)
    return max(FINEST, min(accuracy, COINCIDENT * _diagonal(boxes)), COINCIDENT * smallest)


def groups_near(boxes: Mapping[int, FloatArray], within: float) -> list[list[int]]:
    """Return groups of two or more boxes, each within a distance of one before it."""
    keys, rows = list(boxes), np.array(list(boxes.values())).reshape(-1, 2, 3)
    left, groups = set(range(len(keys))), []
    while left:
        group = [min(left)]
        left -= set(group)
        for k in group:
            low, high = rows[k, 0] - within, rows[k, 1] + within
            meets = ((rows[:, 0] <= high) & (rows[:, 1] >= low)).all(axis=1)
            more = left.intersection(np.flatnonzero(meets).tolist())
            left -= more
            group += sorted(more)
        if len(group) > 1:
            groups.append([keys[k] for k in group])
    return groups


def between(boxes: Mapping[int, FloatArray], group: Sequence[int]) -> tuple[float, float, float]:
    """Return the middle of the intersection of the first two boxes of a group."""
    (low, high), (other_low, other_high) = boxes[group[0]], boxes[group[1]]
    x, y, z = (0.5 * (np.maximum(low, other_low) + np.minimum(high, other_high))).tolist()
    return x, y, z


def middle(edge: Any) -> tuple[float, float, float]:
    """Return the middle of an edge."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.TopoDS import TopoDS

    curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
    point = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
    return point.X(), point.Y(), point.Z()


def _distance(shape: Any, point: tuple[float, float, float]) -> float:
    """Return the distance of a point from a shape."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    found = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex(), shape)
    return float(found.Value())


def inside(shapes: Sequence[Any], points: FloatArray) -> FloatArray:
    """Return 1 (n,) for points within one of the shapes, 0 outside all, NaN on a face."""
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_State

    inner = np.zeros(len(points))
    for shape in shapes:
        low, high = box_of(shape)
        classifier = BRepClass3d_SolidClassifier(shape)
        for k in np.flatnonzero(((low <= points) & (points <= high)).all(axis=1) & (inner != 1.0)):
            classifier.Perform(gp_Pnt(*points[k].tolist()), FINEST)
            state = classifier.State()
            if state == TopAbs_State.TopAbs_IN:
                inner[k] = 1.0
            elif state == TopAbs_State.TopAbs_ON:
                inner[k] = np.nan
    return inner
