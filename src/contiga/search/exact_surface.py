"""The search on exact geometry, as contact asks for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CREASE
from contiga.arrays.groups import groups_of
from contiga.arrays.layout import bytes_of
from contiga.arrays.once import once
from contiga.arrays.threads import run_ranges
from contiga.geometry.faces import Faces
from contiga.geometry.slits import stitches
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    Hit,
    IntArray,
    KnownSides,
    Projection,
    SurfacePlaces,
)
from contiga.search.balls import radii as ball
from contiga.search.borders.openings import openings_of
from contiga.search.certify.neighbourhoods import with_neighbourhoods_there
from contiga.search.closest.closest import closest_of_rows
from contiga.search.closest.kernels import facing_nb, safe_distance_nb
from contiga.search.closest.trimmed_edges import edge_turns
from contiga.search.contact_tables import ContactTables
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides import side_grid
from contiga.search.sides.body_sides import sides_of
from contiga.search.sweep import hits
from contiga.search.tables import tables_of
from contiga.search.track import project

# Points below which a second thread does not pay.
POINTS = 1024
GUARDED = 16
SHARP = 0.02
"""Radians by which faces turn at an edge that is not meant to be smooth."""


class ExactSurface(NamedTuple):
    """The search on a body's NURBS patches."""

    tables: Tables
    closed: bool
    """Whether the body has no border anywhere."""
    slit: float
    """How far faces may be apart where they meet, length."""
    sheet: IntArray
    """(patches,) number of the connected sheet that each is of."""
    has_edges: bool
    """Whether faces meet in edges or creases anywhere."""

    def are_joined(self, first: IntArray, second: IntArray) -> NDArray[np.bool_]:
        """Whether patches are of one connected sheet."""
        return np.asarray(self.sheet[first] == self.sheet[second])

    @property
    def n_elements(self) -> int:
        """Bézier pieces."""
        return len(self.tables.elements.table)

    @property
    def nbytes(self) -> int:
        """Memory of the tables, bytes."""
        return bytes_of(self.tables)

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
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

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """First entries by interval Newton."""
        return hits.hits_of_rows(self.tables, a_B, b_B, rows)

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Last crossings by interval Newton on the path turned round."""
        return hits.last_crossings(self.tables, a_B, b_B, rows)

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

    def places(self, p_B: FloatArray, rows: IntArray) -> tuple[KnownSides, SurfacePlaces]:
        """By the cells of a grid, each with a piece of the surface in it."""
        return side_grid.places(self._grid, p_B, rows)

    @property
    def contact_tables(self) -> ContactTables | None:
        """Once its balls are worked out, a closed body's; with what certificates of tracked feet
        need, once that is."""
        balls = ball.balls_there(self.tables) if self.closed else None
        if balls is None:
            return None
        return ContactTables(with_neighbourhoods_there(self.tables), self._grid, balls)

    @property
    def _grid(self) -> side_grid.SideGrid:
        return sides_of(self.tables, self.slit)

    def touching_ball(
        self, patch: IntArray, uv: FloatArray, rows: IntArray, sides: ByteArray
    ) -> FloatArray:
        """Lower bounds from cells of the elements."""
        return ball.touching_radius(self.tables, patch, uv, rows, sides)


@once
def exact_surface(faces: Faces) -> ExactSurface:
    """The search on `faces`; its tables are built at the first call and kept."""
    openings = openings_of(faces)
    # Faces are off the edges they share, and their loops off themselves where they close.
    slit = openings.slit + float(stitches(faces)[0].max(initial=0.0))
    tables = tables_of(faces)
    return ExactSurface(tables, openings.closed, slit, _sheets(tables), _has_edges(faces, tables))


def _sheets(tables: Tables) -> IntArray:
    """Numbers of connected sheets, by patch."""
    first, past = tables.grid.patches["adjacent"].T
    patch = np.repeat(np.arange(len(first)), past - first)
    return groups_of(patch, tables.grid.adjacent, len(first))


def _has_edges(faces: Faces, tables: Tables) -> bool:
    """Whether two faces, or elements of one, meet at an angle that is not rounding's."""
    creases = bool((tables.elements.table["kind"] == CREASE).any())
    return creases or bool((edge_turns(faces, tables) > SHARP).any())
