"""Searches that exact bodies and triangles share, based on the searches of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points
from contiga.arrays.ordered import length
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray, Projection, RayHit
from contiga.statuses import Status

BALL_MARGIN = 1.0 + 1e-6
"""Ratio of the ball that rays are clipped to and the ball around the surface."""


class Queries:
    """Mixin for masters, which have `project`, `surface` and `bounds`."""

    project: Any
    surface: Any
    bounds: Any

    def track(self, points: ArrayLike, start: Projection) -> Projection:
        """Return feet of `points` (n, 3) continued from `start`, their feet one step ago.

        It is `project` with the mode "track" and has its errors.
        """
        feet: Projection = self.project(points, start=start, mode="track")
        return feet

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        """Return (n,) length from `points` (n, 3) to the surface, negative on the contact side.

        It is the `gap` of `project`; NaN where a point has no foot.
        """
        feet = self.project(points)
        return np.where(feet.patch < 0, np.nan, feet.gap)

    def ray(self, origins: ArrayLike, directions: ArrayLike) -> RayHit:
        """Return where rays hit the surface first, from whichever side.

        `first_hit` is for segments that enter. Rows without a hit have the status NO_HIT, the patch
        −1 and NaN; so have rays from origins that are not finite.

        Parameters
        ----------
        origins, directions : (n, 3), or (3,) for all; a direction may have any length

        Raises
        ------
        InputError
            Other shapes, or a direction that is zero or not finite.
        """
        starts, vectors = as_points(origins, "origins"), as_points(directions, "directions")
        if len(starts) != len(vectors) and 1 not in (len(starts), len(vectors)):
            raise InputError(
                "a ray has an origin and a direction",
                where="directions",
                found=vectors.shape,
                allowed=f"{starts.shape}, or (3,) for all",
            )
        size = np.abs(vectors).max(axis=1, initial=0.0)
        is_wrong = ~(np.isfinite(size) & (size > 0.0))
        if is_wrong.any():
            row = int(np.argmax(is_wrong))
            raise InputError(
                "a direction must be finite and not zero",
                where=f"directions[{row}]",
                found=vectors[row].tolist(),
            )
        vectors = vectors / size[:, None]
        starts, units = np.broadcast_arrays(
            starts, vectors / np.sqrt((vectors**2).sum(axis=1))[:, None]
        )
        # Rays are clipped to a ball around the surface.
        low, high = self.bounds()
        middle, reach = 0.5 * (low + high), 0.5 * BALL_MARGIN * length(high - low)
        middle_distance = ((middle - starts) * units).sum(axis=1)
        low_distance = np.maximum(middle_distance - reach, 0.0)
        high_distance = middle_distance + reach
        is_ahead = np.isfinite(high_distance) & (high_distance > 0.0)
        rows = np.flatnonzero(is_ahead).astype(np.int32)
        # Segments run back to the start of their rays: their last crossing is the first hit.
        with np.errstate(invalid="ignore"):
            begins = starts + high_distance[:, None] * units
            ends = starts + low_distance[:, None] * units
        crossings, sense = self.surface.last_crossings(begins, ends, rows)
        crosses = sense != 0
        hit, fraction = rows[crosses], crossings.fraction[crosses]
        n = len(starts)
        out = RayHit(
            distance=np.full(n, np.nan),
            patch=np.full(n, -1, np.int32),
            uv=np.full((n, 2), np.nan),
            point=np.full((n, 3), np.nan),
            normal=np.full((n, 3), np.nan),
            status=np.full(n, Status.NO_HIT, np.int8),
        )
        back = low_distance[hit] - high_distance[hit]
        out.distance[hit] = high_distance[hit] + fraction * back
        for name in ("patch", "uv", "point", "status"):
            getattr(out, name)[hit] = getattr(crossings, name)[crosses]
        out.normal[hit] = self._normals_at(out.patch[hit], out.uv[hit])
        return out

    def _normals_at(self, patch: IntArray, uv: FloatArray) -> FloatArray:
        """Return (k, 3) unit normals at places (patch, uv)."""
        raise NotImplementedError
