"""Closed forms of solids: functions of (n, 3) points, negative inside, zero on the surface.

Every field changes by no more than the way a point goes, so that its size is a lower bound of the
distance to the surface. Unions, cuts and common parts are minima and maxima: exact in sign. Nothing
of contiga or OpenCASCADE is used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce

import numpy as np

Field = Callable[[np.ndarray], np.ndarray]


def norm(x: np.ndarray) -> np.ndarray:
    """Length of each row."""
    return np.sqrt(np.einsum("ij,ij->i", x, x))


def common(*fields: Field) -> Field:
    """What lies in all of them."""
    return lambda p: reduce(np.maximum, (f(p) for f in fields))


def union(*fields: Field) -> Field:
    """What lies in any of them."""
    return lambda p: reduce(np.minimum, (f(p) for f in fields))


def minus(field: Field, *tools: Field) -> Field:
    """`field` without the tools."""
    return lambda p: reduce(np.maximum, (-f(p) for f in tools), field(p))


def ball(centre: Sequence[float], radius: float) -> Field:
    """A ball."""
    return lambda p: norm(p - np.asarray(centre)) - radius


def box(low: Sequence[float], high: Sequence[float], radius: float = 0.0) -> Field:
    """A box with axes along x, y, z, all its edges rounded by `radius`; the true distance."""
    a, b = np.asarray(low, float), np.asarray(high, float)
    centre, half = 0.5 * (a + b), 0.5 * (b - a) - radius

    def field(p: np.ndarray) -> np.ndarray:
        q = np.abs(p - centre) - half
        return norm(np.maximum(q, 0.0)) + np.minimum(q.max(axis=1), 0.0) - radius

    return field


def tube(axis: int, radius: float, at: Sequence[float] = (0.0, 0.0)) -> Field:
    """An endless cylinder along x, y or z; `at` are its other two coordinates, in order."""
    others = [k for k in range(3) if k != axis]
    return lambda p: norm(p[:, others] - np.asarray(at)) - radius


def between(axis: int, low: float, high: float) -> Field:
    """A slab."""
    return lambda p: np.abs(p[:, axis] - 0.5 * (low + high)) - 0.5 * (high - low)


def cone(radius: float, height: float) -> Field:
    """A cone with its base in z = 0 and its apex at z = height."""
    slant = math.hypot(radius, height)

    def field(p: np.ndarray) -> np.ndarray:
        side = (norm(p[:, :2]) * height + (p[:, 2] - height) * radius) / slant
        return np.maximum(side, -p[:, 2])

    return field


def torus(major: float, minor: float) -> Field:
    """A ring about z; the true distance."""
    return lambda p: np.hypot(norm(p[:, :2]) - major, p[:, 2]) - minor


def scaled(field: Field, factor: float, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Field:
    """The field of the solid made `factor` times as large, then moved."""
    return lambda p: factor * field((p - np.asarray(shift)) / factor)


class Piece:
    """A line, or an arc of a circle, of a profile in the plane."""

    def __init__(
        self,
        a: Sequence[float],
        b: Sequence[float],
        centre: Sequence[float] | None = None,
        turns_left: bool = True,
    ) -> None:
        self.a, self.b = np.asarray(a, float), np.asarray(b, float)
        self.centre = None if centre is None else np.asarray(centre, float)
        if self.centre is not None:
            self.radius = 0.5 * (norm2(self.a - self.centre) + norm2(self.b - self.centre))
            ends = [math.atan2(*(e - self.centre)[::-1]) for e in (self.a, self.b)]
            if not turns_left:
                ends.reverse()
            self.start = ends[0]
            self.sweep = (ends[1] - ends[0]) % (2.0 * math.pi)
            self.turns_left = turns_left

    def middle(self) -> np.ndarray:
        """The point half way along."""
        if self.centre is None:
            return 0.5 * (self.a + self.b)
        angle = self.start + 0.5 * self.sweep
        return self.centre + self.radius * np.array([math.cos(angle), math.sin(angle)])

    def distance(self, p: np.ndarray) -> np.ndarray:
        """Distance of (n, 2) points."""
        if self.centre is None:
            d = self.b - self.a
            t = np.clip((p - self.a) @ d / (d @ d), 0.0, 1.0)
            return norm(p - self.a - t[:, None] * d)
        q = p - self.centre
        angle = (np.arctan2(q[:, 1], q[:, 0]) - self.start) % (2.0 * math.pi)
        ends = np.minimum(norm(p - self.a), norm(p - self.b))
        return np.where(angle <= self.sweep, np.abs(norm(q) - self.radius), ends)

    def crossings(self, p: np.ndarray) -> np.ndarray:
        """(n,) how often a ray from each point along +x meets it, ends counted half-open."""
        if self.centre is None:
            share = (p[:, 1] - self.a[1]) / (self.b[1] - self.a[1] or 1.0)
            crosses = (self.a[1] <= p[:, 1]) != (self.b[1] <= p[:, 1])
            return (crosses & (self.a[0] + share * (self.b[0] - self.a[0]) > p[:, 0])).astype(int)
        count = np.zeros(len(p), int)
        reach = self.radius**2 - (p[:, 1] - self.centre[1]) ** 2
        width = np.sqrt(np.maximum(reach, 0.0))
        for y0, y1, right in self._monotone():
            crosses = (y0 <= p[:, 1]) != (y1 <= p[:, 1])
            x = self.centre[0] + (width if right else -width)
            count += crosses & (x > p[:, 0])
        return count

    def _monotone(self) -> list[tuple[float, float, bool]]:
        """The arc cut where it turns from up to down: ends in y, and whether it lies right."""
        assert self.centre is not None
        first, last = (self.a, self.b) if self.turns_left else (self.b, self.a)
        quarter = 0.5 * math.pi
        turns = [
            k * math.pi + quarter
            for k in range(-4, 6)
            if self.start < k * math.pi + quarter < self.start + self.sweep
        ]
        marks = [self.start, *turns, self.start + self.sweep]
        y = [first[1], *(self.centre[1] + self.radius * math.sin(t) for t in turns), last[1]]
        return [
            (y[k], y[k + 1], math.cos(0.5 * (marks[k] + marks[k + 1])) > 0.0)
            for k in range(len(marks) - 1)
        ]


def norm2(x: np.ndarray) -> float:
    """Length of one vector."""
    return math.sqrt(float(x @ x))


def profile(loops: Sequence[Sequence[Piece]]) -> Callable[[np.ndarray], np.ndarray]:
    """Signed distance of (n, 2) points to what the loops enclose, by the even-odd rule."""
    pieces = [piece for loop in loops for piece in loop]

    def field(p: np.ndarray) -> np.ndarray:
        least = np.full(len(p), np.inf)
        count = np.zeros(len(p), int)
        for piece in pieces:
            np.minimum(least, piece.distance(p), out=least)
            count += piece.crossings(p)
        return np.where(count % 2 == 1, -least, least)

    return field


def extruded(loops: Sequence[Sequence[Piece]], low: float, high: float) -> Field:
    """A profile in (x, y) given the extent low … high in z."""
    flat = profile(loops)
    slab = between(2, low, high)
    return lambda p: np.maximum(flat(np.ascontiguousarray(p[:, :2])), slab(p))
