"""The wall that pushes a point, by brute force.

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

from typing import NamedTuple, Protocol

import numpy as np
from tests.stress.fields import norm

OPPOSITE = np.cos(np.deg2rad(160.0))
"""Cosine of the angle between two normals from which on their walls are opposite."""


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


def _with_entries(
    rule: Rule, places: np.ndarray, inside: np.ndarray, distance: np.ndarray, normal: np.ndarray
) -> Seen:
    """Add to places on paths the normals of the walls by which the paths come in."""
    entry = np.zeros_like(normal)
    new = inside[1:] & ~inside[:-1]
    entry[1:][new] = _crossed(rule, places[:-1][new], places[1:][new])
    return Seen(places, inside, distance, normal, entry)


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
