"""A master as contact sees it: the same few questions to exact geometry and to triangles."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from contiga.geometry.body import Body
from contiga.geometry.trimesh import TriMesh
from contiga.records import ByteArray, FloatArray, Hit, IntArray, Projection
from contiga.search import ball, hits, projection, reach
from contiga.search.records import Tables
from contiga.search.tables import tables_of


class Surface(Protocol):
    """What can be searched. Points are in the master's frame; rows choose among them."""

    @property
    def closed(self) -> bool:
        """Whether the surface has no border anywhere."""
        ...  # pragma: no cover

    @property
    def n_elements(self) -> int:
        """Pieces the search works on."""
        ...  # pragma: no cover

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
    ) -> None:
        """Closest points of p_B[rows] into the same rows of `out`.

        `within` (len(rows),) are distances to points of the surface that are known, infinite where
        none is: what is farther need not be looked at.
        """
        ...  # pragma: no cover

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Feet continued from (patch, uv) into `out`; rows of patch −1 by `closest`.

        `before` (n, 3) is where the points were when their feet were (patch, uv): needed for
        tracked feet to be certified.
        """
        ...  # pragma: no cover

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """First entries of the segments a_B[rows] → b_B[rows], one row an entry of `rows`."""
        ...  # pragma: no cover

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Crossings of either sense nearest to the ends of a_B[rows] → b_B[rows], and whether the
        path enters there (1), leaves (−1), or crosses nothing (0)."""
        ...  # pragma: no cover

    def reach(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Lower bounds of the distance of p_B[rows] into lengths[rows]; zero when near."""
        ...  # pragma: no cover

    def inner_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """(len(rows),) radii of balls that touch inside at feet (patch, uv)[rows], else zero.

        Such a ball, and every smaller one, holds no other point of the surface.
        """
        ...  # pragma: no cover

    def outer_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """(len(rows),) the same on the free side."""
        ...  # pragma: no cover


class ExactSurface(NamedTuple):
    """The search on a body's NURBS patches."""

    tables: Tables
    closed: bool
    """Whether the body has no border anywhere."""

    @property
    def n_elements(self) -> int:
        """Bézier pieces."""
        return len(self.tables.elements.table)

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
    ) -> None:
        """Closest points of the body."""
        projection.closest_of_rows(self.tables, p_B, rows, out, within)

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Feet continued over elements, seams and edges."""
        projection.track(self.tables, p_B, (patch, uv), out, before)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """First entries by interval Newton."""
        return hits.hits_of_rows(self.tables, a_B, b_B, rows)

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Last crossings by interval Newton on the path turned round."""
        return hits.last_crossings(self.tables, a_B, b_B, rows)

    def reach(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Distances to the nearest box of a leaf."""
        reach.box_reach(self.tables, p_B, rows, lengths)

    def inner_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """Lower bounds from cells of the elements."""
        return ball.touching_radius(self.tables, patch, uv, rows, ball.INNER)

    def outer_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """Lower bounds from cells of the elements."""
        return ball.touching_radius(self.tables, patch, uv, rows, ball.OUTER)


def surface_of(master: Body | TriMesh) -> Surface:
    """The search on `master`; its tables are built at the first call and kept.

    Raises
    ------
    MeshError
        A mesh without a triangle that has an area.
    """
    if isinstance(master, TriMesh):
        from contiga.search.faceted.surface import faceted_surface

        return faceted_surface(master)
    return ExactSurface(tables_of(master), master.closed)
