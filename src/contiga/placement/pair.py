"""Gaps between two parts as one of them moves along a line."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError
from contiga.masters.nearness import gaps_and_feet, lower_bounds, smallest_gap
from contiga.masters.protocol import Master
from contiga.placement.sample import SPACING, points_of, sharpened
from contiga.records import FloatArray, IndexArray
from contiga.slaves.slave import Slave
from contiga.statuses import Status

_MAX_STARTS = 12
"""Largest number of places from which the closest places of two bodies are sharpened."""


class _Direction(NamedTuple):
    """Gaps from points of one part to the other, which is a body."""

    part: Master | Slave
    """The part with the points."""
    master: Master
    """The body that gaps are measured from."""
    axis: FloatArray
    """(3,) direction in which the points move in the master's frame."""
    is_sheet: bool = False
    """Whether an open master is a sheet, so that points behind it are outside, too."""

    @property
    def depth(self) -> float | None:
        """Depth up to which points behind an open master are inside, length; None for a sheet."""
        return None if self.is_sheet else np.inf

    def gaps(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return gaps (n,) of points (n, 3), and which lie past a border, where gaps may jump.

        Gaps are negative inside. Points behind a face of an open body are inside at any depth,
        unless it is a sheet; past its border the gap is the distance.
        """
        gaps, feet = gaps_and_feet(self.master.surface, points, self.depth)
        return gaps, (feet.status != Status.OK) & (not self.master.closed)


class Pair:
    """Points on two parts, the first of which can be moved along a line, and their gaps.

    Between a body and a slave the gaps are those of the slave's active points. Between two bodies
    they are those of a sample of each to the other, to which `sharpen` adds the closest places.
    Past a border of an open body the distance counts, as in `contiga.masters.nearness`.

    Parameters
    ----------
    moved, other : bodies or slaves, at least one of them a body
    axis : (3,) unit vector of the line
    open_is_sheet : whether open bodies are sheets, with both sides free

    Raises
    ------
    InputError
        Two slaves: there is no surface to measure a gap from; or a slave without active points.
    """

    def __init__(
        self,
        moved: Master | Slave,
        other: Master | Slave,
        axis: FloatArray,
        *,
        open_is_sheet: bool = False,
    ) -> None:
        directions = []
        if not isinstance(other, Slave):
            is_sheet = open_is_sheet and not other.closed
            directions.append(_Direction(moved, other, axis, is_sheet))
        if not isinstance(moved, Slave):
            is_sheet = open_is_sheet and not moved.closed
            directions.append(_Direction(other, moved, -axis, is_sheet))
        if not directions:
            raise InputError(
                "two slaves have no gap: neither has a surface to measure from",
                where="on",
                found=other.name,
                allowed="a body, or a slave for a body to be placed on",
            )
        self._directions = directions
        points, bounds = [], []
        for direction in directions:
            p = points_of(direction.part)
            rows = np.arange(len(p), dtype=np.int32)
            bounds.append(lower_bounds(direction.master.surface, p, rows, direction.depth))
            points.append(p)
        self._points = np.concatenate(points)
        self._direction = np.repeat(np.arange(len(directions)), [len(p) for p in points])
        # Each point's last gap, or a lower bound of it, and the shift at which that holds.
        self._gap = np.concatenate(bounds)
        self._at = np.zeros(len(self._points))
        self._is_past_border = np.zeros(len(self._points), dtype=bool)
        sizes = [direction.master.size for direction in directions]
        self.size = min(sizes)
        """Size of the body, of the smaller one of two."""
        self.tolerance = max(1e-10 * min(sizes), 2e-12 * max(sizes))
        """Tolerance of gaps, length."""

    def gaps(self, rows: IndexArray, shift: float) -> FloatArray:
        """Return signed gaps (k,) of the points `rows` (k,) with the first part moved by `shift`.

        They are kept, with the shift and which are past a border, for later `bounds`.
        """
        gaps = np.empty(len(rows))
        self._at[rows] = shift
        for k, direction in enumerate(self._directions):
            indices = np.flatnonzero(self._direction[rows] == k)
            if len(indices):
                p = self._points[rows[indices]] + shift * direction.axis
                gaps[indices], self._is_past_border[rows[indices]] = direction.gaps(p)
        self._gap[rows] = gaps
        return gaps

    def bounds(self, shift: float) -> FloatArray:
        """Return lower bounds (n,) of all gaps at `shift`: the last ones less the motion since."""
        return self._gap - np.abs(self._at - shift)

    def smallest_gap(self, shift: float) -> float:
        """Return the smallest gap of all points; evaluate only those with a bound below it."""
        return smallest_gap(self.bounds(shift), lambda rows: self.gaps(rows, shift))[0]

    def sharpen(self, shift: float) -> bool:
        """Make the smallest gap at `shift` more exact; return whether it became smaller.

        Gaps of points past a border, whose bounds are not certain, are evaluated, and the closest
        places of two bodies added to the points. Changes up to a tenth of the tolerance are
        ignored.
        """
        previous = self.smallest_gap(shift)
        past = np.flatnonzero(self._is_past_border & (self._at != shift))
        if len(past):
            self.gaps(past, shift)
        if len(self._directions) > 1:
            self._add_closest_places(shift)
        return self.smallest_gap(shift) < previous - 0.1 * self.tolerance

    def _add_closest_places(self, shift: float) -> None:
        """Add local minima of the gap of two bodies, on each of both, to the points.

        They are searched from the points whose gap exceeds the smallest by up to the spacing of the
        sample: from at most `_MAX_STARTS` that are two spacings apart.
        """
        smallest = self.smallest_gap(shift)
        places = []
        for k, direction in enumerate(self._directions):
            assert not isinstance(direction.part, Slave)
            spacing = SPACING * direction.part.size
            limit = smallest + spacing
            rows = np.flatnonzero((self._direction == k) & (self.bounds(shift) <= limit))
            gaps = self.gaps(rows, shift)
            order = np.argsort(gaps, kind="stable")
            candidates = self._points[rows[order[gaps[order] <= limit]]]
            # Start from the nearest point, and from each next one that is not close to a start.
            starts = candidates[:0]
            while len(candidates) and len(starts) < _MAX_STARTS:
                starts = np.concatenate([starts, candidates[:1]])
                distance2 = np.square(candidates - candidates[0]).sum(axis=1)
                candidates = candidates[distance2 > (2.0 * spacing) ** 2]

            def gaps_to_master(p: FloatArray, direction: _Direction = direction) -> FloatArray:
                return direction.gaps(p + shift * direction.axis)[0]

            if len(starts):
                places.append((k, sharpened(direction.part, starts, gaps_to_master)))
        for k, points in places:
            n = len(points)
            self._points = np.concatenate([self._points, points])
            self._direction = np.concatenate([self._direction, np.full(n, k)])
            self._gap = np.concatenate([self._gap, np.full(n, -np.inf)])
            self._at = np.concatenate([self._at, np.zeros(n)])
            self._is_past_border = np.concatenate([self._is_past_border, np.zeros(n, dtype=bool)])
