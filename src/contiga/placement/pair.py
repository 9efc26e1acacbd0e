"""Two parts, the gaps between them, and how these change as one of them is moved along a line."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError
from contiga.masters.nearness import gaps_of, least, lower_bounds
from contiga.masters.protocol import Master
from contiga.placement.sample import SPACING, points_of, sharpened
from contiga.records import FloatArray, IndexArray
from contiga.slaves.slave import Slave
from contiga.statuses import Status

_STARTS = 12
"""Places from which the closest ones of two bodies are sharpened, at most."""


class _Leg(NamedTuple):
    """Points of one part before the other, a body."""

    home: Master | Slave
    master: Master
    way: FloatArray
    """(3,) how the points move in the master's frame as the moved part does."""
    both: bool = False
    """Whether behind an open master is outside of it, too: a sheet, no border of a solid."""

    @property
    def depth(self) -> float | None:
        """Depth up to which points behind an open master are inside: see `nearness`."""
        return None if self.both else np.inf

    def gaps(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Gaps (n,) of points (n, 3), and which lie past a border: these may jump on their way.

        Behind a face of an open body is inside, however deep.
        """
        gaps, feet = gaps_of(self.master.surface, points, self.depth)
        return gaps, (feet.status != Status.OK) & (not self.master.closed)


class Pair:
    """Two parts, the first of which can be moved along a line.

    Between a body and a slave the gap is that of the slave's active points. Between two bodies it
    is that of a sample of each before the other, among which `sharpen` puts the closest places.
    Past a border of an open body the distance counts, as `contiga.masters.nearness` says.

    Parameters
    ----------
    moved, other : bodies or slaves, at least one of them a body
    way : (3,) unit vector of the line
    both : take open bodies for sheets, of which both sides are free

    Raises
    ------
    InputError
        Two slaves: there is no surface to measure a gap from.
    """

    def __init__(
        self, moved: Master | Slave, other: Master | Slave, way: FloatArray, *, both: bool = False
    ) -> None:
        legs = []
        if not isinstance(other, Slave):
            legs.append(_Leg(moved, other, way, both and not other.closed))
        if not isinstance(moved, Slave):
            legs.append(_Leg(other, moved, -way, both and not moved.closed))
        if not legs:
            raise InputError(
                "two slaves have no gap: neither has a surface to measure from",
                where="on",
                found=other.name,
                allowed="a body, or a slave for a body to be placed on",
            )
        self._legs = legs
        points = [points_of(leg.home) for leg in legs]
        self._points = np.concatenate(points)
        self._leg = np.repeat(np.arange(len(legs)), [len(rows) for rows in points])
        # What is known of each point: at which shift its gap is this, or at least this.
        self._gap = np.concatenate(
            [_bounds(leg, rows) for leg, rows in zip(legs, points, strict=True)]
        )
        self._at = np.zeros(len(self._points))
        self._past = np.zeros(len(self._points), dtype=bool)
        sizes = [leg.master.size for leg in legs]
        self.size = min(sizes)
        """Of the body, the smaller one of two."""
        self.tolerance = max(1e-10 * min(sizes), 2e-12 * max(sizes))
        """To which gaps are sought, length."""

    def gaps(self, rows: IndexArray, shift: float) -> FloatArray:
        """Return signed gaps (len(rows),) of the points `rows`, the first part moved by `shift`."""
        gaps = np.empty(len(rows))
        self._at[rows] = shift
        for k, leg in enumerate(self._legs):
            on_leg = np.flatnonzero(self._leg[rows] == k)
            if len(on_leg):
                at = self._points[rows[on_leg]] + shift * leg.way
                gaps[on_leg], self._past[rows[on_leg]] = leg.gaps(at)
        self._gap[rows] = gaps
        return gaps

    def bounds(self, shift: float) -> FloatArray:
        """Return lower bounds (n,) of each point's gap: the known one less the way since."""
        return self._gap - np.abs(self._at - shift)

    def least(self, shift: float) -> float:
        """The smallest gap of all points."""
        return least(self.bounds(shift), lambda rows: self.gaps(rows, shift))[0]

    def sharpen(self, shift: float) -> bool:
        """Add the points past borders and the closest places of two bodies.

        Returns whether the smallest gap became smaller.
        """
        before = self.least(shift)
        past = np.flatnonzero(self._past & (self._at != shift))
        if len(past):
            self.gaps(past, shift)
        if len(self._legs) > 1:
            self._add_closest(shift)
        return self.least(shift) < before - 0.1 * self.tolerance

    def _add_closest(self, shift: float) -> None:
        closest = self.least(shift)
        added = []
        for k, leg in enumerate(self._legs):
            assert not isinstance(leg.home, Slave)
            spacing = SPACING * leg.home.size
            near = np.flatnonzero((self._leg == k) & (self.bounds(shift) <= closest + spacing))
            gaps = self.gaps(near, shift)

            def before(at: FloatArray, leg: _Leg = leg) -> FloatArray:
                return leg.gaps(at + shift * leg.way)[0]

            order = np.argsort(gaps, kind="stable")
            starts = _apart(self._points[near[order[gaps[order] <= closest + spacing]]], spacing)
            if len(starts):
                added.append((k, sharpened(leg.home, starts, before)))
        for k, points in added:
            self._points = np.concatenate([self._points, points])
            self._leg = np.concatenate([self._leg, np.full(len(points), k)])
            self._gap = np.concatenate([self._gap, np.full(len(points), -np.inf)])
            self._at = np.concatenate([self._at, np.zeros(len(points))])
            self._past = np.concatenate([self._past, np.zeros(len(points), dtype=bool)])


def _bounds(leg: _Leg, points: FloatArray) -> FloatArray:
    """Return lower bounds (n,) of the gaps of points (n, 3) before any is computed."""
    rows = np.arange(len(points), dtype=np.int32)
    return lower_bounds(leg.master.surface, points, rows, leg.depth)


def _apart(points: FloatArray, spacing: float) -> FloatArray:
    """The first of `points` and those after it that are not near to one taken already."""
    taken = points[:0]
    while len(points) and len(taken) < _STARTS:
        taken = np.concatenate([taken, points[:1]])
        points = points[np.square(points - points[0]).sum(axis=1) > (2.0 * spacing) ** 2]
    return taken
