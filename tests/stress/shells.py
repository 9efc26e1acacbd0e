"""Open shells of plane, cylindrical and spherical faces, and their feet in closed form.

A foot of a point is a local minimum of the distance along the shell. It lies within a face, on an
edge that two faces share, or at a corner round which faces close; minima on the border are known by
their distance only. Arcs lie in planes of constant z. Nothing of contiga's search is used.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from tests.stress.fields import norm

import contiga as cg

HAIR = 1e-12
"""Places closer than this are the same; shells are about as large as one."""

Z = np.array([0.0, 0.0, 1.0])
Point = Sequence[float]


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of rows."""
    return np.asarray(np.einsum("ij,ij->i", np.atleast_2d(a), np.atleast_2d(b)))


def unit(x: np.ndarray) -> np.ndarray:
    """Rows of length one; zero where they are."""
    return np.asarray(x / np.maximum(norm(x), 1e-300)[:, None])


class Segment(NamedTuple):
    """A straight edge."""

    a: np.ndarray
    b: np.ndarray

    def foot(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) nearest places, and (n,) whether they are not its ends."""
        d = self.b - self.a
        share = (p - self.a) @ d / (d @ d)
        within = (share > 0.0) & (share < 1.0)
        return self.a + np.clip(share, 0.0, 1.0)[:, None] * d, within

    @property
    def key(self) -> object:
        """The same for the same edge, whichever way it runs."""
        return frozenset(_rounded(x) for x in (self.a, self.b)), _rounded(0.5 * (self.a + self.b))

    @property
    def ends(self) -> tuple[np.ndarray, ...]:
        """Where it ends."""
        return self.a, self.b


class Arc(NamedTuple):
    """An arc about z."""

    centre: np.ndarray
    radius: float
    start: float = 0.0
    sweep: float = 2.0 * np.pi

    def place(self, angle: np.ndarray) -> np.ndarray:
        """(n, 3) places at angles (n,)."""
        out = np.zeros((len(angle), 3))
        out[:, 0], out[:, 1] = self.radius * np.cos(angle), self.radius * np.sin(angle)
        return out + self.centre

    def foot(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As of a segment."""
        q = p - self.centre
        angle = (np.arctan2(q[:, 1], q[:, 0]) - self.start) % (2.0 * np.pi)
        within = angle < self.sweep
        past = angle - self.sweep > 0.5 * (2.0 * np.pi - self.sweep)
        angle = np.where(within, angle, np.where(past, 0.0, self.sweep))
        return self.place(self.start + angle), within

    @property
    def key(self) -> object:
        """As of a segment."""
        if self.sweep == 2.0 * np.pi:
            return _rounded(self.centre), round(self.radius, 9)
        a, middle, b = self.place(self.start + self.sweep * np.array([0.0, 0.5, 1.0]))
        return frozenset((_rounded(a), _rounded(b))), _rounded(middle)

    @property
    def ends(self) -> tuple[np.ndarray, ...]:
        """None of a circle."""
        if self.sweep == 2.0 * np.pi:
            return ()
        return tuple(self.place(self.start + self.sweep * np.array([0.0, 1.0])))


Curve = Segment | Arc
Rows = Callable[[np.ndarray], np.ndarray]


def _rounded(x: np.ndarray) -> tuple[float, ...]:
    return tuple(np.round(x, 9) + 0.0)


def _same(direction: np.ndarray) -> Rows:
    return lambda e: np.broadcast_to(direction, e.shape)


class Side(NamedTuple):
    """An edge as one of its faces has it: which way lies the face, and its outward normal there."""

    curve: Curve
    into: Rows
    normal: Rows


class Corner(NamedTuple):
    """A corner of a face: the directions of its edges there, unit vectors, and its normal."""

    place: np.ndarray
    first: np.ndarray
    second: np.ndarray
    normal: np.ndarray


class Minima(NamedTuple):
    """The feet of n points on a face, edge or corner, (n,), or on m of them, (n, m)."""

    distance: np.ndarray
    """Infinite where there is none."""
    normal: np.ndarray
    """(…, 3) outward, of length one; on edges and at corners in the line to the point."""
    behind: np.ndarray
    """Whether the point is behind."""


class Crossings(NamedTuple):
    """Where n paths pass through a face, (n, k)."""

    share: np.ndarray
    """Of the path; NaN where there is no such crossing."""
    normal: np.ndarray
    """(n, k, 3) outward."""


def _least(p: np.ndarray, places: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """The least of how far points (n, 3) lie along ways (..., k, 3) from places (..., k, 3)."""
    along = np.tensordot(p, ways, axes=(1, -1)) - (places * ways).sum(axis=-1)
    return np.asarray(along.min(axis=-1))


class Polygon:
    """A convex plane face, counter-clockwise seen from its free side, with a round hole if need be.

    `hole` is (centre, radius), in a plane of constant z.
    """

    def __init__(self, corners: Sequence[Point], hole: tuple[Point, float] | None = None) -> None:
        self.corners = np.asarray(corners, float)
        self.hole = None if hole is None else (np.asarray(hole[0], float), float(hole[1]))
        ahead = np.roll(self.corners, -1, axis=0)
        self.sides = unit(ahead - self.corners)
        self.normal = unit(np.cross(self.corners, ahead).sum(axis=0)[None])[0]
        self.level = float((self.corners @ self.normal).mean())
        self.into = np.cross(self.normal, self.sides)

    def _holds(self, p: np.ndarray) -> np.ndarray:
        within = _least(p, self.corners, self.into) >= -HAIR
        if self.hole is not None:
            flat = p - (p @ self.normal - self.level)[:, None] * self.normal
            within &= norm(flat - self.hole[0]) >= self.hole[1]
        return np.asarray(within)

    def minima(self, p: np.ndarray) -> Minima:
        """Where the perpendicular meets it."""
        off = p @ self.normal - self.level
        distance = np.where(self._holds(p), np.abs(off), np.inf)
        return Minima(distance, np.broadcast_to(self.normal, p.shape), off <= 0.0)

    def crossings(self, a: np.ndarray, b: np.ndarray) -> Crossings:
        """One at most."""
        before, after = a @ self.normal - self.level, b @ self.normal - self.level
        through = (before > 0.0) != (after > 0.0)
        share = np.where(through, before / np.where(through, before - after, 1.0), np.nan)
        at = a + share[:, None] * (b - a)
        share[~self._holds(np.nan_to_num(at))] = np.nan
        normal = np.broadcast_to(self.normal, a.shape)
        return Crossings(share[:, None], normal[:, None])

    def outline(self) -> list[Side]:
        """Its sides, and the rim of its hole."""
        ahead = np.roll(self.corners, -1, axis=0)
        sides = [
            Side(Segment(a, b), _same(into), _same(self.normal))
            for a, b, into in zip(self.corners, ahead, self.into, strict=True)
        ]
        if self.hole is not None:
            centre, radius = self.hole
            sides.append(Side(Arc(centre, radius), lambda e: unit(e - centre), _same(self.normal)))
        return sides

    def angles(self) -> list[Corner]:
        """Its corners."""
        rows = zip(self.corners, self.sides, -np.roll(self.sides, 1, axis=0), strict=True)
        return [Corner(*row, self.normal) for row in rows]

    def patch(self) -> cg.NurbsSurface:
        """As a bilinear patch."""
        a, b, c, d = self.corners
        return cg.shapes.bilinear(a, b, d, c)

    def trim(self) -> list[list[cg.NurbsCurve]] | None:
        """Its hole in the parameters of a rectangle."""
        if self.hole is None:
            return None
        a, b, _, d = self.corners
        u, v = ((self.hole[0] - a) @ (x - a) / ((x - a) @ (x - a)) for x in (b, d))
        wide, long = norm(np.array([b - a, d - a]))
        assert abs(wide - long) < HAIR
        square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], float)
        outer = [cg.shapes.line(*square[k : k + 2]) for k in range(4)]
        radius = self.hole[1] / wide
        return [outer, [cg.shapes.circle(radius=radius, centre=(u, v, 0.0)).reversed()]]


class Disc:
    """A round face in a plane of constant z, `up` or facing down."""

    def __init__(self, centre: Point, radius: float, up: bool = True) -> None:
        self.centre, self.radius = np.asarray(centre, float), radius
        self.normal = Z if up else -Z

    def minima(self, p: np.ndarray) -> Minima:
        """Where the perpendicular meets it."""
        off = (p - self.centre) @ self.normal
        within = np.hypot(*(p - self.centre)[:, :2].T) <= self.radius
        distance = np.where(within, np.abs(off), np.inf)
        return Minima(distance, np.broadcast_to(self.normal, p.shape), off <= 0.0)

    def crossings(self, a: np.ndarray, b: np.ndarray) -> Crossings:
        """One at most."""
        before, after = ((x - self.centre) @ self.normal for x in (a, b))
        through = (before > 0.0) != (after > 0.0)
        share = np.where(through, before / np.where(through, before - after, 1.0), np.nan)
        at = a + share[:, None] * (b - a) - self.centre
        share[~(np.hypot(at[:, 0], at[:, 1]) <= self.radius)] = np.nan
        return Crossings(share[:, None], np.broadcast_to(self.normal, a.shape)[:, None])

    def outline(self) -> list[Side]:
        """Its rim."""
        rim = Arc(self.centre, self.radius)
        return [Side(rim, lambda e: unit(self.centre - e), _same(self.normal))]

    def angles(self) -> list[Corner]:
        """None."""
        return []

    def patch(self) -> cg.NurbsSurface:
        """As a patch with a pole."""
        axis = tuple(self.normal)
        return cg.shapes.disc(radius=self.radius, centre=self.centre, axis=axis)

    def trim(self) -> None:
        """None."""


class Cylinder:
    """Part of a cylinder about z, from z = low to z = high and over a range of angles.

    Its normals point away from its axis if it bulges, else to it.
    """

    def __init__(
        self,
        centre: Point,
        radius: float,
        angles: tuple[float, float] = (0.0, 2.0 * np.pi),
        ends: tuple[float, float] = (0.0, 1.0),
        bulges: bool = True,
    ) -> None:
        self.centre = np.array([*centre[:2], 0.0])
        self.radius, self.start, self.sweep = radius, angles[0], angles[1] - angles[0]
        self.low, self.high, self.sign = *ends, 1.0 if bulges else -1.0

    def _holds(self, q: np.ndarray) -> np.ndarray:
        angle = (np.arctan2(q[:, 1], q[:, 0]) - self.start) % (2.0 * np.pi)
        return (angle <= self.sweep) & (q[:, 2] >= self.low) & (q[:, 2] <= self.high)

    def _out(self, e: np.ndarray) -> np.ndarray:
        return unit((e - self.centre) * [1.0, 1.0, 0.0])

    def minima(self, p: np.ndarray) -> Minima:
        """In the direction away from its axis."""
        q = p - self.centre
        off = np.hypot(q[:, 0], q[:, 1]) - self.radius
        distance = np.where(self._holds(q), np.abs(off), np.inf)
        return Minima(distance, self.sign * self._out(p), self.sign * off <= 0.0)

    def crossings(self, a: np.ndarray, b: np.ndarray) -> Crossings:
        """Two at most."""
        q, d = (a - self.centre)[:, :2], (b - a)[:, :2]
        share = _roots(q, d, self.radius)
        at = a[:, None] + share[..., None] * (b - a)[:, None]
        flat = np.nan_to_num(at.reshape(-1, 3) - self.centre)
        share[~self._holds(flat).reshape(share.shape)] = np.nan
        return Crossings(share, self.sign * self._out(at.reshape(-1, 3)).reshape(at.shape))

    def outline(self) -> list[Side]:
        """Two arcs, and two straight edges unless it goes round."""
        sides = [
            Side(
                Arc(self.centre + z * Z, self.radius, self.start, self.sweep),
                _same(into * Z),
                lambda e: self.sign * self._out(e),
            )
            for z, into in ((self.low, 1.0), (self.high, -1.0))
        ]
        if self.sweep < 2.0 * np.pi:
            for corner in self.angles()[:2]:
                ends = corner.place, corner.place + (self.high - self.low) * Z
                sides.append(Side(Segment(*ends), _same(corner.first), _same(corner.normal)))
        return sides

    def angles(self) -> list[Corner]:
        """Four, the lower ones first."""
        if self.sweep == 2.0 * np.pi:
            return []
        found = []
        for z, up in ((self.low, Z), (self.high, -Z)):
            for angle, way in ((self.start, 1.0), (self.start + self.sweep, -1.0)):
                out = np.array([np.cos(angle), np.sin(angle), 0.0])
                along = way * np.array([-np.sin(angle), np.cos(angle), 0.0])
                place = self.centre + self.radius * out + z * Z
                found.append(Corner(place, along, up, self.sign * out))
        return found

    def patch(self) -> cg.NurbsSurface:
        """As an extruded arc."""
        arc = cg.shapes.arc(
            radius=self.radius,
            start=self.start,
            end=self.start + self.sweep,
            centre=self.centre + self.low * Z,
        )
        patch = cg.shapes.extruded(arc, (self.high - self.low) * Z)
        return patch if self.sign > 0.0 else patch.flipped()

    def trim(self) -> None:
        """None."""


def _roots(q: np.ndarray, d: np.ndarray, radius: float) -> np.ndarray:
    """(n, 2) shares in [0, 1] at which q + share d is `radius` from the origin, else NaN."""
    a, b, c = dot(d, d), dot(q, d), dot(q, q) - radius**2
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        far = -(b + np.where(b > 0.0, root, -root))
        share = np.stack([far / a, c / far], axis=1)
        share[~((share >= 0.0) & (share <= 1.0))] = np.nan
    return share


class Ball:
    """The part of a sphere from one latitude to another, radians; `bulges` as of a cylinder."""

    def __init__(
        self,
        centre: Point,
        radius: float,
        latitudes: tuple[float, float] = (-0.5 * np.pi, 0.5 * np.pi),
        bulges: bool = True,
    ) -> None:
        self.centre, self.radius = np.asarray(centre, float), radius
        self.latitudes, self.sign = latitudes, 1.0 if bulges else -1.0
        self.low, self.high = (
            -2.0 if latitudes[0] == -0.5 * np.pi else np.sin(latitudes[0]),
            2.0 if latitudes[1] == 0.5 * np.pi else np.sin(latitudes[1]),
        )

    def minima(self, p: np.ndarray) -> Minima:
        """In the direction away from its centre."""
        out, off = unit(p - self.centre), norm(p - self.centre) - self.radius
        within = (out[:, 2] >= self.low) & (out[:, 2] <= self.high)
        distance = np.where(within, np.abs(off), np.inf)
        return Minima(distance, self.sign * out, self.sign * off <= 0.0)

    def crossings(self, a: np.ndarray, b: np.ndarray) -> Crossings:
        """Two at most."""
        share = _roots(a - self.centre, b - a, self.radius)
        at = a[:, None] + share[..., None] * (b - a)[:, None]
        out = (at - self.centre) / self.radius
        share[~((out[..., 2] >= self.low) & (out[..., 2] <= self.high))] = np.nan
        return Crossings(share, self.sign * out)

    def outline(self) -> list[Side]:
        """Its parallels."""
        sides = []
        for level, way in ((self.low, 1.0), (self.high, -1.0)):
            if abs(level) <= 1.0:
                rim = Arc(
                    self.centre + self.radius * level * Z, self.radius * np.sqrt(1.0 - level**2)
                )

                def into(e: np.ndarray, way: float = way) -> np.ndarray:
                    out = (e - self.centre) / self.radius
                    return way * unit(Z - out[:, 2:] * out)

                sides.append(Side(rim, into, lambda e: self.sign * unit(e - self.centre)))
        return sides

    def angles(self) -> list[Corner]:
        """None."""
        return []

    def patch(self) -> cg.NurbsSurface:
        """As a revolved arc."""
        arc = cg.shapes.arc(radius=self.radius, start=self.latitudes[0], end=self.latitudes[1])
        net = arc.control_points[:, [0, 2, 1]].copy()
        net[np.abs(net) < 1e-15 * self.radius] = 0.0
        meridian = cg.NurbsCurve(2, arc.knots, net, arc.weights)
        patch = cg.shapes.revolved(meridian).translated(self.centre)
        return patch if self.sign > 0.0 else patch.flipped()

    def trim(self) -> None:
        """None."""


Face = Polygon | Disc | Cylinder | Ball


class Planes:
    """Polygons without holes."""

    def __init__(self, faces: Sequence[Polygon]) -> None:
        most = max(len(face.corners) for face in faces)
        self.normal = np.array([face.normal for face in faces])
        self.level = np.array([face.level for face in faces])
        self.corners, self.into = (
            np.array([np.resize(getattr(face, name), (most, 3)) for face in faces])
            for name in ("corners", "into")
        )

    def minima(self, p: np.ndarray) -> Minima:
        """Of all of them, (n, m)."""
        off = p @ self.normal.T - self.level
        within = _least(p, self.corners, self.into) >= -HAIR
        normal = np.broadcast_to(self.normal, (*off.shape, 3))
        return Minima(np.where(within, np.abs(off), np.inf), normal, off <= 0.0)


class StraightEdges:
    """Straight edges that two faces share."""

    def __init__(self, edges: Sequence[tuple[Side, Side]]) -> None:
        curves = [sides[0].curve for sides in edges]
        self.a, self.b = (np.array([curve.ends[k] for curve in curves]) for k in (0, 1))
        self.way = self.b - self.a
        self.into = np.array([[side.into(self.a[:1])[0] for side in sides] for sides in edges])
        self.normal = np.array([sum(side.normal(self.a[:1])[0] for side in e) for e in edges])

    def minima(self, p: np.ndarray) -> Minima:
        """Where neither face is nearer."""
        share = p @ self.way.T - (self.a * self.way).sum(axis=1)
        share /= (self.way**2).sum(axis=1)
        within = (share > 0.0) & (share < 1.0)
        within &= _least(p, self.a[:, None], -self.into) >= 0.0
        out = p[:, None] - self.a - share[..., None] * self.way
        return _of_places(out, within, self.normal)


class RoundEdge:
    """An arc that two faces share."""

    def __init__(self, first: Side, second: Side) -> None:
        self.curve, self.sides = first.curve, (first, second)

    def minima(self, p: np.ndarray) -> Minima:
        """Where neither face is nearer."""
        e, within = self.curve.foot(p)
        out, normal = p - e, np.zeros_like(p)
        for side in self.sides:
            within &= dot(out, side.into(e)) <= 0.0
            normal += side.normal(e)
        return _of_places(out, within, normal)


class Vertices:
    """Corners round which faces close."""

    def __init__(self, fans: Sequence[Sequence[Corner]]) -> None:
        self.place = np.array([fan[0].place for fan in fans])
        most = 2 * max(len(fan) for fan in fans)
        ways = [[way for corner in fan for way in (corner.first, corner.second)] for fan in fans]
        self.ways = np.array([np.resize(own, (most, 3)) for own in ways])
        self.normal = np.array(
            [sum(np.arccos(np.clip(c.first @ c.second, -1.0, 1.0)) * c.normal for c in fan)
             for fan in fans]
        )  # fmt: skip

    def minima(self, p: np.ndarray) -> Minima:
        """Where no face is nearer."""
        within = _least(p, self.place[:, None], -self.ways) >= 0.0
        return _of_places(p[:, None] - self.place, within, self.normal)


def _of_places(out: np.ndarray, within: np.ndarray, normal: np.ndarray) -> Minima:
    behind = (out * normal).sum(axis=-1) <= 0.0
    far = np.sqrt((out**2).sum(axis=-1))
    way = np.where(behind, -1.0, 1.0) / np.maximum(far, 1e-300)
    return Minima(np.where(within, far, np.inf), way[..., None] * out, behind)


class Feet(NamedTuple):
    """All feet of n points, (n, m), as of `Minima`."""

    distance: np.ndarray
    normal: np.ndarray
    """(n, m, 3)"""
    behind: np.ndarray
    border: np.ndarray
    """(n,) distance to the border."""


class Entry(NamedTuple):
    """The last crossings of n paths."""

    share: np.ndarray
    """Of the path; NaN without."""
    normal: np.ndarray
    """(n, 3) outward."""
    enters: np.ndarray
    """(n,) whether it is from the free side."""


class Shell:
    """Faces, and what follows from them. Edges of faces that are the same are joined."""

    def __init__(self, faces: Sequence[Face]) -> None:
        self.faces = list(faces)
        uses: dict[object, list[Side]] = defaultdict(list)
        for face in self.faces:
            for side in face.outline():
                uses[side.curve.key].append(side)
        joined = [(sides[0], sides[1]) for sides in uses.values() if len(sides) == 2]
        self.borders = [sides[0].curve for sides in uses.values() if len(sides) == 1]
        assert all(len(sides) < 3 for sides in uses.values())
        ends = {_rounded(end) for curve in self.borders for end in curve.ends}
        fans: dict[object, list[Corner]] = defaultdict(list)
        for face in self.faces:
            for corner in face.angles():
                fans[_rounded(corner.place)].append(corner)
        closed = [fan for key, fan in fans.items() if key not in ends]
        plane = [face for face in self.faces if isinstance(face, Polygon) and face.hole is None]
        straight = [sides for sides in joined if isinstance(sides[0].curve, Segment)]
        self._own: list[Any] = [face for face in self.faces if face not in plane]
        self._own += [RoundEdge(*sides) for sides in joined if isinstance(sides[0].curve, Arc)]
        self._own += [Planes(plane)] if plane else []
        self._own += [StraightEdges(straight)] if straight else []
        self._own += [Vertices(closed)] if closed else []

    @property
    def closed(self) -> bool:
        """Whether it has no border."""
        return not self.borders

    def border(self, p: np.ndarray) -> np.ndarray:
        """(n,) distance to the border, infinite without one."""
        off = np.full(len(p), np.inf)
        for curve in self.borders:
            np.minimum(off, norm(p - curve.foot(p)[0]), out=off)
        return off

    def feet(self, p: np.ndarray) -> Feet:
        """All feet of n points."""
        found = [item.minima(p) for item in self._own]
        distance = [np.reshape(own.distance, (len(p), -1)) for own in found]
        normal = [np.reshape(own.normal, (len(p), -1, 3)) for own in found]
        behind = [np.reshape(own.behind, (len(p), -1)) for own in found]
        return Feet(
            np.concatenate(distance, axis=1),
            np.concatenate(normal, axis=1),
            np.concatenate(behind, axis=1),
            self.border(p),
        )

    def nearest(self, p: np.ndarray) -> np.ndarray:
        """(n,) distance to all of it."""
        feet = self.feet(p)
        return np.minimum(feet.distance.min(axis=1), feet.border)

    def last_crossing(self, a: np.ndarray, b: np.ndarray) -> Entry:
        """The last crossing of straight paths."""
        found = [face.crossings(a, b) for face in self.faces]
        share = np.concatenate([each.share for each in found], axis=1)
        normal = np.concatenate([each.normal for each in found], axis=1)
        last = np.nan_to_num(share, nan=-1.0).argmax(axis=1)
        rows = np.arange(len(a))
        own = normal[rows, last]
        return Entry(share[rows, last], own, dot(own, b - a) < 0.0)

    def body(self, name: str = "shell") -> cg.Body:
        """Its faces as patches."""
        trims = [face.trim() for face in self.faces]
        patches = [face.patch() for face in self.faces]
        return cg.Body(patches, name=name, trims=trims if any(trims) else None)

    def mesh(self, name: str = "shell") -> cg.TriMesh:
        """Its faces, all of them polygons, as triangles."""
        corners: list[np.ndarray] = []
        known: dict[object, int] = {}
        triangles = []
        for face in self.faces:
            assert isinstance(face, Polygon)
            assert face.hole is None
            own = []
            for corner in face.corners:
                own.append(known.setdefault(_rounded(corner), len(corners)))
                if own[-1] == len(corners):
                    corners.append(corner)
            triangles += [(own[0], own[k], own[k + 1]) for k in range(1, len(own) - 1)]
        return cg.TriMesh(corners, triangles, name=name)
