"""Whether a body is closed: from the faces that share its edges, within its tolerances."""

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

N_SAMPLES = 33
"""Number of points per knot span that measure the length of a free edge."""
TOUCH_TOL = 1e-9
"""Largest distance of pieces that touch, as a share of the body's size."""
SENSE = np.array([-1, 1, 1, -1])
"""Sense of the parameter along u0, u1, v0, v1, relative to a walk with the patch on the left."""


class Openings(NamedTuple):
    """The places where a body's surface ends or is not sound; lengths in the body's unit."""

    free_edges: int
    """Number of edges (and unnamed sides of untrimmed patches) that only one face uses."""
    free_length: float
    """Their total length."""
    gaping_edges: int
    """Number of shared edges from which a face is farther off than `bridged`."""
    crowded_edges: int
    """Number of edges that more than two faces use, not in pairs."""
    turned_faces: tuple[int, ...]
    """Patches whose free side is the contact side of most patches joined to them."""
    one_sided: int
    """Number of joints that agree with no choice of sides, as on a Moebius strip."""
    slit: float
    """Largest distance of a face from an edge it shares."""
    slit_patches: tuple[int, ...]
    """The patches that meet there; empty if no faces share an edge."""
    slit_point: tuple[float, float, float]
    """The place of the slit, body frame."""
    tolerance: float
    """Largest tolerance of edges and corners that the file states, 0 if it states none."""
    bridged: float
    """Largest distance from a shared edge within which faces count as joined."""
    size: float
    """Size of the body."""
    unit: str | None
    """Unit of lengths, None if unknown."""
    meetings: tuple[Meeting, ...] = ()
    """The first few places where closed pieces touch or overlap."""
    crossing: Crossing | None = None
    """A place where a face crosses itself or another of its closed piece."""

    @property
    def closed(self) -> bool:
        """Whether no border, no disagreement on the free side, no crossing or meeting was found."""
        n_open = self.free_edges + self.gaping_edges + self.crowded_edges + self.one_sided
        is_sound = not self.turned_faces and not self.meetings and self.crossing is None
        return n_open == 0 and is_sound

    @property
    def flaws(self) -> list[str]:
        """Flaws of joints, sides, crossings and meetings, one text for each kind; empty for none.

        Free edges are not among them; a bridged slit is, although the body may be closed.
        """
        texts = []
        if self.gaping_edges:
            texts.append(
                f"{_counted(self.gaping_edges, 'edge')} shared by faces that do not meet "
                f"(tolerance {self._with_unit(self.bridged)}): {self._slit_text()}"
            )
        elif self.slit > ROUNDING * self.size:
            texts.append(f"a slit along a shared edge, which is bridged: {self._slit_text()}")
        if self.crowded_edges:
            texts.append(f"{_counted(self.crowded_edges, 'edge')} of more than two faces")
        if self.turned_faces:
            patches = ", ".join(str(k) for k in self.turned_faces[:4])
            more = ", …" if len(self.turned_faces) > 4 else ""
            count = _counted(len(self.turned_faces), "face")
            texts.append(f"{count} turned the other way than those around (patch {patches}{more})")
        if self.one_sided:
            texts.append("faces that cannot agree on a free side")
        if self.crossing is not None:
            texts.append(f"{self.crossing}: there it has no side")
        if self.meetings:
            texts.append(f"pieces that touch or overlap: {'; '.join(map(str, self.meetings))}")
        return texts

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Rows of a table for users, (label, text): surface, flaws, tolerance and largest gap.

        Flaws have an empty label. Tolerance and gap are left out if no faces share an edge.
        """
        if self.closed:
            surface = "closed"
        elif self.free_edges:
            edges = _counted(self.free_edges, "free edge")
            surface = f"open, {edges}, {self._with_unit(self.free_length, 6)} long in all"
        elif self.crossing is not None:
            surface = "goes through itself: it has no proved sides"
        elif self.meetings:
            surface = "closed pieces that meet: it has no proved sides"
        else:
            surface = "open"
        rows = [("surface", surface)]
        rows += [("", flaw) for flaw in self.flaws]
        if self.slit_patches:
            if self.tolerance > 0.0:
                rows.append(("largest tolerance", self._with_unit(self.tolerance)))
            rows.append(("largest gap", self._slit_text()))
        return rows

    def _with_unit(self, value: float, digits: int = 3) -> str:
        return f"{value:.{digits}g}" + ("" if self.unit is None else f" {self.unit}")

    def _slit_text(self) -> str:
        x, y, z = self.slit_point
        place = "between patches {} and {}" if len(self.slit_patches) > 1 else "within patch {}"
        return (
            f"{self._with_unit(self.slit)} ({self.slit / self.size:.1g} of the size) "
            f"{place.format(*self.slit_patches)} at ({x:.6g}, {y:.6g}, {z:.6g})"
        )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")


_DISK = DiskCache("openings", __file__)


@once
def openings_of(body: Faces) -> Openings:
    """Return where `body` is open or unsound; computed at the first call and cached.

    Faces are joined if they share an edge of the body, within its tolerances. Sides of untrimmed
    patches that no edge names are matched in space. A flood fill over the joints finds the faces
    that disagree on the free side.
    """
    return _DISK.get_or_build(key_of(body), lambda: _compute(body))


def _compute(body: Faces) -> Openings:
    """Find where a body is open or unsound.

    A face that crosses itself is always looked for; faces that cross each other only if edges and
    sides show the body closed, and meetings only if no crossing was found, either. Meetings of a
    body with one patch, or with `pieces_apart`, are not looked for.
    """
    joints = joints_of(body)
    length = 0.0
    for k in np.flatnonzero(joints.open):
        curve = body.edges[k].curve
        breaks = np.unique(curve.knots)
        length += _length(curve, np.stack([breaks[:-1], breaks[1:]]))
    extents, is_open = stitches(body)
    sides, side_joints = _unnamed_sides(body)
    turned, at_odds = turned_faces(len(body.patches), joints.joints + side_joints)
    # The largest gap of a shared edge, the patches that meet there, and its place.
    slit, point = 0.0, (0.0, 0.0, 0.0)
    patches: tuple[int, ...] = ()
    shared = [edge for edge in body.edges if len(edge.uses) > 1]
    if shared:
        edge = max(shared, key=lambda edge: edge.gap)
        images = [image_of(edge, k, body.patches, body.trims) for k in range(len(edge.uses))]
        image = max(images, key=lambda image: image.gap)
        slit, point = image.gap, image.point
        patches = tuple(dict.fromkeys(use.patch for use in edge.uses))
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
    piece: IntArray = np.arange(len(body.patches), dtype=np.int32)
    if openings.closed:
        piece = _connected_pieces(len(body.patches), joints.joints + side_joints)
    from contiga.search.borders.crossings import crossing_of  # loads the search
    from contiga.search.borders.meetings import meetings_of

    openings = openings._replace(crossing=crossing_of(body, piece, slit))
    if body.pieces_apart or not openings.closed or len(body.patches) < 2:
        return openings
    tolerance = max(TOUCH_TOL * body.size, 2.0 * slit)
    return openings._replace(meetings=meetings_of(body, piece, tolerance))


def pieces_of(body: Faces) -> list[IndexArray]:
    """Return the patches of each piece, connected by edges or by sides that no edge names."""
    joints = joints_of(body).joints + _unnamed_sides(body)[1]
    piece = _connected_pieces(len(body.patches), joints)
    return [np.flatnonzero(piece == k) for k in range(piece.max() + 1)]


def _connected_pieces(n: int, joints: list[Joint]) -> IntArray:
    """Return (n,) number of the connected piece of each patch."""
    first, second = np.array([joint[:2] for joint in joints], np.int64).reshape(-1, 2).T
    return groups_of(first, second, n)


def _unnamed_sides(body: Faces) -> tuple[list[float], list[Joint]]:
    """Return the lengths of free sides that no edge names, and the joints of other such sides.

    Only sides of untrimmed patches that are longer than their tolerance count. Each joint is listed
    once.
    """
    named = {(use.patch, use.index) for e in body.edges for use in e.uses if use.loop == UNTRIMMED}
    reach = reach_of_loops(body)
    unnamed = np.zeros((len(body.patches), 4), bool)
    for k in (k for k, loops in enumerate(body.trims) if loops is None):
        net = body.patches[k].control_points
        for side, row in enumerate((net[0], net[-1], net[:, 0], net[:, -1])):
            # The length of the control polygon is an upper bound, and 0 if the side is a point.
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
    free_sides = zip(patch[rows[free]].tolist(), sides[free].tolist(), strict=True)
    lengths = []
    for k, side in dict.fromkeys(free_sides):
        elements = rows[free & (patch[rows] == k) & (sides == side)]
        axis = 1 - side // 2
        side_value = {"uv"[1 - axis]: domain[k, side]}
        spans = table["box"][elements][:, 2 * axis : 2 * axis + 2]
        lengths.append(_length(body.patches[k].isocurve(**side_value), spans.T))
    rows, sides = rows[kind <= CREASE], sides[kind <= CREASE]
    neighbour = table["neighbour"][rows, sides]
    sense = SENSE[sides] * SENSE[table["neighbour_side"][rows, sides]]
    agree = sense * (1 - 2 * table["flip"][rows, sides]) < 0
    pairs = np.sort([patch[rows], patch[neighbour]], axis=0)
    joints = zip(*pairs.tolist(), agree.tolist(), strict=True)
    return lengths, [Joint(*joint) for joint in dict.fromkeys(joints)]


def _length(curve: NurbsCurve, spans: FloatArray) -> float:
    """Return the length of a curve over spans (2, n) by chords, with a relative error of 1e-4."""
    t = np.linspace(spans[0], spans[1], N_SAMPLES)
    points = curve.evaluate(t.ravel()).reshape(*t.shape, 3)
    return float(np.linalg.norm(np.diff(points, axis=0), axis=2).sum())
