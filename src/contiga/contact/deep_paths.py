"""Follow the paths of points inside a body: which wall pushes each at its end.

The nearest wall pushes as long as it is not opposite: its outward normal makes less than 160° with
the point's guard, the normal of the wall that was the nearest before. An opposite wall does not
take over, nor does a wall that has been nearer all along. The point is then held by the nearest
wall that does not face away from its guard, and the guard stays until the nearest wall is no longer
opposite. So the penetration is continuous: it is the distance to the whole surface, or to walls
that stay the same (`docs/theory.md`).

`deep_path_nb.next_question` decides from one answer to the next what to ask about each path. On
exact geometry a kernel answers at once; elsewhere the surface answers for all paths together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths
from contiga.arrays.threads import run_ranges
from contiga.contact.foot_rows import copy_feet
from contiga.contact.kernels import deep_path_nb
from contiga.contact.kernels.settle_nb import LOOK_SHARE, OPPOSITE_COSINE, OTHER_WALL_COSINE
from contiga.contact.search_records import BoolArray, Limits, Options
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.pointer_records import pass_by_pointer
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
    rows_of,
)

MIN_SHARE = 2.0**-6
"""Smallest initial share of a path that is followed at once."""
PATHS_PER_RANGE = 8
"""Paths that a thread follows at once."""


@pass_by_pointer
class DeepPaths(NamedTuple):
    """Paths of n points, one row each: progress, the present question and the answers."""

    start: FloatArray
    """(n, 3) body frame."""
    end: FloatArray
    """(n, 3) body frame."""
    length: FloatArray
    """(n,) length of the path."""
    end_feet: Projection
    """The closest points at the ends."""
    max_part: FloatArray
    """(n,) largest share of a path that is followed at once."""
    guard: FloatArray
    """(n, 3) zero without a guard."""
    depth: FloatArray
    """(n,) penetrations; −inf in a closed body where points entered."""
    is_opposed: BoolArray
    """(n,) whether another wall than the nearest pushes."""
    patch: IntArray
    """(n,) patch of the foot on the wall that pushes, −1 if unknown; `uv` (n, 2) its parameters."""
    uv: FloatArray
    progress: FloatArray
    """(n,) share of the path that is done."""
    part: FloatArray
    """(n,) length of the present part, as a share of the path."""
    target: FloatArray
    """(n,) end of the present part, as a share of the path."""
    n_parts: IntArray
    """(n,) number of parts and halvings so far."""
    n_tries: IntArray
    """(n,) number of minima that were tried in the present part."""
    is_restarted: BoolArray
    """(n,) whether the point jumped to a wall that it did not reach step by step."""
    outcome: ByteArray
    """(n,) outcome, as `deep_path_nb` numbers them."""
    question: ByteArray
    """(n,) present question, as `deep_path_nb` numbers them."""
    point: FloatArray
    """(n, 3) position that the question is about."""
    min_distance: FloatArray
    """(n,) lower bound of distances to feet that the guard allows."""
    max_distance: FloatArray
    """(n,) upper bound of these distances."""
    from_patch: IntArray
    """(n,) patch of the wall whose foot is asked for; `from_uv` (n, 2) its parameters."""
    from_uv: FloatArray
    nearest: Projection
    """Answers: the closest points."""
    other: Projection
    """Answers: the closest feet that the guard allows."""
    followed: Projection
    """Answers: feet on given walls."""
    rows: IntArray
    """(n,) 0 to n − 1."""
    unbounded: FloatArray
    """(n,) infinite upper bounds of the distances to the surface."""

    @property
    def feet(self) -> Projection:
        """The feet on the walls that push at the ends."""
        feet = Projection._make(column.copy() for column in self.end_feet)
        opposed = np.flatnonzero(self.is_opposed)
        copy_feet(feet, opposed, rows_of(self.other, opposed))
        return feet


class WallStates(NamedTuple):
    """Walls and guards of points at the starts of their paths, one row each; see `DeepPaths`."""

    guard: FloatArray
    depth: FloatArray
    is_opposed: BoolArray
    patch: IntArray
    uv: FloatArray


def follow_paths(
    surface: Surface,
    ends: tuple[FloatArray, FloatArray],
    walls: WallStates,
    nearest: Projection,
    options: Options,
) -> DeepPaths:
    """Follow the paths of points between `ends` = (start, end), (n, 3) each, body frame.

    `nearest` are the closest points at the end. In a closed body all paths stay inside. The result
    has the `outcome` of each path and the `feet` of the walls that push; a path that was given up,
    or left its wall, ends at its `progress`.
    """
    guard, depth, is_opposed, patch, uv = walls
    n, length = len(patch), row_lengths(ends[1] - ends[0])
    cosine = np.einsum("ij,ij->i", nearest.normal, guard)
    # A path that ends at another wall may have passed walls between, and so may a path at whose end
    # the nearest wall does not hold the point: follow these in short parts.
    changes_wall = is_opposed | (nearest.gap > 0.0) | (-nearest.gap < depth - length)
    changes_wall |= (cosine < OTHER_WALL_COSINE) & guard.any(axis=1)
    share = -LOOK_SHARE * nearest.gap / np.maximum(length, 1e-300)
    max_part = np.where(changes_wall, np.fmax(np.fmin(share, 1.0), MIN_SHARE), 1.0)
    paths = DeepPaths(
        start=np.ascontiguousarray(ends[0]),
        end=np.ascontiguousarray(ends[1]),
        length=length,
        end_feet=nearest,
        max_part=np.asarray(max_part),
        guard=guard.copy(),
        depth=depth.copy(),
        is_opposed=is_opposed.copy(),
        patch=patch.astype(np.int32),
        uv=uv.copy(),
        progress=np.zeros(n),
        part=np.array(max_part),
        target=np.zeros(n),
        n_parts=np.zeros(n, np.int32),
        n_tries=np.zeros(n, np.int32),
        is_restarted=np.zeros(n, np.bool_),
        outcome=np.zeros(n, np.int8),
        question=np.full(n, deep_path_nb.BEGIN_PART, np.int8),
        point=np.zeros((n, 3)),
        min_distance=np.zeros(n),
        max_distance=np.full(n, np.inf),
        from_patch=np.full(n, -1, np.int32),
        from_uv=np.zeros((n, 2)),
        nearest=empty_projection(n),
        other=empty_projection(n),
        followed=empty_projection(n),
        rows=np.arange(n, dtype=np.int32),
        unbounded=np.full(n, np.inf),
    )
    tables = surface.contact_tables if options.balls else None
    if tables is None:
        _follow_by_surface(surface, paths, options.limits)
    else:
        kernel = straight(deep_path_nb.follow_paths)
        run_ranges(kernel, n, PATHS_PER_RANGE, tables, paths, options.limits)
    return paths


def _follow_by_surface(surface: Surface, paths: DeepPaths, limits: Limits) -> None:
    """Follow all paths together to their ends, in place.

    In each round the surface answers one question per path that is not done.
    """
    next_questions = straight(deep_path_nb.next_questions)
    rows = paths.rows
    while len(rows):
        next_questions(paths, limits, rows)
        question = paths.question[rows]
        is_closest, is_done = question == deep_path_nb.CLOSEST, question == deep_path_nb.DONE
        is_facing = (question == deep_path_nb.FACING) | (question == deep_path_nb.FACING_ANYWHERE)
        closest, facing = rows[is_closest], rows[is_facing]
        if len(closest):
            surface.closest(paths.point, closest, paths.nearest)
        if len(facing):
            out = empty_projection(len(facing))
            places = SurfacePlaces(paths.patch[facing], paths.uv[facing])
            bounds = paths.min_distance[facing], paths.max_distance[facing]
            limit = FacingLimits(OPPOSITE_COSINE, *bounds)
            surface.closest_facing(paths.point[facing], paths.guard[facing], limit, places, out)
            copy_feet(paths.other, facing, out)
        tracked = rows[~is_closest & ~is_facing & ~is_done]
        if len(tracked):
            out = empty_projection(len(tracked))
            start = paths.from_patch[tracked], paths.from_uv[tracked]
            surface.track(paths.point[tracked], *start, out)
            copy_feet(paths.followed, tracked, out)
        rows = rows[~is_done]
