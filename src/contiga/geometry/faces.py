"""Faces: oriented NURBS patches with their trims and shared edges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.digest import Digest
from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.layout import as_points, read_only
from contiga.arrays.ordered import length
from contiga.display import Displayed, Facts
from contiga.errors import GeometryError
from contiga.extras import require
from contiga.geometry import face_box, trim
from contiga.geometry.body_key import key_of
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edge_gaps import with_measured_gaps
from contiga.geometry.edges import (
    SIDES,
    UNTRIMMED,
    BodyEdge,
    flipped_edge,
    mirrored,
    moved_edge,
)
from contiga.geometry.face_box import bounds_of
from contiga.geometry.faces_like import Trims as Trims
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import Loop, TrimTables, build_trim_tables, check_loops
from contiga.geometry.trim_area import body_area, body_volume
from contiga.records import FloatArray
from contiga.rigid import transform
from contiga.rigid.movable import Movable

if TYPE_CHECKING:
    import pyvista

    from contiga.triangles.trimesh import TriMesh

_BOXES, _TRIMS = DiskCache("boxes", face_box.__file__), DiskCache("trims", trim.__file__)


class Faces(Displayed, Movable):
    """Oriented NURBS patches with their trims and shared edges: the geometry of a `Body`.

    The parameters are those of a `Body`. Faces never change; methods return new ones, of the same
    class. They compare and hash by identity.
    """

    def __init__(
        self,
        patches: Iterable[NurbsSurface] | NurbsSurface,
        *,
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
        self._pieces_apart = False
        self._unit = unit
        self._reference_point = read_only(as_points(reference_point, "reference_point")[0])
        self._area: float | None = None
        self._bounds: FloatArray | None = None
        self._tables: TrimTables | None = None

    def _checked_trims(
        self, trims: Sequence[Sequence[Sequence[NurbsCurve]] | None] | None
    ) -> Trims:
        """Return the trims as tuples, None for each patch by default.

        Raises GeometryError unless there is one entry a patch, with loops that `check_loops`
        accepts.
        """
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
        """Return the edges; raise GeometryError unless their uses name sides of the patches."""
        for k, edge in enumerate(edges):
            for use in edge.uses:
                loops = self._trims[use.patch] if 0 <= use.patch < len(self._patches) else ()
                if loops is None:
                    exists = use.loop == UNTRIMMED and 0 <= use.index < len(SIDES)
                else:
                    exists = 0 <= use.loop < len(loops) and 0 <= use.index < len(loops[use.loop])
                if not exists:
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
        """Name of the body in reports and messages."""
        return self._name

    @property
    def trims(self) -> Trims:
        """Per patch None, or its loops of p-curves."""
        return self._trims

    @property
    def edges(self) -> tuple[BodyEdge, ...]:
        """The known edges with the patches that use them; gaps are measured at the first call."""
        if not self._measured:
            self._edges = with_measured_gaps(self._edges, self._patches, self._trims)
            self._measured = True
        return self._edges

    @property
    def pieces_apart(self) -> bool:
        """Whether pieces are known not to touch or overlap. If not, `Body.openings` checks it."""
        return self._pieces_apart

    @property
    def unit(self) -> str | None:
        """Length unit of the coordinates, None if unknown."""
        return self._unit

    @property
    def reference_point(self) -> FloatArray:
        """Point (3,) that the wrench is taken about."""
        return self._reference_point

    @property
    def size(self) -> float:
        """Length of the diagonal of `bounds`."""
        low, high = self.bounds()
        return length(high - low)

    def _picture(self) -> bytes:
        from contiga.rendering.picture import TOLERANCE, picture_of  # kernels of its own

        mesh = self.tessellate(TOLERANCE * self.size)
        return picture_of(mesh.vertices, mesh.triangles)

    def _facts(self) -> Facts:
        trimmed = sum(entry is not None for entry in self._trims)
        return [("patches", len(self._patches)), ("trimmed", trimmed)]

    @property
    def trim_tables(self) -> TrimTables:
        """Tables for `point_in_trim` and `box_state`, built or read from the disk cache once."""
        if self._tables is None:
            faces = self.patches, self.trims, self.edges
            self._tables = _TRIMS.get_or_build(key_of(self), lambda: build_trim_tables(*faces))
        return self._tables

    def bounds(self) -> FloatArray:
        """Return (2, 3) lower and upper corner of the box of the surface, trims obeyed.

        Exact up to rounding: not the box of control points. Computed once, and kept in the disk
        cache for large bodies.
        """
        if self._bounds is None:
            faces = self._patches, self._trims, lambda: self.trim_tables
            self._bounds = read_only(_BOXES.get_or_build(key_of(self), lambda: bounds_of(*faces)))
        return self._bounds

    def area(self, rtol: float = 1e-9) -> float:
        """Return the area of the trimmed faces, length², by Gauss quadrature to about `rtol`.

        A result to 1e-9 or better is kept, and serves later calls with an `rtol` of 1e-9 or more.
        """
        if self._area is None or rtol < 1e-9:
            area = body_area(self, rtol)
            if rtol > 1e-9:
                return area
            self._area = area
        return self._area

    def volume(self) -> float:
        """Return the volume of a closed body, length³, positive if normals point outward.

        Without a meaning for an open body, which is not refused.
        """
        return body_volume(self)

    def tessellate(self, tol: float, *, method: str = "chord") -> TriMesh:
        """Return triangles of the faces, trims obeyed, without cracks at shared edges.

        `tol` is a length for "chord" and an area by patch for "net", as for patches. See
        `contiga.geometry.body_mesh.body_mesh` for the errors and the warning.
        """
        from contiga.geometry.body_mesh import body_mesh  # loads many kernels

        return body_mesh(self, tol, method).like(self.name, self.unit, self.reference_point)

    def to_pyvista(self, tol: float | None = None) -> pyvista.PolyData:
        """Return the faces, trims obeyed, as triangles without data in a `pyvista.PolyData`.

        Parameters
        ----------
        tol : chord tolerance, length; a thousandth of the body's size if omitted

        Raises
        ------
        InputError, GeometryError
            The tolerance is not positive, or takes more than 40 million triangles.
        MissingPackageError
            pyvista is not installed.
        """
        require("Body.to_pyvista", "pyvista")
        return self.tessellate(1e-3 * self.size if tol is None else tol).to_pyvista()

    def _with(
        self,
        patches: Sequence[NurbsSurface],
        trims: Trims | None = None,
        edges: Sequence[BodyEdge] | None = None,
        reference_point: FloatArray | None = None,
        name: str | None = None,
    ) -> Self:
        """Return a copy with other patches, and with the members that are not None replaced."""
        faces = type(self)(
            patches,
            name=self._name if name is None else name,
            trims=self._trims if trims is None else trims,
            edges=self.edges if edges is None else edges,
            unit=self._unit,
            reference_point=self._reference_point if reference_point is None else reference_point,
        )
        faces._pieces_apart = self._pieces_apart
        return faces

    def renamed(self, name: str) -> Self:
        """Return the same body under another name."""
        return self._with(self._patches, edges=self._edges, name=name)

    def known_apart(self) -> Self:
        """Return the same body, marked as one whose pieces need no check of contact and overlap."""
        faces = self.renamed(self._name)
        faces._pieces_apart = True
        return faces

    def with_reference_point(self, point: ArrayLike) -> Self:
        """Return the same body with another reference point (3,)."""
        return self._with(self._patches, reference_point=as_points(point, "reference_point")[0])

    def flipped(self) -> Self:
        """Return the same surface with its sides swapped; u, p-curves and edges are mirrored."""
        trims, edges = self._mirrored()
        return self._with([patch.flipped() for patch in self._patches], trims, edges)

    def _mirrored(self) -> tuple[Trims, list[BodyEdge]]:
        """Return the trims and edges of the same body over patches with u reversed."""
        trims = tuple(
            None
            if loops is None
            else tuple(tuple(mirrored(curve, patch.domain[0]) for curve in loop) for loop in loops)
            for patch, loops in zip(self._patches, self._trims, strict=True)
        )
        return trims, [flipped_edge(edge, self._patches) for edge in self.edges]

    def _moved(self, matrix: FloatArray) -> Self:
        """Return the body moved by a matrix (4, 4); its reference point and tolerances follow."""
        # A reflected patch has its u reversed, and so its trims and edges.
        trims, edges = self._mirrored() if transform.reflects(matrix) else (None, self.edges)
        return self._with(
            [patch.transformed(matrix) for patch in self._patches],
            trims,
            [moved_edge(edge, matrix) for edge in edges],
            transform.apply(matrix, self._reference_point[None, :])[0],
        )

    def digest(self, digest: Digest) -> None:
        """Add the data that results depend on to a digest: reference point, patches, trims, edges.

        Name, unit and measured gaps are left out.
        """
        digest.arrays("about", np.asarray(self.reference_point))
        for patch, loops in zip(self.patches, self.trims, strict=True):
            digest.arrays("patch", *patch.knots, patch.control_points, patch.weights)
            digest.text("whole" if loops is None else f"{[len(loop) for loop in loops]}")
            for curve in chain.from_iterable(loops or ()):
                digest.arrays("trim", curve.knots, curve.control_points, curve.weights)
        for edge in self.edges:
            digest.text(repr((edge.uses, edge.spans, edge.tolerance, edge.stated, edge.corner)))
