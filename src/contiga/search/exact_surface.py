"""The search on exact geometry: the interface for contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import bytes_of
from contiga.arrays.once import once
from contiga.arrays.perturbed_paths import Paths, robust_last_crossings
from contiga.arrays.threads import run_ranges
from contiga.geometry.faces import Faces
from contiga.geometry.slits import stitches
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
    empty_hit,
)
from contiga.search.balls.radii import balls_of
from contiga.search.borders.openings import openings_of
from contiga.search.closest.closest import closest_of_rows
from contiga.search.closest.kernels import facing_nb, safe_distance_nb
from contiga.search.contact_tables import ContactTables
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides import side_grid
from contiga.search.slopes.kernels import slopes_nb
from contiga.search.sweep.kernels import hit_nb
from contiga.search.sweep.piece_lists import PieceLists, lists_of
from contiga.search.tables import tables_of
from contiga.search.track import project

MIN_POINTS, MIN_GUARDED, MIN_SEGMENTS = 1024, 16, 256
"""Numbers of rows below which a second thread does not pay."""


@dataclass(frozen=True, eq=False)
class ExactSurface:
    """The search on a body's NURBS patches."""

    tables: Tables
    closed: bool
    """Whether the body has no border anywhere."""
    slit: float
    """Largest distance of faces where they meet, length."""

    @property
    def n_elements(self) -> int:
        """Number of Bézier elements."""
        return len(self.tables.elements.table)

    @property
    def nbytes(self) -> int:
        """Memory of the tables, bytes."""
        return bytes_of(self.tables)

    def closest(
        self, p_B: FloatArray, rows: IntArray, out: Projection, within: FloatArray | None = None
    ) -> None:
        """Write the closest points of p_B[rows] to the same rows of `out`.

        `within` (len(rows),) are upper bounds of the distances, infinite if None.
        """
        closest_of_rows(self.tables, p_B, rows, out, within)

    def closest_facing(
        self,
        p_B: FloatArray,
        guards: FloatArray,
        limits: FacingLimits,
        starts: SurfacePlaces,
        out: Projection,
    ) -> None:
        """Write the closest feet that face their `guards` (n, 3) to `out`, one row a point.

        The search is branch and bound within `limits`, bounded first by walks from `starts`. A
        point without such a foot gets the status MAX_ITERATIONS; see `facing_nb`.
        """
        query = self.tables, p_B, guards, limits, starts, out
        run_ranges(facing_nb.project_facing, len(p_B), MIN_GUARDED, *query)

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Write feet of p_B to `out`, continued from `patch`, `uv` over elements, seams and edges.

        Rows of patch −1 get their closest points. Continued feet are certified where the quick
        proof holds, if the previous points `before` (n, 3) are given.
        """
        project.track(self.tables, p_B, SurfacePlaces(patch, uv), out, before)

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """Write slopes at `feet` to `out`, one row a point, by the curvature of faces and edges."""
        run_ranges(slopes_nb.slopes, len(p_B), MIN_POINTS, self.tables, p_B, feet, out)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """Return the first entries of the paths a_B[rows] → b_B[rows], one row a path.

        The search is interval Newton; see `first_hit` for what the rows contain.
        """
        out, lists = empty_hit(len(rows)), self._lists(len(rows))
        query = self.tables, lists, a_B, b_B, rows, out
        run_ranges(hit_nb.first_hits, len(rows), MIN_SEGMENTS, *query)
        return out

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Return the last crossings of the paths a_B[rows] → b_B[rows], and their sense.

        One row a path; the sense is 1 for an entry, −1 for an exit, 0 for none. Interval Newton on
        the reversed path; paths whose crossing depends on rounding are repeated on perturbed paths
        (`robust_last_crossings`).
        """
        lists = self._lists(len(rows))

        def search(paths: Paths, out: Hit, verdict: FloatArray) -> None:
            start, end, _, loose = paths
            query = self.tables, lists, start, end, loose, out, verdict
            run_ranges(hit_nb.last_crossings, len(start), MIN_SEGMENTS, *query)

        return robust_last_crossings(search, a_B[rows], b_B[rows])

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Write the distances from p_B[rows] to the nearest box of a leaf to lengths[rows]."""
        query = self.tables.tree, p_B, rows, lengths
        run_ranges(safe_distance_nb.box_distance, len(rows), MIN_POINTS, *query)

    def sides(self, p_B: FloatArray, rows: IntArray) -> Sides:
        """Return the sides of p_B[rows] by the cells of a grid, one row for each of `rows`.

        Unknown near the surface, and for all points if the body is open.
        """
        return side_grid.side_of(self._grid, p_B, rows)

    def clear_paths(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Return (len(rows),) whether paths a_B[rows] → b_B[rows] are proved to meet no surface.

        The cells of a grid that a path passes decide; False does not mean that it meets one.
        """
        return side_grid.clear_paths(self._grid, a_B, b_B, rows)

    @cached_property
    def contact_tables(self) -> ContactTables | None:
        """The search tables, the grid of sides and the touching balls, built at the first use."""
        return ContactTables(self.tables, self._grid, balls_of(self.tables))

    def _lists(self, n_paths: int) -> PieceLists:
        """Return the lists of pieces if they pay with `n_paths` more paths, else `NO_LISTS`."""
        return lists_of(self.tables, n_paths)

    @property
    def _grid(self) -> side_grid.SideGrid:
        return side_grid.sides_of(self.tables, self.slit) if self.closed else side_grid.UNKNOWN


@once
def exact_surface(faces: Faces) -> ExactSurface:
    """Return the search on `faces`; its tables are built at the first call and kept."""
    openings = openings_of(faces)
    # Faces deviate from their common edges, and the ends of a loop from each other.
    slit = openings.slit + float(stitches(faces)[0].max(initial=0.0))
    return ExactSurface(tables_of(faces), openings.closed, slit)
