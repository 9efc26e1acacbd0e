"""Solids to wander through: of plane faces, whose walls are known one by one, and any other."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from tests.stress import parts, solids, truth
from tests.stress.fields import norm
from tests.stress.outlines import at
from tests.stress.rule import OPPOSITE, Rule, Was

import contiga as cg

RAY = np.array([0.3141592653589793, 0.2718281828459045, 0.9097])
"""A direction along no edge of any solid here."""


class Facet:
    """A polygon in space, convex or not, counter-clockwise as seen from outside."""

    def __init__(self, corners: np.ndarray) -> None:
        self.corners = np.asarray(corners, float)
        ahead = np.roll(self.corners, -1, axis=0)
        normal = np.cross(self.corners, ahead).sum(axis=0)
        self.normal = normal / np.sqrt(normal @ normal)
        self.level = float((self.corners @ self.normal).mean())
        self.sides = ahead - self.corners
        # Its plane seen along the axis in which it is widest.
        self.axes = np.delete(np.arange(3), np.abs(self.normal).argmax())

    def holds(self, p: np.ndarray) -> np.ndarray:
        """(n,) whether points of its plane lie within, by the even-odd rule."""
        x, y = p[:, self.axes].T
        odd = np.zeros(len(p), bool)
        for (ax, ay), (dx, dy) in zip(
            self.corners[:, self.axes], self.sides[:, self.axes], strict=True
        ):
            if dy != 0.0:
                odd ^= ((ay <= y) != (ay + dy <= y)) & (ax + (y - ay) / dy * dx > x)
        return odd

    def foot(self, p: np.ndarray) -> np.ndarray:
        """(n, 3) nearest place of the polygon."""
        flat = p - (p @ self.normal - self.level)[:, None] * self.normal
        rows = np.flatnonzero(~self.holds(flat))
        out, best = flat[rows], np.full(len(rows), np.inf)
        for a, d in zip(self.corners, self.sides, strict=True):
            share = np.clip((p[rows] - a) @ d / (d @ d), 0.0, 1.0)
            place = a + share[:, None] * d
            off = norm(p[rows] - place)
            nearer = off < best
            out[nearer], best[nearer] = place[nearer], off[nearer]
        flat[rows] = out
        return flat


class Planes:
    """A solid of plane faces."""

    def __init__(self, outlines: Sequence[np.ndarray]) -> None:
        self.facets = [Facet(corners) for corners in outlines]
        self.normals = np.array([facet.normal for facet in self.facets])
        self.levels = np.array([facet.level for facet in self.facets])
        # A face seen edge on is neither before nor behind: it is told by a hair.
        self.hair = 1e-12 * max(np.ptp(f.corners, axis=0).max() for f in self.facets)

    def inside(self, p: np.ndarray) -> np.ndarray:
        """A ray crosses the surface an odd number of times."""
        odd = np.zeros(len(p), bool)
        for facet in self.facets:
            way = (facet.level - p @ facet.normal) / (RAY @ facet.normal)
            odd ^= (way > 0.0) & facet.holds(p + way[:, None] * RAY)
        return odd

    def nearest(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """At a hollow edge the normal is the direction to it, in a face that is the same."""
        best, normal = np.full(len(p), np.inf), np.zeros((len(p), 3))
        for facet in self.facets:
            to = facet.foot(p) - p
            off = norm(to)
            rows = np.flatnonzero(off < best)
            best[rows] = off[rows]
            on = (off[rows] <= self.hair)[:, None]
            way = to[rows] / np.maximum(off[rows], self.hair)[:, None]
            normal[rows] = np.where(on, facet.normal, way)
        return best, normal

    def came(self, p: np.ndarray, before: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """The nearest face is the wall."""
        best, off = np.full(len(p), np.inf), np.zeros(len(p))
        for facet in self.facets:
            away = norm(facet.foot(p) - p)
            rows = np.flatnonzero(away < best)
            best[rows], off[rows] = away[rows], norm(facet.foot(before[rows]) - before[rows])
        return off >= depth - 1e3 * self.hair

    def behind(self, p: np.ndarray, guard: np.ndarray, least: np.ndarray, was: Was) -> np.ndarray:
        """Faces whose planes have the point before them are not asked. On an edge the normal is the
        way there."""
        before, depth = was
        best = np.full(len(p), np.inf)
        for facet in self.facets:
            rows = np.flatnonzero(
                (guard @ facet.normal > OPPOSITE) & (p @ facet.normal <= facet.level + self.hair)
            )
            to = facet.foot(p[rows]) - p[rows]
            off = norm(to)
            faces = (to * guard[rows]).sum(axis=1) > OPPOSITE * off - self.hair
            faces &= off >= least[rows]
            own = rows[faces]
            away = norm(facet.foot(before[own]) - before[own])
            faces[faces] = away >= depth[own] - 1e3 * self.hair
            best[rows] = np.where(faces, np.minimum(best[rows], off), best[rows])
        return best


def lofted(*loops: tuple[Sequence[Sequence[float]], float]) -> list[np.ndarray]:
    """Outlines of the solid between polygons (x, y), counter-clockwise, at rising heights z."""
    rings = [np.column_stack([xy, np.full(len(xy), z)]) for xy, z in loops]
    sides = [
        np.array([low[k], low[k - len(low) + 1], high[k - len(low) + 1], high[k]])
        for low, high in pairwise(rings)
        for k in range(len(low))
    ]
    return [rings[0][::-1], rings[-1], *sides]


def bar(xy: Sequence[Sequence[float]], low: float, high: float) -> list[np.ndarray]:
    """Outlines of a profile (x, y) given the extent low … high in z."""
    return lofted((xy, low), (xy, high))


def rectangle(x: float, y: float) -> list[tuple[float, float]]:
    """Corners of a rectangle about the origin, by half its sides."""
    return [(-x, -y), (x, -y), (x, y), (-x, y)]


def cog(count: int, root: float, tip: float) -> list[np.ndarray]:
    """A gear wheel with straight roots, flanks and tips."""
    pitch = 2.0 * np.pi / count
    marks = [(root, 0.0), (root, 0.4), (tip, 0.52), (tip, 0.88)]
    return [at(r, (k + share) * pitch) for k in range(count) for r, share in marks]


# A wedge of 30°: its walls face away from each other by 150°. The walls of the rib have a draft of
# 1.15° each, as a part that is to leave its mould: 177.7°.
PLANE: dict[str, list[np.ndarray]] = {
    "sharp block": bar(rectangle(20.0, 20.0), 0.0, 20.0),
    "wedge": bar([(0.0, 0.0), (60.0, 0.0), (60.0, 60.0 * np.tan(np.pi / 6.0))], 0.0, 30.0),
    "plate": bar(rectangle(20.0, 20.0), 0.0, 1.0),
    "T-section": bar(
        [(-3, 0), (3, 0), (3, 34), (20, 34), (20, 40), (-20, 40), (-20, 34), (-3, 34)], -15.0, 15.0
    ),
    "hexagonal bar": bar([at(10.0, k * np.pi / 3.0) for k in range(6)], -20.0, 20.0),
    "cog": bar(cog(10, 20.0, 26.0), -5.0, 5.0),
    "ribbed block": bar(
        [(-30, -20), (30, -20), (30, 0), (1.2, 0), (0.8, 20), (-0.8, 20), (-1.2, 0), (-30, 0)],
        -15.0,
        15.0,
    ),
    "chamfered block": lofted(
        (rectangle(20.0, 15.0), 0.0), (rectangle(20.0, 15.0), 12.0), (rectangle(17.0, 12.0), 15.0)
    ),
    "needle": lofted((rectangle(4.0, 4.0), 0.0), (rectangle(0.2, 0.2), 40.0)),
}


class Subject(NamedTuple):
    """A body, and what the rule says of it."""

    solid: solids.Solid
    rule: Rule


@cache
def plane_body(name: str) -> cg.Body:
    """One of `PLANE` as OpenCASCADE makes it and a file brings it."""
    shape = parts.polyhedron(PLANE[name])
    return cg.read_cad(solids.written(name, shape))


HOLLOW = ("cup", "link rod", "small link rod")
"""Whose closed forms are less than the distance beside the inner edges of their pockets."""


class Curved:
    """A solid with a closed form, or whose closest places contiga's own search tells."""

    def __init__(self, solid: solids.Solid) -> None:
        self.solid = solid
        self.exact = solid.field is not None and solid.name not in HOLLOW

    def inside(self, p: np.ndarray) -> np.ndarray:
        """By the closed form where there is one."""
        return truth.values(self.solid, p) < 0.0

    def nearest(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The distance falls along the normal and no faster."""
        if self.exact:
            field = self.solid.field
            return np.abs(field(p)), truth.gradient(field, p, 1e-7 * self.solid.size)
        feet = self.solid.body.project(p)
        far = np.abs(feet.gap)
        off = (feet.point - p) * -np.sign(feet.gap)[:, None]
        near = far < 1e-9 * self.solid.size
        return far, np.where(near[:, None], feet.normal, off / np.where(near, 1.0, far)[:, None])

    def came(self, p: np.ndarray, before: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Not known, so that `behind` is asked."""
        return np.zeros(len(p), bool)

    def behind(self, p: np.ndarray, guard: np.ndarray, least: np.ndarray, was: Was) -> np.ndarray:
        """Not known."""
        return np.full(len(p), np.nan)


@cache
def subject(name: str) -> Subject:
    """A solid of plane faces, or one of `solids`."""
    if name in PLANE:
        rule = Planes(PLANE[name])

        def field(p: np.ndarray) -> np.ndarray:
            return np.where(rule.inside(p), -1.0, 1.0) * rule.nearest(p)[0]

        return Subject(solids.Solid(name, plane_body(name), None, field), rule)
    solid = solids.solid(name)
    return Subject(solid, Curved(solid))


def names() -> list[str]:
    """All of them."""
    return [*PLANE, *solids.names()]
