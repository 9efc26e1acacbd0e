"""Body: oriented NURBS patches with their trims and shared edges, the master of a contact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import GeometryError
from contiga.geometry.bezier import extract
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edge_gaps import measured
from contiga.geometry.edges import (
    SIDES,
    UNTRIMMED,
    BodyEdge,
    EdgeUse,
    flipped_edge,
    mirrored,
    moved_edge,
)
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import Loop, TrimTables, build_trim_tables, check_loops
from contiga.num import transform
from contiga.num.arrays import as_points, read_only
from contiga.num.ordered import length
from contiga.records import FloatArray, Hit, Projection

if TYPE_CHECKING:
    from contiga.search import Openings
    from contiga.triangles.trimesh import TriMesh

__all__ = ["SIDES", "UNTRIMMED", "Body", "BodyEdge", "EdgeUse", "face_bounds", "mirrored"]

Trims = tuple[tuple[Loop, ...] | None, ...]


class Body:
    """A rigid master: one or more NURBS patches, oriented so that normals point to the free side.

    Parameters
    ----------
    patches : NurbsSurface, one or more
    name : what reports and messages call it
    trims : one entry a patch: None for the whole natural rectangle, else loops of p-curves in the
        patch's (u, v), head to tail. The even-odd rule decides what is inside. All None if omitted.
    edges : `BodyEdge`, which patches share which edge
    unit : length unit of the coordinates, None if unknown
    reference_point : (3,) point the wrench is taken about, length, body frame

    Raises
    ------
    GeometryError
        No patches, a count of trims that does not fit, loops that do not close or leave the
        patch's rectangle, edges that name patches which are not there.

    Bodies are immutable; methods return new ones. They compare and hash by identity.
    """

    def __init__(
        self,
        patches: Iterable[NurbsSurface] | NurbsSurface,
        name: str = "body",
        trims: Sequence[Sequence[Sequence[NurbsCurve]] | None] | None = None,
        edges: Sequence[BodyEdge] = (),
        unit: str | None = None,
        reference_point: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._patches = (patches,) if isinstance(patches, NurbsSurface) else tuple(patches)
        self._name = str(name)
        if not self._patches:
            raise GeometryError("a body with no faces", where=self._name, allowed="one or more")
        for k, patch in enumerate(self._patches):
            if not isinstance(patch, NurbsSurface):
                raise GeometryError(
                    "patches must be NurbsSurface", where=f"{name}, patch {k}", found=type(patch)
                )
        self._trims = self._checked_trims(trims)
        self._edges = self._checked_edges(edges)
        self._measured = False
        self._unit = unit
        self._reference_point = read_only(as_points(reference_point, "reference_point")[0])
        self._area: float | None = None
        self._bounds: FloatArray | None = None
        self._tables: TrimTables | None = None
        self._openings: Openings | None = None

    def _checked_trims(
        self, trims: Sequence[Sequence[Sequence[NurbsCurve]] | None] | None
    ) -> Trims:
        if trims is None:
            return (None,) * len(self._patches)
        if len(trims) != len(self._patches):
            raise GeometryError(
                "trims must have one entry a patch",
                where=self._name,
                found=len(trims),
                allowed=f"{len(self._patches)} entries, None where a patch is not trimmed",
            )
        result: list[tuple[Loop, ...] | None] = []
        for k, (patch, entry) in enumerate(zip(self._patches, trims, strict=True)):
            if entry is None:
                result.append(None)
                continue
            loops = tuple(tuple(loop) for loop in entry)
            where = f"{self._name}, patch {k}"
            if not loops:
                raise GeometryError(
                    "a trimmed patch needs a loop", where=where, allowed="loops, or None"
                )
            check_loops(loops, patch.domain, where)
            result.append(loops)
        return tuple(result)

    def _checked_edges(self, edges: Sequence[BodyEdge]) -> tuple[BodyEdge, ...]:
        for k, edge in enumerate(edges):
            for use in edge.uses:
                loops = self._trims[use.patch] if 0 <= use.patch < len(self._patches) else ()
                if loops is None:
                    known = use.loop == UNTRIMMED and 0 <= use.index < len(SIDES)
                else:
                    known = 0 <= use.loop < len(loops) and 0 <= use.index < len(loops[use.loop])
                if not known:
                    raise GeometryError(
                        "an edge names a side that is not there",
                        where=f"{self._name}, edge {k}",
                        found=tuple(use),
                        allowed="(patch, loop, index) of the trims, or (patch, −1, side 0…3)",
                    )
        return tuple(edges)

    @property
    def patches(self) -> tuple[NurbsSurface, ...]:
        """The oriented patches."""
        return self._patches

    @property
    def name(self) -> str:
        """What reports and messages call the body."""
        return self._name

    @property
    def trims(self) -> Trims:
        """Per patch None, or its loops of p-curves."""
        return self._trims

    @property
    def edges(self) -> tuple[BodyEdge, ...]:
        """The known edges with the patches that use them, their gaps measured."""
        if not self._measured:
            self._edges = measured(self._edges, self._patches, self._trims)
            self._measured = True
        return self._edges

    @property
    def unit(self) -> str | None:
        """Length unit of the coordinates, None if unknown."""
        return self._unit

    @property
    def reference_point(self) -> FloatArray:
        """(3,) point the wrench is taken about."""
        return self._reference_point

    @property
    def size(self) -> float:
        """Length of the diagonal of `bounds`."""
        low, high = self.bounds()
        return length(high - low)

    def __repr__(self) -> str:
        trimmed = sum(entry is not None for entry in self._trims)
        return f"Body({self._name!r}, {len(self._patches)} patches, {trimmed} trimmed)"

    @property
    def trim_tables(self) -> TrimTables:
        """Tables for `point_in_trim` and `box_state`, built when first asked for."""
        if self._tables is None:
            self._tables = build_trim_tables(self)
        return self._tables

    def bounds(self) -> FloatArray:
        """(2, 3) low and high corner of a box that holds every face.

        Control points of each patch's elements; of trimmed patches only the part around the
        loops is counted.
        """
        if self._bounds is None:
            boxes = np.array(
                [face_bounds(*face) for face in zip(self._patches, self._trims, strict=True)]
            )
            self._bounds = read_only(np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]))
        return self._bounds

    def area(self, rtol: float = 1e-9) -> float:
        """Area of what the trims leave, length². Adaptive Gauss quadrature to about `rtol`."""
        from contiga.geometry.trim_area import body_area

        if self._area is None or rtol < 1e-9:
            self._area = body_area(self, rtol)
        return self._area

    def volume(self) -> float:
        """Volume the body encloses, length³: positive if its normals point outward.

        Means something for closed bodies only.
        """
        from contiga.geometry.trim_area import body_volume

        return body_volume(self)

    @property
    def openings(self) -> Openings:
        """Where the surface ends, where faces gape or disagree; found when first asked for."""
        from contiga.search import openings_of

        if self._openings is None:
            self._openings = openings_of(self)
        return self._openings

    @property
    def closed(self) -> bool:
        """Whether the surface ends nowhere and its faces agree on the free side.

        Told by the edges: each is used by two faces that meet there within its tolerance.
        """
        return self.openings.closed

    def tessellate(self, tol: float, method: str = "chord") -> TriMesh:
        """Triangles of the faces, trims obeyed, without cracks at shared edges.

        `tol` is a length for "chord" and an area by patch for "net", as for patches."""
        from contiga.geometry.body_mesh import body_mesh

        return body_mesh(self, tol, method).like(self.name, self.unit, self.reference_point)

    @classmethod
    def from_profile(cls, curve: NurbsCurve, depth: float = 1.0, name: str = "profile") -> Body:
        """A plane problem: `curve` in the plane z = 0, given `depth` about that plane.

        The free side is to the right of the curve's direction: a closed curve that runs
        counter-clockwise is a solid with normals outward. Forces are per `depth`.

        Raises
        ------
        GeometryError
            The curve leaves z = 0, or the depth is not positive.
        """
        points = curve.control_points
        if not (math.isfinite(depth) and depth > 0.0):
            raise GeometryError("depth must be positive", where="Body.from_profile", found=depth)
        reach = float(np.abs(points[:, :2]).max(initial=0.0))
        if np.abs(points[:, 2]).max() > 1e-12 * reach:
            raise GeometryError(
                "a profile must lie in the plane z = 0",
                where="Body.from_profile",
                found=float(np.abs(points[:, 2]).max()),
            )
        half = np.array([0.0, 0.0, 0.5 * depth])
        net = np.stack([points - half, points + half], axis=1)
        weights = None if curve.weights is None else np.stack([curve.weights] * 2, axis=1)
        knots_v = np.array([-0.5, -0.5, 0.5, 0.5]) * depth
        patch = NurbsSurface((curve.degree, 1), (curve.knots, knots_v), net, weights)
        return cls([patch], name=name)

    def _with(
        self,
        patches: Sequence[NurbsSurface],
        trims: Trims | None = None,
        edges: Sequence[BodyEdge] | None = None,
        reference_point: FloatArray | None = None,
    ) -> Body:
        return Body(
            patches,
            name=self._name,
            trims=self._trims if trims is None else trims,
            edges=self.edges if edges is None else edges,
            unit=self._unit,
            reference_point=self._reference_point if reference_point is None else reference_point,
        )

    def renamed(self, name: str) -> Body:
        """The same body under another name."""
        return Body(
            self._patches, name, self._trims, self._edges, self._unit, self._reference_point
        )

    def about(self, point: ArrayLike) -> Body:
        """The same body with another reference point (3,)."""
        return self._with(self._patches, reference_point=as_points(point, "reference_point")[0])

    def flipped(self) -> Body:
        """The same surface with free and contact side swapped; p-curves are mirrored along."""
        trims, edges = self._mirrored()
        return self._with([patch.flipped() for patch in self._patches], trims, edges)

    def _mirrored(self) -> tuple[Trims, list[BodyEdge]]:
        """Trims and edges that fit the patches once their u runs backwards."""
        trims = tuple(
            None
            if loops is None
            else tuple(tuple(mirrored(curve, patch.domain[0]) for curve in loop) for loop in loops)
            for patch, loops in zip(self._patches, self._trims, strict=True)
        )
        return trims, [flipped_edge(edge, self._patches) for edge in self.edges]

    def transformed(self, matrix: ArrayLike) -> Body:
        """The body moved by a regular affine (4, 4) matrix; the free side stays the free side."""
        return self._moved(transform.affine(matrix))

    def _moved(self, matrix: FloatArray) -> Body:
        # A patch that is reflected has its u reversed, so what is drawn on it follows.
        trims, edges = self._mirrored() if transform.reflects(matrix) else (None, self.edges)
        return self._with(
            [patch.transformed(matrix) for patch in self._patches],
            trims,
            [moved_edge(edge, matrix) for edge in edges],
            transform.apply(matrix, self._reference_point[None, :])[0],
        )

    def translated(self, d: ArrayLike) -> Body:
        """The body moved by the vector `d` (3,), length."""
        return self._moved(transform.translation(d))

    def rotated(
        self, axis: transform.Axis, angle: float, origin: ArrayLike = (0.0, 0.0, 0.0)
    ) -> Body:
        """The body turned by `angle` (radians) about `axis` ("x", "y", "z" or a vector)."""
        return self._moved(transform.rotation(axis, angle, origin))

    def scaled(self, s: float, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Body:
        """The body scaled by `s` > 0 about `origin`."""
        return self._moved(transform.scaling(s, origin))

    def project(
        self, points: ArrayLike, start: Projection | None = None, mode: str = "global"
    ) -> Projection:
        """Feet of `points` (n, 3) on the body; see `contiga.search.project`."""
        from contiga.search import project

        return project(self, as_points(points), start=start, mode=mode)

    def first_hit(self, p0: ArrayLike, p1: ArrayLike) -> Hit:
        """First entry of points moving from `p0` to `p1`; see `contiga.search.first_hit`."""
        from contiga.search import first_hit

        return first_hit(self, as_points(p0, "p0"), as_points(p1, "p1"))

    def contains(self, points: ArrayLike) -> np.ndarray:
        """(n,) bool: on the contact side of the closest face; see `contiga.search.contains`."""
        from contiga.search import contains

        return contains(self, as_points(points))


def face_bounds(patch: NurbsSurface, loops: tuple[Loop, ...] | None) -> FloatArray:
    """(2, 3) box of a face from the Bézier points of the part its loops reach."""
    if loops is not None:
        reach = np.concatenate([curve.bounds()[:, :2] for loop in loops for curve in loop])
        low, high = np.array(patch.domain).T
        a = np.clip(reach.min(axis=0), low, high)
        b = np.clip(reach.max(axis=0), low, high)
        if np.all(a < b):
            patch = patch.restricted((float(a[0]), float(b[0])), (float(a[1]), float(b[1])))
    coefs = extract(patch).coefs
    points = (coefs[..., :3] / coefs[..., 3:]).reshape(-1, 3)
    return np.array([points.min(axis=0), points.max(axis=0)])
