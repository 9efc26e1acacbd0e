"""Whether a body is closed: from which faces share its edges, as far as its tolerances go."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga.arrays.codes import BORDER, CREASE
from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.groups import groups_of
from contiga.arrays.once import once
from contiga.geometry.body_key import key_of
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edge_gaps import image_of
from contiga.geometry.edges import UNTRIMMED
from contiga.geometry.faces import Faces
from contiga.geometry.joints import Joint, joints_of, turned_faces
from contiga.geometry.slits import (
    ROUNDING,
    gaping_edges,
    reach_of_loops,
    stated_tolerance,
    stitches,
    widest_slit,
)
from contiga.records import FloatArray, IndexArray, IntArray

if TYPE_CHECKING:
    from contiga.search.borders.crossings import Crossing
    from contiga.search.borders.meetings import Meeting

SAMPLES = 33
"""Points of each knot span of a free edge its length is measured with."""
TOUCH = 1e-9
"""Pieces that come nearer than this share of the size touch."""
SENSE = np.array([-1, 1, 1, -1])
"""Of the growing parameter along u0, u1, v0, v1, to a walk round with the patch on the left."""


class Openings(NamedTuple):
    """The places where a body's surface ends or is not sound; lengths in the body's unit."""

    free_edges: int
    """Edges (and sides of untrimmed patches no edge names) that one face uses and no other."""
    free_length: float
    """Their total length."""
    gaping_edges: int
    """Edges shared by faces that are farther off them than `bridged`."""
    crowded_edges: int
    """Edges more than two faces use, not in pairs."""
    turned_faces: tuple[int, ...]
    """Patches whose free side is the contact side of the most they are joined to."""
    one_sided: int
    """Joints no choice of sides agrees with, as on a Moebius strip."""
    slit: float
    """Farthest that a face is off an edge it shares."""
    slit_patches: tuple[int, ...]
    """The patches that meet there; none where no faces share an edge."""
    slit_point: tuple[float, float, float]
    """Where that is, body frame."""
    tolerance: float
    """Largest tolerance of edges and corners that the file states, 0 where it states none."""
    bridged: float
    """Faces that are off a shared edge by up to this meet there all the same."""
    size: float
    """Of the body."""
    unit: str | None
    """Of lengths, where that is known."""
    meetings: tuple[Meeting, ...] = ()
    """Where closed pieces touch or overlap: the first few."""
    crossing: Crossing | None = None
    """Where a face goes through itself, or of a closed piece through another: the first found."""

    @property
    def closed(self) -> bool:
        """Whether the surface ends nowhere, faces agree on the free side, pieces are apart."""
        ends = self.free_edges + self.gaping_edges + self.crowded_edges + self.one_sided
        sound = not self.turned_faces and not self.meetings and self.crossing is None
        return ends == 0 and sound

    @property
    def flaws(self) -> list[str]:
        """Flaws of a body that was to be closed, or of its joints; one text each."""
        texts = []
        if self.gaping_edges:
            texts.append(
                f"{_several(self.gaping_edges, 'edge')} shared by faces that do not meet "
                f"(tolerance {self._told(self.bridged)}): {self._where()}"
            )
        elif self.slit > ROUNDING * self.size:
            texts.append(f"a slit along a shared edge, which is bridged: {self._where()}")
        if self.crowded_edges:
            texts.append(f"{_several(self.crowded_edges, 'edge')} of more than two faces")
        if self.turned_faces:
            some = ", ".join(str(k) for k in self.turned_faces[:4])
            more = ", …" if len(self.turned_faces) > 4 else ""
            count = _several(len(self.turned_faces), "face")
            texts.append(f"{count} turned the other way than those around (patch {some}{more})")
        if self.one_sided:
            texts.append("faces that cannot agree on a free side")
        if self.crossing is not None:
            texts.append(f"{self.crossing}: there it has no side")
        if self.meetings:
            texts.append(f"pieces that touch or overlap: {'; '.join(map(str, self.meetings))}")
        return texts

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Rows for people: (label, text)."""
        rows = [("surface", self._surface())]
        rows += [("", flaw) for flaw in self.flaws]
        if self.slit_patches:
            if self.tolerance > 0.0:
                rows.append(("largest tolerance", self._told(self.tolerance)))
            rows.append(("largest gap", self._where()))
        return rows

    def _surface(self) -> str:
        if self.closed:
            return "closed"
        if self.free_edges:
            edges = _several(self.free_edges, "free edge")
            return f"open, {edges}, {self._told(self.free_length, 6)} long in all"
        if self.crossing is not None:
            return "goes through itself: it has no proved sides"
        return "closed pieces that meet: it has no proved sides" if self.meetings else "open"

    def _told(self, value: float, digits: int = 3) -> str:
        return f"{value:.{digits}g}" + ("" if self.unit is None else f" {self.unit}")

    def _where(self) -> str:
        x, y, z = self.slit_point
        where = "between patches {} and {}" if len(self.slit_patches) > 1 else "within patch {}"
        share = self.slit / self.size
        return (
            f"{self._told(self.slit)} ({share:.1g} of the size) {where.format(*self.slit_patches)} "
            f"at ({x:.6g}, {y:.6g}, {z:.6g})"
        )


def _several(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


_DISK = DiskCache("openings", __file__)


@once
def openings_of(body: Faces) -> Openings:
    """Return where `body` is open or unsound: nothing of a closed one.

    Faces are joined where they share an edge of the body; its tolerances say how far they may be
    apart. Sides of untrimmed patches that no edge names are matched in space. A flood over the
    joints tells which faces disagree on the free side. Worked out at the first call and kept.
    """
    return _DISK.kept(key_of(body), lambda: _found(body))


def _found(body: Faces) -> Openings:
    joints = joints_of(body)
    curves = [body.edges[k].curve for k in np.flatnonzero(joints.open)]
    breaks = [np.unique(curve.knots) for curve in curves]
    length = sum(
        _length(curve, np.stack([ends[:-1], ends[1:]]))
        for curve, ends in zip(curves, breaks, strict=True)
    )
    extents, is_open = stitches(body)
    sides, side_joints = _unnamed_sides(body)
    turned, at_odds = turned_faces(len(body.patches), joints.joints + side_joints)
    slit, patches, point = _worst(body)
    openings = Openings(
        free_edges=int(joints.open.sum()) + int(is_open.sum()) + len(sides),
        free_length=float(length + extents[is_open].sum() + sum(sides)),
        gaping_edges=int(gaping_edges(body).sum()),
        crowded_edges=int(joints.crowded.sum()),
        turned_faces=turned,
        one_sided=at_odds,
        slit=slit,
        slit_patches=patches,
        slit_point=point,
        tolerance=stated_tolerance(body),
        bridged=widest_slit(body),
        size=body.size,
        unit=body.unit,
    )
    every: IntArray = np.arange(len(body.patches), dtype=np.int32)
    piece = _pieces(len(every), joints.joints + side_joints) if openings.closed else every
    from contiga.search.borders.crossings import crossing_of  # they search
    from contiga.search.borders.meetings import meetings_of

    openings = openings._replace(crossing=crossing_of(body, piece, slit))
    if body.pieces_apart or not openings.closed or len(body.patches) < 2:
        return openings
    within = max(TOUCH * body.size, 2.0 * slit)
    return openings._replace(meetings=meetings_of(body, piece, within))


def pieces_of(body: Faces) -> list[IndexArray]:
    """Patches of each piece: of what hangs together by edges, or by sides that no edge names."""
    joints = joints_of(body).joints + _unnamed_sides(body)[1]
    piece = _pieces(len(body.patches), joints)
    return [np.flatnonzero(piece == k) for k in range(piece.max() + 1)]


def _pieces(n: int, joints: list[Joint]) -> IntArray:
    """Return (n,) numbers of the pieces that patches hang together in."""
    first, second = np.array([joint[:2] for joint in joints], np.int64).reshape(-1, 2).T
    return groups_of(first, second, n)


def _worst(body: Faces) -> tuple[float, tuple[int, ...], tuple[float, float, float]]:
    """The largest gap of a shared edge, the patches that meet there, and where it is."""
    shared = [edge for edge in body.edges if len(edge.uses) > 1]
    if not shared:
        return 0.0, (), (0.0, 0.0, 0.0)
    edge = max(shared, key=lambda each: each.gap)
    images = [image_of(edge, k, body.patches, body.trims) for k in range(len(edge.uses))]
    image = max(images, key=lambda each: each.gap)
    patches = tuple(dict.fromkeys(use.patch for use in edge.uses))
    return image.gap, patches, image.point


def _unnamed_sides(body: Faces) -> tuple[list[float], list[Joint]]:
    """Lengths of free sides of untrimmed patches that no edge names, and the joints of others."""
    named = {(use.patch, use.index) for e in body.edges for use in e.uses if use.loop == UNTRIMMED}
    reach = reach_of_loops(body)
    unnamed = np.zeros((len(body.patches), 4), bool)
    for k in (k for k, loops in enumerate(body.trims) if loops is None):
        net = body.patches[k].control_points
        for side, row in enumerate((net[0], net[-1], net[:, 0], net[:, -1])):
            # Its length is 0 where the side is a point, else no less than the side's.
            length = float(np.linalg.norm(np.diff(row, axis=0), axis=1).sum())
            unnamed[k, side] = (k, side) not in named and length > reach[k, UNTRIMMED]
    if not unnamed.any():
        return [], []
    from contiga.search.tables import tables_of

    table = tables_of(body).elements.table
    patch = table["patch"]
    domain = np.array([np.ravel(surface.domain) for surface in body.patches])
    rows, sides = np.nonzero(unnamed[patch] & (table["box"] == domain[patch]))
    order = np.lexsort([rows, sides, patch[rows]])
    rows, sides = rows[order], sides[order]
    kind = table["kind"][rows, sides]
    free = kind == BORDER
    lengths = []
    for k, side in dict.fromkeys(
        zip(patch[rows[free]].tolist(), sides[free].tolist(), strict=True)
    ):
        here = rows[free & (patch[rows] == k) & (sides == side)]
        along = 1 - side // 2
        end = {"uv"[1 - along]: domain[k, side]}
        spans = table["box"][here][:, 2 * along : 2 * along + 2]
        lengths.append(_length(body.patches[k].isocurve(**end), spans.T))
    rows, sides = rows[kind <= CREASE], sides[kind <= CREASE]
    other = table["neighbour"][rows, sides]
    sense = SENSE[sides] * SENSE[table["neighbour_side"][rows, sides]]
    agree = sense * (1 - 2 * table["flip"][rows, sides]) < 0
    pairs = np.sort([patch[rows], patch[other]], axis=0)
    joints = zip(*pairs.tolist(), agree.tolist(), strict=True)
    return lengths, [Joint(*each) for each in dict.fromkeys(joints)]


def _length(curve: NurbsCurve, spans: FloatArray) -> float:
    """Length of a curve over spans of its parameter (2, n), by chords, to about 1e-4 of it."""
    t = np.linspace(spans[0], spans[1], SAMPLES)
    points = curve.evaluate(t.ravel()).reshape(*t.shape, 3)
    return float(np.linalg.norm(np.diff(points, axis=0), axis=2).sum())
