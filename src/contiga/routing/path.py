"""A taut path over bodies, and where it lies on them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points
from contiga.display import Displayed, Facts
from contiga.records import FloatArray, IndexArray
from contiga.routing.obstacles import Obstacles
from contiga.routing.taut import Tight

CONTACT_GAP = 1e-9
"""Gap up to which a point lies on a body, as a share of the length."""

MAX_MOVES = 30
"""Largest number of moves that take a point off the nearest of several bodies."""


class Wrap(NamedTuple):
    """A stretch of a path that lies on a body, to within a spacing of its points."""

    body: str
    """Name of the body."""
    start: float
    """Arc length where the path comes onto it."""
    end: float
    """Arc length where it lifts off."""
    angle: float
    """Radians that the path turns by: θ of T₂ = T₁ e^{μθ}."""
    first: FloatArray
    """(3,) point where the path comes onto it."""
    last: FloatArray
    """(3,) point where it lifts off."""


@dataclass(frozen=True, eq=False, repr=False)
class Path(Displayed):
    """A taut string: a polyline outside bodies, of locally shortest length.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
    >>> path = cg.route(ball, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.1])
    >>> [wrap.body for wrap in path.wraps], bool(abs(path.at([0.0])[0, 0] + 2.0) < 1e-12)
    (['ball'], True)
    """

    points: FloatArray
    """(n, 3) from start to end, length."""
    normal: FloatArray
    """(n, 3) unit normals of the body that the path lies on; in a crease the mean of both, and off
    all bodies the normal of the nearest."""
    body: IndexArray
    """(n,) index of the body that each point lies on, −1 where it lies on none."""
    over: Obstacles
    """The bodies."""

    @cached_property
    def arc(self) -> FloatArray:
        """Arc length (n,) of the points from the start."""
        chords = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(chords)])

    @property
    def length(self) -> float:
        """Length of the polyline: of a belt that is to lie here without force."""
        return float(self.arc[-1])

    @cached_property
    def turns(self) -> FloatArray:
        """The angles (n,), rad, by which the path turns at its points.

        They are angles between its chords, and at an end that leaves along a surface the angle
        between the surface and the chord.
        """
        chords = np.diff(self.points, axis=0)
        a, b = chords[:-1], chords[1:]
        sine = np.linalg.norm(np.cross(a, b), axis=1)
        inner = np.arctan2(sine, (a * b).sum(axis=1))
        directions = chords[[0, -1]] / np.linalg.norm(chords[[0, -1]], axis=1)[:, None]
        rise = (directions * self.normal[[0, -1]]).sum(axis=1) * [-1.0, 1.0]
        on_surface = (self.body[[0, -1]] >= 0) & (self.body[[1, -2]] == self.body[[0, -1]])
        first, last = np.where(on_surface, np.arcsin(np.clip(rise, 0.0, 1.0)), 0.0)
        return np.concatenate([[first], inner, [last]])

    @cached_property
    def wraps(self) -> tuple[Wrap, ...]:
        """Maximal runs of points on one body, in order, with the sum of their turns."""
        wraps = []
        for rows in np.split(np.arange(len(self.body)), np.flatnonzero(np.diff(self.body)) + 1):
            first, last = rows[0], rows[-1]
            if self.body[first] < 0:
                continue
            wraps.append(
                Wrap(
                    self.over.bodies[self.body[first]].name,
                    float(self.arc[first]),
                    float(self.arc[last]),
                    float(self.turns[rows].sum()),
                    self.points[first],
                    self.points[last],
                )
            )
        return tuple(wraps)

    @property
    def wrap_angle(self) -> float:
        """Angle, rad, by which the path turns in all."""
        return float(self.turns.sum())

    def at(self, arc: ArrayLike) -> FloatArray:
        """Return (k, 3) points at arc lengths (k,); beyond an end of the path that end."""
        return self._at_arc(self.points, arc)

    def normal_at(self, arc: ArrayLike) -> FloatArray:
        """Return (k, 3) unit normals at arc lengths (k,), interpolated between those of points."""
        normal = self._at_arc(self.normal, arc)
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    def outside(self, points: ArrayLike, gap: float = 0.0) -> FloatArray:
        """Return a copy of `points` (k, 3), moved away from the bodies to the distance `gap`.

        Only nearer points move, along the normal of the nearest body, at most `MAX_MOVES` times: in
        a crease narrower than `gap` they stay nearer. Points on chords of a path may be inside.
        """
        moved = as_points(points).copy()
        for _ in range(MAX_MOVES):  # in a crease a move off one body may lead into another
            nearest = self.over.clearances(moved)
            shortage = np.maximum(gap - nearest.gap, 0.0)
            if not shortage.any():
                break
            moved += shortage[:, None] * nearest.normal
        return moved

    def _at_arc(self, values: FloatArray, arc: ArrayLike) -> FloatArray:
        """Return `values` (n, 3) of the points interpolated at arc lengths (k,), as (k, 3)."""
        return np.stack([np.interp(np.asarray(arc), self.arc, x) for x in values.T], axis=1)

    def _facts(self) -> Facts:
        return [
            ("length", self.length),
            ("points", len(self.points)),
            ("wrap angle", self.wrap_angle),
            ("on", ", ".join(dict.fromkeys(wrap.body for wrap in self.wraps)) or "nothing"),
        ]


def path_of(obstacles: Obstacles, tight: Tight) -> Path:
    """Return the path of a string at rest, with the body that each point lies on.

    A point lies on a body if its gap is at most twice the rounding of edges plus `CONTACT_GAP` of
    the length; on several, it stays on the body of the point before, else the nearest counts.
    """
    feet = obstacles.feet(tight.points)
    gap = np.array([foot.gap for foot in feet])
    normal = np.array([foot.normal for foot in feet])
    length = float(np.linalg.norm(np.diff(tight.points, axis=0), axis=1).sum())
    touches = gap <= 2.0 * tight.rounding + CONTACT_GAP * length
    body = np.full(len(tight.points), -1)
    nearest = np.argmin(gap, axis=0)
    for i in range(len(body)):
        # In a crease a string lies on two bodies: the point stays on the body of the point before.
        previous = body[i - 1]
        if previous >= 0 and touches[previous, i]:
            body[i] = previous
        elif touches[nearest[i], i]:
            body[i] = nearest[i]
    counted = np.where(touches.any(axis=0), touches, np.arange(len(gap))[:, None] == nearest)
    mean = (counted[:, :, None] * normal).sum(axis=0)
    unit = mean / np.linalg.norm(mean, axis=1)[:, None]
    return Path(tight.points, unit, body, obstacles)
