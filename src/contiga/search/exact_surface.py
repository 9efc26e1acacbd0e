"""The search on exact geometry, as contact asks for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import bytes_of
from contiga.arrays.once import once
from contiga.arrays.perturbed_paths import Paths, settled
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
    KnownSides,
    Projection,
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

# Points and segments below which a second thread does not pay.
POINTS = 1024
GUARDED = 16
SEGMENTS = 256


@dataclass(frozen=True, eq=False)
class ExactSurface:
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

    @property
    def nbytes(self) -> int:
        """Memory of the tables, bytes."""
        return bytes_of(self.tables)

    def closest(
        self, p_B: FloatArray, rows: IntArray, out: Projection, within: FloatArray | None = None
    ) -> None:
        """Closest points of the body."""
        closest_of_rows(self.tables, p_B, rows, out, within)

    def closest_facing(
        self,
        p_B: FloatArray,
        guards: FloatArray,
        limits: FacingLimits,
        starts: SurfacePlaces,
        out: Projection,
    ) -> None:
        """Closest feet by branch and bound."""
        given = self.tables, p_B, guards, limits, starts, out
        run_ranges(facing_nb.project_facing, len(p_B), GUARDED, *given)

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Feet continued over elements, seams and edges."""
        project.track(self.tables, p_B, SurfacePlaces(patch, uv), out, before)

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """Write slopes at feet by the curvature of the faces, and of edges."""
        run_ranges(slopes_nb.slopes, len(p_B), POINTS, self.tables, p_B, feet, out)

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """First entries by interval Newton."""
        out, lists = empty_hit(len(rows)), self._lists(len(rows))
        given = self.tables, lists, a_B, b_B, rows, out
        run_ranges(hit_nb.first_hits, len(rows), SEGMENTS, *given)
        return out

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Last crossings by interval Newton on the path turned round."""
        lists = self._lists(len(rows))

        def search(paths: Paths, out: Hit, verdict: FloatArray) -> None:
            start, end, _, loose = paths
            given = self.tables, lists, start, end, loose, out, verdict
            run_ranges(hit_nb.last_crossings, len(start), SEGMENTS, *given)

        return settled(search, a_B[rows], b_B[rows])

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Distances to the nearest box of a leaf."""
        given = self.tables.tree, p_B, rows, lengths
        run_ranges(safe_distance_nb.box_distance, len(rows), POINTS, *given)

    def sides(self, p_B: FloatArray, rows: IntArray) -> KnownSides:
        """By the cells of a grid."""
        return side_grid.side_of(self._grid, p_B, rows)

    def clear_ways(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """By the cells of a grid that ways pass."""
        return side_grid.clear_ways(self._grid, a_B, b_B, rows)

    @cached_property
    def contact_tables(self) -> ContactTables | None:
        """With its touching balls, and the grid of its sides."""
        return ContactTables(self.tables, self._grid, balls_of(self.tables))

    def _lists(self, asked: int) -> PieceLists:
        """Pieces near paths, as so many paths are asked for, too."""
        return lists_of(self.tables, asked)

    @property
    def _grid(self) -> side_grid.SideGrid:
        return side_grid.sides_of(self.tables, self.slit) if self.closed else side_grid.UNKNOWN


@once
def exact_surface(faces: Faces) -> ExactSurface:
    """The search on `faces`; its tables are built at the first call and kept."""
    openings = openings_of(faces)
    # Faces are off the edges they share, and their loops off themselves where they close.
    slit = openings.slit + float(stitches(faces)[0].max(initial=0.0))
    return ExactSurface(tables_of(faces), openings.closed, slit)
