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

    def monotone(self) -> list[tuple[float, float, bool]]:
        """An arc cut where it turns from up to down: ends in y, and whether it lies right."""
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


class Profile:
    """Signed distance of (n, 2) points to what loops enclose, by the even-odd rule."""

    def __init__(self, loops: Sequence[Sequence[Piece]]) -> None:
        pieces = [piece for loop in loops for piece in loop]
        lines = [piece for piece in pieces if piece.centre is None]
        arcs = [piece for piece in pieces if piece.centre is not None]
        self.lines = [np.array([(x.a[k], x.b[k]) for x in lines]).reshape(-1, 2) for k in (0, 1)]
        self.arcs = np.array([(*x.centre, x.radius, x.start, x.sweep) for x in arcs])
        self.arcs = self.arcs.reshape(-1, 5)
        self.ends = np.array([end for x in arcs for end in (x.a, x.b)]).reshape(-1, 2)
        self.rises = np.array(
            [(*x.centre, x.radius, y0, y1, 1.0 if right else -1.0)
             for x in arcs for y0, y1, right in x.monotone()]
        ).reshape(-1, 6)  # fmt: skip

    def __call__(self, p: np.ndarray) -> np.ndarray:
        parts = np.array_split(p, len(p) // 5000 + 1)
        return np.concatenate([self._some(part[:, :1], part[:, 1:]) for part in parts])

    def _some(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        least, count = self._to_lines(x, y)
        cx, cy, radius, start, sweep = self.arcs.T
        angle = (np.arctan2(y - cy, x - cx) - start) % (2.0 * math.pi)
        off = np.abs(np.hypot(x - cx, y - cy) - radius)
        least = np.minimum(least, np.where(angle <= sweep, off, np.inf).min(axis=1, initial=np.inf))
        to_ends = np.hypot(x - self.ends[:, 0], y - self.ends[:, 1])
        least = np.minimum(least, to_ends.min(axis=1, initial=np.inf))
        cx, cy, radius, y0, y1, right = self.rises.T
        width = np.sqrt(np.maximum(radius**2 - (y - cy) ** 2, 0.0))
        count += (((y0 <= y) != (y1 <= y)) & (cx + right * width > x)).sum(axis=1)
        return np.where(count % 2 == 1, -least, least)

    def _to_lines(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance to the nearest line, and how many a ray along +x meets, ends half-open."""
        (ax, bx), (ay, by) = (ends.T for ends in self.lines)
        dx, dy = bx - ax, by - ay
        along = np.clip(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        off = np.hypot(x - ax - along * dx, y - ay - along * dy)
        crosses = (ay <= y) != (by <= y)
        share = (y - ay) / np.where(dy == 0.0, 1.0, dy)
        count = (crosses & (ax + share * dx > x)).sum(axis=1)
        return off.min(axis=1, initial=np.inf), count


def extruded(loops: Sequence[Sequence[Piece]], low: float, high: float) -> Field:
    """A profile in (x, y) given the extent low … high in z."""
    flat = Profile(loops)
    slab = between(2, low, high)
    return lambda p: np.maximum(flat(np.ascontiguousarray(p[:, :2])), slab(p))
