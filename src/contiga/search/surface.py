"""A master as contact sees it: the same few questions to exact geometry and to triangles."""

from __future__ import annotations

from typing import NamedTuple, Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.body import Body
from contiga.geometry.slits import stitches
from contiga.records import ByteArray, FloatArray, Hit, IntArray, Projection
from contiga.search import ball, hits, projection, reach, side_grid
from contiga.search.body_sides import sides_of
from contiga.search.records import Tables
from contiga.search.tables import tables_of
from contiga.triangles.trimesh import TriMesh


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

    def sides(self, p_B: FloatArray, rows: IntArray) -> tuple[ByteArray, FloatArray]:
        """Sides of p_B[rows] as far as they are known at once: 1 outside, −1 inside, else 0; and
        where they are, a length greater than rounding that leads to no surface.

        Closed surfaces only.
        """
        ...  # pragma: no cover

    def clear_ways(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """(len(rows),) True where a_B[rows] → b_B[rows] is known to meet no surface.

        Closed surfaces only.
        """
        ...  # pragma: no cover

    def nearby(self, p_B: FloatArray, rows: IntArray) -> tuple[IntArray, FloatArray]:
        """Places (patch, uv) not far from those of p_B[rows] that lie near the surface; patch −1
        for others. Closed surfaces only."""
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
    slit: float
    """How far faces may be apart where they meet, length."""

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

    def sides(self, p_B: FloatArray, rows: IntArray) -> tuple[ByteArray, FloatArray]:
        """By the cells of a grid."""
        return side_grid.side_of(self._grid, p_B, rows)

    def clear_ways(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """By the cells of a grid that ways pass."""
        return side_grid.clear_ways(self._grid, a_B, b_B, rows)

    def nearby(self, p_B: FloatArray, rows: IntArray) -> tuple[IntArray, FloatArray]:
        """A piece of the surface in the cell."""
        return side_grid.nearby(self._grid, p_B, rows)

    @property
    def _grid(self) -> side_grid.SideGrid:
        return sides_of(self.tables, self.slit)

    def inner_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """Lower bounds from cells of the elements."""
        return ball.touching_radius(self.tables, patch, uv, rows, ball.INNER)

    def outer_ball(self, patch: IntArray, uv: FloatArray, rows: IntArray) -> FloatArray:
        """Lower bounds from cells of the elements."""
        return ball.touching_radius(self.tables, patch, uv, rows, ball.OUTER)


_KEPT: WeakKeyDictionary[Body, ExactSurface] = WeakKeyDictionary()


def surface_of(master: Body | TriMesh) -> Surface:
    """The search on `master`; its tables are built at the first call and kept.

    Raises
    ------
    MeshError
        A mesh without a triangle that has an area.
    """
    if isinstance(master, TriMesh):
        from contiga.triangles.facet_surface import faceted_surface

        return faceted_surface(master)
    surface = _KEPT.get(master)
    if surface is None:
        # Faces are off the edges they share, and their loops off themselves where they close.
        slit = master.openings.slit + float(stitches(master)[0].max(initial=0.0))
        surface = _KEPT[master] = ExactSurface(tables_of(master), master.closed, slit)
    return surface
