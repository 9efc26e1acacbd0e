"""The search on exact geometry whose control points move.

Neighbours, openings, trims, joints and the map from control points to elements are those of the
body at rest, computed once. Elements, boxes and hierarchy are computed for each shape, so that all
proofs of a search hold for that shape. Tables that pay only for a fixed shape (touching balls,
grids of sides, lists of pieces, neighbourhoods) are neither built nor used, and only the last two
shapes are cached.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import SHARED
from contiga.arrays.layout import read_only
from contiga.arrays.once import once
from contiga.arrays.ordered import length, row_lengths
from contiga.arrays.perturbed_paths import Paths, robust_last_crossings
from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Elements
from contiga.elements.kernels import sides_nb
from contiga.elements.refit import Refit, refit_of
from contiga.errors import GeometryError
from contiga.geometry.edges import UNTRIMMED
from contiga.geometry.faces import Faces
from contiga.geometry.net import ControlNet, net_of
from contiga.records import (
    ByteArray,
    FloatArray,
    Hit,
    IntArray,
    Projection,
    Sides,
    SurfacePlaces,
)
from contiga.search.closest.kernels import nearest_nb
from contiga.search.closest.surroundings import Blocks, Surroundings, blocks_of, surroundings_of
from contiga.search.exact_surface import ExactSurface, exact_surface
from contiga.search.hierarchy.build import build_hierarchy, empty_seeds, items_of
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sweep.kernels import moving_nb
from contiga.search.sweep.piece_lists import NO_LISTS, PieceLists
from contiga.search.sweep.sweep_records import MovingSurface
from contiga.search.tables import check_extent

MIN_POINTS = 256
"""Number of points below which a second thread does not pay."""
JOINT_SHIFT = 1e-2
"""Standard deviation of the random displacements of control points that test which sides stay
together, as a share of the body's size."""
JOINT_TOL = 1e-9
"""Largest distance of two sides that stay together after these displacements, as a share of the
body's size."""


@dataclass(frozen=True, eq=False)
class DeformedSurface(ExactSurface):
    """The search on a body in one of its shapes."""

    control_points: FloatArray
    """(m, 3) control points of this shape, body axes, length."""
    blocks: Blocks

    @cached_property
    def _surroundings(self) -> Surroundings:
        return surroundings_of(self.blocks, self.tables.leaves)

    def closest_from(self, starts: SurfacePlaces, p_B: FloatArray, out: Projection) -> None:
        """Write the closest points of p_B (k, 3) to `out` (k rows), from feet on another shape.

        `starts` (k rows) are these feet, of patch −1 for none. Rows whose foot near the start is
        not proved the closest are searched by branch and bound, so the result has the same proof as
        that of `closest`, in less time.
        """
        run_ranges(
            nearest_nb.project_from,
            len(p_B),
            MIN_POINTS,
            self.tables,
            self._surroundings,
            p_B,
            starts,
            out,
        )

    def closest(
        self, p_B: FloatArray, rows: IntArray, out: Projection, within: FloatArray | None = None
    ) -> None:
        """Write the closest points of p_B[rows] to the same rows of `out`, by branch and bound.

        `within` (len(rows),) are upper bounds of the distances, infinite if None.
        """
        if within is None:
            within = np.full(len(rows), np.inf)
        query = self.tables, p_B, rows, within, out
        run_ranges(nearest_nb.project_global, len(rows), MIN_POINTS, *query)

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Write feet of p_B to `out`, continued from `patch`, `uv` on another shape.

        Rows of patch −1 get their closest points. Whether feet are on the same branch is not
        proved: `before` is ignored, and no continued foot is certified.
        """
        super().track(p_B, patch, uv, out)

    def sides(self, p_B: FloatArray, rows: IntArray) -> Sides:
        """Return the sides of p_B[rows] that follow from boxes alone, one row for each of `rows`.

        A point beyond the box of a closed body is outside, with its distance from the nearest
        leaf's box as reach; all other sides are unknown (0, reach 0).
        """
        side, reach = np.zeros(len(rows), np.int8), np.zeros(len(rows))
        if self.closed:
            root, points = self.tables.tree[0], p_B[rows]
            beyond = ((points < root["low"]) | (points > root["high"])).any(axis=1)
            lengths = np.zeros(len(p_B))
            self.safe_distance(p_B, rows[beyond], lengths)
            side[beyond], reach[beyond] = 1, lengths[rows[beyond]]
            side[reach == 0.0] = 0
        return Sides(side, reach)

    def clear_paths(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Return False for each of `rows`: no path is known to be clear."""
        return np.zeros(len(rows), np.bool_)

    def last_crossings_from(
        self, before: DeformedSurface, a_B: FloatArray, b_B: FloatArray
    ) -> tuple[Hit, ByteArray]:
        """Return the last crossings of points from `a_B` to `b_B` (n, 3) while the surface moves.

        It moves from the shape `before` to this one; see `moving_nb`. Returns hits on this shape
        and senses, one row a point, as `last_crossings` does.
        """
        table, coefs = self.tables.elements
        change = (coefs - before.tables.elements.coefs).reshape(-1, 4)
        change[:, 3] = coefs.reshape(-1, 4)[:, 3]
        # In axes that move with the mean of the control points the displacements are smaller.
        displacements = self.control_points - before.control_points
        shift = displacements.mean(axis=0)
        table_before = before.tables.elements.table.copy()
        table_before["origin"] += shift
        surface = MovingSurface(
            self.tables,
            Elements(table_before, before.tables.elements.coefs),
            Elements(table, change.ravel()),
            float(row_lengths(displacements - shift).max(initial=0.0)),
        )

        def search(paths: Paths, out: Hit, verdict: FloatArray) -> None:
            start, end, between, _ = paths
            arguments = surface, start, end, between, out, verdict
            run_ranges(moving_nb.last_moving_crossings, len(start), MIN_POINTS, *arguments)

        return robust_last_crossings(search, a_B + shift, b_B)

    @property
    def contact_tables(self) -> None:
        """None: these tables are for fixed shapes."""

    def _lists(self, n_paths: int) -> PieceLists:
        return NO_LISTS


@dataclass(frozen=True, eq=False)
class Deformable:
    """The common part of all shapes of a body whose control points move."""

    name: str
    net: ControlNet
    rest: Tables
    refit: Refit
    closed: bool
    """Whether the surface has no border, in all shapes: joints stay joints."""
    slit: float
    """Largest distance of faces where they meet, length."""
    blocks: Blocks
    _last: list[DeformedSurface] = field(default_factory=list, repr=False)
    """Cache of the last two shapes: several contacts share one, and a step uses the one before."""

    def at(self, control_points: FloatArray) -> DeformedSurface:
        """Return the search on the shape of control points (m, 3), body axes, length.

        The last two shapes are cached: their control points return the same object. For others
        elements and hierarchy are computed anew.

        Raises
        ------
        GeometryError
            A shape that is a point, or so large or small that products of lengths are lost.
        """
        for shape in self._last:
            if np.array_equal(shape.control_points, control_points):
                return shape
        growth = extent_of(control_points) / extent_of(self.net.points)
        scale = self.rest.scale * growth
        check_extent(float(scale[0]), self.name)
        elements, trims = self.refit.at(control_points, growth), self.rest.trims
        hierarchy = build_hierarchy(elements, self.rest.grid, trims)
        tables = self.rest._replace(
            elements=elements,
            leaves=hierarchy.leaves,
            plates=hierarchy.plates,
            tree=hierarchy.tree,
            items=items_of(hierarchy, elements, trims, scale[1]),
            seeds=empty_seeds(hierarchy.tree),
            scale=scale,
        )
        shape = DeformedSurface(
            tables, self.closed, self.slit, read_only(control_points), self.blocks
        )
        self._last[:] = [shape, *self._last[:1]]
        return shape


def extent_of(points: FloatArray) -> float:
    """Return the diagonal of the box of points (m, 3), length."""
    return length(np.ptp(points, axis=0))


@once
def deformable_of(body: Faces) -> Deformable:
    """Return the common part of all shapes of `body`, computed at the first call.

    Joined sides must stay together under random displacements of the control points, by
    `JOINT_SHIFT` of the body's size: sides then farther apart than `JOINT_TOL` are refused.

    Raises
    ------
    GeometryError
        Patches that meet and would not stay together, because their control points along the joint
        are not the same or a face is trimmed there.
    """
    for k, edge in enumerate(body.edges):
        if len(edge.uses) > 1 and any(use.loop != UNTRIMMED for use in edge.uses):
            raise GeometryError(
                "a trimmed face that meets another would tear off as control points move",
                where=f"{body.name}, edge {k}",
                found=f"patches {', '.join(str(use.patch) for use in edge.uses)}",
                allowed="faces that meet along whole sides of their patches",
            )
    surface, net = exact_surface(body), net_of(body)
    rest = surface.tables
    refit = refit_of(body, net, rest.elements, rest.grid)
    # Sides that are joined without common control points come apart in a random shape.
    table, size, points = rest.elements.table, body.size, net.points
    noise = np.random.default_rng(0).standard_normal(points.shape)
    samples, _ = sides_nb.sample(refit.at(points + JOINT_SHIFT * size * noise, 1.0))
    is_linked = table["neighbour"] >= 0
    across = samples[table["neighbour"], table["neighbour_side"]]
    across = np.where(table["flip"][..., None, None] == 1, across[:, :, ::-1], across)
    is_apart = is_linked & (np.abs(samples - across).max(axis=(2, 3)) > JOINT_TOL * size)
    is_untrimmed = np.array([loops is None for loops in body.trims])[table["patch"]]
    is_apart |= (table["kind"] == SHARED) & is_untrimmed[:, None]
    if is_apart.any():
        e, side = np.argwhere(is_apart)[0].tolist()
        other = int(table["neighbour"][e, side])
        patches = [int(table["patch"][e])] + ([int(table["patch"][other])] if other >= 0 else [])
        raise GeometryError(
            "patches that meet would come apart: their control points there differ",
            where=f"{body.name}, patch {' and '.join(map(str, dict.fromkeys(patches)))}",
            allowed="the same degree, knots, control points and weights along the joint",
            remedy="Refine both alike: NurbsSurface.insert_knots, elevate",
        )
    blocks = blocks_of(refit.table)
    return Deformable(body.name, net, rest, refit, surface.closed, surface.slit, blocks)
