"""The search on a triangle mesh: the interface for contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import bytes_of
from contiga.arrays.threads import run_ranges
from contiga.errors import MeshError
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    FootSlopes,
    Hit,
    IntArray,
    Projection,
    Sides,
    SurfacePlaces,
)
from contiga.triangles.facet_feet import closest_of_rows, is_smooth, track
from contiga.triangles.facet_hits import hits_of_rows, last_crossings
from contiga.triangles.facet_tables import Tables, tables_of
from contiga.triangles.kernels import closest_nb, facet_slopes_nb
from contiga.triangles.triangle_arrays import TriangleArrays

MIN_POINTS, MIN_GUARDED = 1024, 64
"""Numbers of points below which a second thread does not pay."""


class FacetedSurface(NamedTuple):
    """The search on triangles; parameters of feet are not needed to continue them."""

    tables: Tables
    smooth: bool
    """Whether normals are interpolated from the normals of the vertices."""

    @property
    def closed(self) -> bool:
        """Whether no edge belongs to one triangle only."""
        return self.tables.closed

    @property
    def n_elements(self) -> int:
        """Number of triangles with an area."""
        return len(self.tables.facets.link)

    @property
    def nbytes(self) -> int:
        """Memory of the tables, bytes; the mesh itself is not counted."""
        return bytes_of(self.tables)

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
    ) -> None:
        """Write the closest points of p_B[rows] to the same rows of `out`; `within` is ignored."""
        closest_of_rows(self.tables.facets, p_B, rows, self.smooth, out)

    def closest_facing(
        self,
        p_B: FloatArray,
        guards: FloatArray,
        limits: FacingLimits,
        starts: SurfacePlaces,
        out: Projection,
    ) -> None:
        """Write the closest feet that face their `guards` (n, 3) to `out`, one row a point.

        A point without such a foot within `limits` gets the status MAX_ITERATIONS; `starts` is
        ignored, because all triangles are searched: see `closest_nb.project_facing`.
        """
        facets, facing = self.tables.facets, closest_nb.project_facing
        run_ranges(facing, len(p_B), MIN_GUARDED, facets, p_B, guards, limits, self.smooth, out)

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Write feet continued from the triangles `patch` (n,) over adjoining ones to `out`.

        Rows of patch −1 are searched globally. Only with the last points `before` (n, 3) are feet
        certified; `uv` is ignored.
        """
        track(self.tables, p_B, (patch, before), self.smooth, out)

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """Write slopes at `feet` to `out`, one row a point: normals rotate at kinks.

        Normals are interpolated if `smooth`.
        """
        query = self.tables.facets, self.tables.slot, self.smooth, p_B, feet, out
        run_ranges(facet_slopes_nb.slopes, len(p_B), MIN_POINTS, *query)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """Return the first entries of a_B[rows] → b_B[rows] from the free side, one row a path."""
        return hits_of_rows(self.tables.facets, a_B, b_B, rows)

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Return the last crossings of a_B[rows] → b_B[rows] from either side, and their senses.

        One row a path; the sense is 1 for an entry, −1 for an exit, 0 for none.
        """
        return last_crossings(self.tables.facets, a_B, b_B, rows)

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Write lower bounds of the distances of p_B[rows] to lengths[rows].

        They are the distances to the nearest box of a triangle; infinite for points not finite.
        """
        facets = self.tables.facets
        run_ranges(closest_nb.box_distance, len(rows), MIN_POINTS, facets, p_B, rows, lengths)

    def sides(self, p_B: FloatArray, rows: IntArray) -> Sides:
        """Return unknown sides (0) of reach 0 for each of `rows`: a mesh has no grid of sides."""
        return Sides(np.zeros(len(rows), np.int8), np.zeros(len(rows)))

    def clear_paths(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Return False for each of `rows`: no path is known to be clear."""
        return np.zeros(len(rows), dtype=bool)

    @property
    def contact_tables(self) -> None:
        """None: a mesh has no such tables."""


def faceted_surface(mesh: TriangleArrays) -> FacetedSurface:
    """Return the search on `mesh`, with the mesh's kind of normals; its tables are kept.

    Raises
    ------
    MeshError
        No triangle has an area, or neighbours face opposite ways or lie back to back: they have
        no common free side.
    """
    tables = tables_of(mesh)
    if len(tables.back_to_back):
        first, second = tables.back_to_back[0]
        raise MeshError(
            "triangles lie back to back, so that neither side is free",
            where=mesh.name,
            found=f"{len(tables.back_to_back)} pairs, first {first} and {second}",
            allowed="one triangle at a place",
            remedy="Take one of each pair out, or choose the parts of the mesh that are the body",
        )
    if tables.turned:
        raise MeshError(
            "neighbouring triangles face opposite ways",
            where=mesh.name,
            found=f"{tables.turned} edges",
            allowed="triangles anticlockwise seen from the free side",
            remedy="Use mesh.oriented(), or orient = true beside the mesh of a case",
        )
    return FacetedSurface(tables, is_smooth(mesh, None))
