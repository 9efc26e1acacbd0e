"""Which faces of a body meet along its edges, whether they agree on the free side, where none is.

Every face goes round its edges with itself on the left. Two faces that meet and agree go along
their edge in opposite senses; an edge that faces go along as far one way as the other is closed.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.edge_gaps import image_length
from contiga.geometry.edges import UNTRIMMED, EdgeUse
from contiga.geometry.trim import Loop
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

SAMPLES = 8
"""Of each knot span of a p-curve, times its degree: enough to tell which way a loop runs."""
UNEVEN = 0.02
"""Share of an edge by which the faces on its two sides may differ in length, as chords have it."""


class Joint(NamedTuple):
    """Two patches that meet, and whether they call the same side free."""

    a: int
    b: int
    agree: bool


class Joints(NamedTuple):
    """How the faces of a body meet along its edges."""

    joints: list[Joint]
    open: NDArray[np.bool_]
    """(edges,) where one face ends and no other goes on."""
    crowded: NDArray[np.bool_]
    """(edges,) where more than two faces meet, not in pairs."""


def joints_of(body: Faces) -> Joints:
    """The joints along the edges the body names, from how often and which way each is used."""
    edges = body.edges
    runs = [_loops_left(loops) if loops is not None else [] for loops in body.trims]
    joints: list[Joint] = []
    is_open = np.zeros(len(edges), dtype=bool)
    crowded = np.zeros(len(edges), dtype=bool)
    for k, edge in enumerate(edges):
        uses = edge.uses
        sense = [_sense(use, runs[use.patch]) for use in uses]
        if len(uses) == 2:
            joints.append(Joint(uses[0].patch, uses[1].patch, sense[0] != sense[1]))
        elif len(uses) < 2:
            is_open[k] = True
        else:
            length = np.array(
                [image_length(edge, i, body.patches, body.trims) for i in range(len(uses))]
            )
            opposite = _opposite(length)
            joints += [
                Joint(uses[i].patch, uses[j].patch, sense[i] != sense[j]) for i, j in opposite
            ]
            round_trip = float(np.where(sense, length, -length).sum())
            crowded[k] = not opposite and abs(round_trip) > UNEVEN * length.max()
    return Joints(joints, is_open, crowded)


def _opposite(length: FloatArray) -> list[tuple[int, int]]:
    """Uses that lie opposite each other on an edge: one face may meet several one by one."""
    longest = int(length.argmax())
    others = [i for i in range(len(length)) if i != longest]
    if abs(float(length[others].sum()) - length[longest]) <= UNEVEN * length[longest]:
        return [(longest, i) for i in others]
    return []


def _sense(use: EdgeUse, left: list[bool]) -> bool:
    """Whether a face goes along the edge's curve with itself on the left."""
    if use.loop == UNTRIMMED:
        # Round a rectangle with it on the left: v0 and u1 upward, v1 and u0 downward.
        return (use.index in (1, 2)) != use.reversed
    return left[use.loop] != use.reversed


def _loops_left(loops: tuple[Loop, ...]) -> list[bool]:
    """Whether each loop runs with the face on its left: what counts is the even-odd rule."""
    polygons = [_polygon(loop) for loop in loops]
    low = np.array([polygon.min(axis=0) for polygon in polygons])
    high = np.array([polygon.max(axis=0) for polygon in polygons])
    result = []
    for k, polygon in enumerate(polygons):
        near = np.flatnonzero(((low <= polygon[0]) & (polygon[0] <= high)).all(axis=1))
        within = sum(_holds(polygons[j], polygon[0]) for j in near if j != k)
        x, y = polygon[:, 0] - polygon[0, 0], polygon[:, 1] - polygon[0, 1]
        area = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
        result.append((area > 0.0) == (within % 2 == 0))
    return result


def _polygon(loop: Loop) -> FloatArray:
    """(n, 2) points along a loop."""
    parts = []
    for curve in loop:
        spans = len(np.unique(curve.knots)) - 1
        count = 2 if curve.degree == 1 and spans == 1 else SAMPLES * spans * curve.degree
        parts.append(curve.evaluate(np.linspace(*curve.domain, count))[:-1, :2])
    return np.concatenate(parts)


def _holds(polygon: FloatArray, point: FloatArray) -> bool:
    """Whether a point lies in a polygon, by the crossings of the ray toward growing u."""
    (x, y), (x1, y1) = polygon.T, np.roll(polygon, -1, axis=0).T
    across = (y > point[1]) != (y1 > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x + (point[1] - y) / (y1 - y) * (x1 - x)
    return bool((across & (at > point[0])).sum() % 2)


def turned_faces(n: int, joints: list[Joint]) -> tuple[tuple[int, ...], int]:
    """Faces that call the other side free than the most they are joined to, and joints at odds.

    A flood over the joints of `n` patches gives each piece of the body one orientation; joints
    that contradict it (as on a Moebius strip) are counted.
    """
    links: dict[int, list[tuple[int, bool]]] = defaultdict(list)
    for joint in joints:
        links[joint.a].append((joint.b, joint.agree))
        links[joint.b].append((joint.a, joint.agree))
    way: dict[int, bool] = {}
    turned: list[int] = []
    for first in range(n):
        if first in way:
            continue
        way[first] = True
        piece = [first]
        for patch in piece:
            for other, agree in links[patch]:
                if other not in way:
                    way[other] = way[patch] == agree
                    piece.append(other)
        odd = [patch for patch in piece if not way[patch]]
        turned += odd if 2 * len(odd) <= len(piece) else [p for p in piece if way[p]]
    at_odds = sum((way[j.a] == way[j.b]) != j.agree for j in joints)
    return tuple(sorted(turned)), at_odds
