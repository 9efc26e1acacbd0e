"""The wall that pushes a point, by brute force, and points that wander through solids.

On a closed body a point in contact has a guard g, the unit outward normal of the wall that holds
it. Where the nearest place of the surface has a normal of less than `OPPOSITE` to g, and has become
as near as the foot, that place is the foot, and its normal the guard from then on. Else the foot is
the nearest place of those walls that do not face the other way from g, see the point from behind
and have not been nearer all along; g stays.

Two models say so: of plane faces, by the distance to each polygon, and any other solid by its
closed form, where the nearest place is the foot. A path is followed in many small steps. Nothing
of the search is used but for solids that have no closed form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from tests.stress import parts, shaking, solids, truth
from tests.stress.fields import norm
from tests.stress.outlines import at
from tests.stress.tally import Clock, Tally

import contiga as cg

OPPOSITE = np.cos(np.deg2rad(160.0))
"""Cosine of the angle between two normals from which on their walls are opposite."""
SAME = 1e-9
"""Depths closer than this, relative to the size, are the same."""
CLOSER = 1024
"""Looks at a path that is followed once more, where fewer say something else than contiga."""
FINER = 8
"""How much finer a path is followed to see whether what it comes to hangs on the steps."""
RAY = np.array([0.3141592653589793, 0.2718281828459045, 0.9097])
"""A direction along no edge of any solid here."""


Was = tuple[np.ndarray, np.ndarray]
"""(n, 3) where points were before, and (n,) how deep."""


class Rule(Protocol):
    """What is known of a solid: places on its surface, and the side of points."""

    def inside(self, p: np.ndarray) -> np.ndarray:
        """(n,) which points lie inside."""

    def nearest(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) distance to the surface, (n, 3) the outward normal at the nearest place."""

    def came(self, p: np.ndarray, before: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(n,) whether the wall that is the nearest one at p was no nearer than `depth` before."""

    def behind(self, p: np.ndarray, guard: np.ndarray, least: np.ndarray, was: Was) -> np.ndarray:
        """(n,) distance of at least `least` (n,) to the walls not opposite to `guard` that see p
        from behind, and were no nearer than `was` says before, or NaN."""


# Plane faces.


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


# Any other solid.

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


# A path in small steps.


class Held(NamedTuple):
    """What the rule says of points at the end of their paths."""

    depth: np.ndarray
    """(n,) zero outside; NaN where the nearest wall is opposite, and the model knows no other."""
    guard: np.ndarray
    """(n, 3) zero outside."""


def start(rule: Rule, p: np.ndarray) -> Held:
    """Points that a search by penetration takes: the nearest wall holds them."""
    depth, normal = rule.nearest(p)
    inside = rule.inside(p)
    return Held(np.where(inside, depth, 0.0), np.where(inside[:, None], normal, 0.0))


class Seen(NamedTuple):
    """What is known of places (k, n, 3) on the paths of n points."""

    places: np.ndarray
    inside: np.ndarray
    """(k, n)"""
    distance: np.ndarray
    """(k, n) to the surface."""
    normal: np.ndarray
    """(k, n, 3) at the nearest place of it."""
    entry: np.ndarray
    """(k, n, 3) normal of the wall by which a path came in since the place before, else zero."""


def look(rule: Rule, places: np.ndarray) -> Seen:
    """Sides, nearest places of those inside, and entries."""
    shape, p = places.shape[:2], places.reshape(-1, 3)
    inside = rule.inside(p)
    distance, normal = np.zeros(len(p)), np.zeros((len(p), 3))
    distance[inside], normal[inside] = rule.nearest(p[inside])
    inside, normal = inside.reshape(shape), normal.reshape(*shape, 3)
    return _with_entries(rule, places, inside, distance.reshape(shape), normal)


def _with_entries(rule: Rule, *columns: np.ndarray) -> Seen:
    places, inside, _, normal = columns
    entry = np.zeros_like(normal)
    new = inside[1:] & ~inside[:-1]
    entry[1:][new] = _crossed(rule, places[:-1][new], places[1:][new])
    return Seen(*columns, entry)


def every(rule: Rule, seen: Seen, finer: int) -> Seen:
    """Every so many of the places."""
    return _with_entries(rule, *(values[::finer] for values in seen[:-1]))


def _crossed(rule: Rule, out: np.ndarray, within: np.ndarray) -> np.ndarray:
    """(n, 3) normals of the walls by which ways from outside come in."""
    for _ in range(48 if len(out) else 0):
        middle = 0.5 * (out + within)
        inside = rule.inside(middle)[:, None]
        out, within = np.where(inside, out, middle), np.where(inside, middle, within)
    return rule.nearest(within)[1]


def follow(rule: Rule, seen: Seen, held: Held, *, crossings: bool = True) -> Held:
    """Points along their paths, `held` where these begin.

    By intersection what began inside and has not been out is not in contact. By penetration, not
    by `crossings`, what is inside at the end and was not in contact is held by the nearest wall.
    """
    depth, guard = held.depth.copy(), held.guard.copy()
    began = guard.any(axis=1)
    for k in range(1, len(seen.places)):
        entered = seen.entry[k].any(axis=1)
        guard = np.where(seen.inside[k][:, None], guard, 0.0)
        guard = np.where(entered[:, None], seen.entry[k], guard)
        way = norm(seen.places[k] - seen.places[k - 1])
        least = np.where(entered, 0.0, depth - way * (1.0 + 1e-9) - 1e-12)
        normal, on = seen.normal[k], guard.any(axis=1)
        taken = on & ((normal * guard).sum(axis=1) > OPPOSITE) & (seen.distance[k] >= least)
        was = seen.places[k - 1], np.where(entered, 0.0, depth)
        rows = np.flatnonzero(taken & (was[1] > seen.distance[k - 1]))
        taken[rows] = rule.came(seen.places[k][rows], was[0][rows], was[1][rows])
        guard[taken] = normal[taken]
        depth = np.where(taken, seen.distance[k], 0.0)
        rows = np.flatnonzero(on & ~taken)
        if len(rows):
            own = was[0][rows], was[1][rows]
            depth[rows] = rule.behind(seen.places[k][rows], guard[rows], least[rows], own)
    if not crossings:
        first = ~began & seen.inside[-1]
        guard[first], depth[first] = seen.normal[-1][first], seen.distance[-1][first]
    return Held(depth, guard)


def straight(a: np.ndarray, b: np.ndarray, parts: int) -> np.ndarray:
    """(parts + 1, n, 3) places along segments."""
    return a + np.linspace(0.0, 1.0, parts + 1)[:, None, None] * (b - a)


# Points that wander.


def walk(
    item: Subject, n: int, scale: float, rng: np.random.Generator
) -> Callable[..., np.ndarray]:
    """Steps of about `scale` sizes near a solid; who gets far goes back to where it began."""
    solid = item.solid
    home = shaking.cloud(solid, n, scale, rng)
    low, high = solid.body.bounds()
    home[: n // 4] = rng.uniform(low, high, (n // 4, 3))

    def next_place(p: np.ndarray | None = None) -> np.ndarray:
        if p is None:
            return home
        p = p + scale * solid.size * rng.normal(scale=0.4, size=p.shape)
        lost = truth.values(solid, p) > scale * solid.size
        return np.where(lost[:, None], home, p)

    return next_place


class Judge(NamedTuple):
    """Compares the depths of steps with those of the rule."""

    item: Subject
    crossings: bool
    """Whether the search is by intersection."""
    tally: Tally

    def step(self, states: tuple[cg.State, cg.State], places: np.ndarray, held: Held) -> Held:
        """What to go on with, after a step on the paths `places` (k, n, 3)."""
        (solid, rule), tally, (last, state), p = self.item, self.tally, states, places[-1]
        seen = look(rule, places)
        fine, coarse, once = (
            follow(rule, every(rule, seen, finer), held, crossings=self.crossings)
            for finer in (1, FINER, len(places) - 1)
        )
        within, inside = SAME * solid.size, seen.inside
        known = ~np.isnan(fine.depth)
        # Beside the surface, and where it hangs on short steps what the rule says.
        doubtful = known & ~(np.abs(fine.depth - coarse.depth) <= within)
        doubtful |= np.abs(truth.values(solid, p)) <= truth.BAND * solid.size
        if not self.crossings:
            doubtful |= held.guard.any(axis=1) & inside[-1] & ~inside.all(axis=0)
        # Between two looks a path may leave and come in again.
        apart = norm(p - places[0]) / (len(places) - 1)
        began = ~held.guard.any(axis=1) & inside.all(axis=0)
        doubtful |= began & (seen.distance.min(axis=0) <= apart)
        wrong = known & ~doubtful & ~(np.abs(state.penetration - fine.depth) <= within)
        closer = wrong.copy()
        if wrong.any():
            rows = np.flatnonzero(wrong)
            wrong[rows] = ~self._in_small_steps(places, held, rows, state, within)
        if solid.shape is not None:
            wrong[wrong] = ~truth.at_a_joint(solid, state.foot_B[wrong])
        flagged = np.isin(state.status, shaking.FLAGS)
        own = np.where(state.guard_B.any(axis=1)[:, None], state.guard_B, state.normal_B)
        change = np.abs(state.penetration - last.penetration) - norm(p - places[0])
        jumps = held.guard.any(axis=1) & inside.all(axis=0) & (change > within)
        long = wrong & (np.abs(state.penetration - once.depth) <= within)
        tally.count += len(p)
        tally.doubtful += int(doubtful.sum())
        tally.flagged += int(flagged.sum())
        tally.note("held from afar", int((~known).sum()))
        values = {
            "before": places[0], "point": p, "guard": held.guard, "was": last.penetration,
            "expected": fine.depth, "penetration": state.penetration, "status": state.status,
            "own": own,
        }  # fmt: skip
        kinds = {
            "a long step is not many short ones": long,
            "depth not that of the rule": wrong & ~long,
            "depth jumps": jumps & ~wrong & ~flagged,
        }
        for kind, rows in kinds.items():
            tally.fault(kind, np.flatnonzero(rows), **values)
        anew = (~known | doubtful | closer | flagged)[:, None]
        depth = np.where(anew[:, 0], state.penetration, fine.depth)
        return Held(depth, np.where(anew, own, fine.guard))

    def _in_small_steps(
        self,
        places: np.ndarray,
        held: Held,
        rows: np.ndarray,
        state: cg.State,
        within: float,
    ) -> np.ndarray:
        """Which of some rows, on straight paths, are right by looks that are much closer."""
        seen = look(self.item.rule, straight(places[0, rows], places[-1, rows], CLOSER))
        own = Held(held.depth[rows], held.guard[rows])
        depth = follow(self.item.rule, seen, own, crossings=self.crossings).depth
        right = np.abs(state.penetration[rows] - depth) <= within
        self.tally.note("followed in small steps", int(right.sum()))
        return np.asarray(right)


def wander(item: Subject, scale: float, n: int, steps: int, seed: Sequence[int]) -> Tally:
    """One cloud of points about one body, in steps of about `scale` sizes."""
    solid, rule = item
    rng = np.random.default_rng(seed)
    with Clock(Tally(f"rule, {solid.name}")) as tally:
        next_place = walk(item, n, scale, rng)
        p, X_WB = next_place(), shaking.pose(solid, 1.0, rng)
        search = "penetration" if seed[-1] % 4 == 3 else "intersection"
        slave = cg.Slave(p, area=np.ones(n))
        contact = cg.Contact(solid.body, slave, law=cg.PenaltyLaw(1.0), search=search)
        state = contact.start(cg.motion.pose.apply(X_WB, p), X_WB)
        judge = Judge(item, search == "intersection", tally)
        held = Held(np.zeros(n), np.zeros((n, 3))) if judge.crossings else start(rule, p)
        for _ in range(steps):
            before, last, p = p, state, next_place(p)
            state = contact.step(last, cg.motion.pose.apply(X_WB, p), X_WB)
            held = judge.step((last, state), straight(before, p, 64), held)
    return tally


def wandered(item: Subject, scales: np.ndarray, n: int, steps: int, seed: int) -> Tally:
    """One body at all scales."""
    whole = Tally(f"rule, {item.solid.name}")
    for k, scale in enumerate(scales):
        whole.add(wander(item, float(scale), n, steps, (seed, k)))
    return whole
